"""What a study file may hold, read from the models of its tables: a JSON schema for editors, and the fields for people."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, cast

from pydantic import BaseModel
from pydantic.json_schema import models_json_schema

from tolmc import quantities, units
from tolmc.study.drawing import MODEL_NAMES
from tolmc.study.fields import OWN_UNIT, Section, quantity_schema
from tolmc.study.sections import DimensionSection, DimensionsSection, LimitsSection, SpecificationSection, StudyFile


@dataclass(frozen=True)
class NamedTables:
    """A table whose entries are named after quantities, such as [dimensions].

    Attributes
    ----------
    place : the table, such as "allocation.dimensions"
    names : what its entries may be called
    entry : model of an entry
    model : its other fields, and what it is for
    more : whether a study may have names of its own beside these
    """

    place: str
    names: tuple[str, ...]
    entry: type[Section]
    model: type[Section] | None = None
    more: bool = False


#: Those of this folder's models; [allocation] has one more.
NAMED_TABLES = (
    NamedTables("dimensions", (*MODEL_NAMES, *quantities.SCALARS), DimensionSection, DimensionsSection),
    NamedTables("specification", quantities.OUTPUTS, LimitsSection, SpecificationSection, more=True),
)


@dataclass(frozen=True)
class FieldGuide:
    """A field: what it means, how it is written, and what it is when it is not given (as TOML; None where it must be).

    ``table`` is where it stands; NAME in it stands for the name of a quantity.
    """

    table: str
    name: str
    meaning: str
    written: str
    default: str | None

    @property
    def place(self) -> str:
        """As error messages name it: "[body] mass"."""
        return f"[{self.table}] {self.name}" if self.table else self.name

    @property
    def need(self) -> str:
        """Whether it has to be given, and what it is where it is not."""
        if self.default is None:
            return "required"
        return f"{self.default} when not given" if self.default else "optional"


@dataclass(frozen=True)
class TableGuide:
    """A table, whether a study must have it, its fields, and the quantities that its further entries are named after."""

    name: str
    meaning: str
    is_required: bool
    fields: tuple[FieldGuide, ...]
    names: tuple[str, ...] = ()


def json_schema(allocation: type[Section], choices: NamedTables) -> dict[str, Any]:
    """JSON schema (draft 2020-12) of the study file, with the [allocation] table that a layer above reads."""
    named = (*NAMED_TABLES, choices)
    models = [StudyFile, allocation, *(model for table in named for model in (table.entry, table.model) if model)]
    _, schema = models_json_schema([(cast(type[BaseModel], model), "validation") for model in models])
    definitions = _plain(schema["$defs"])
    file = definitions.pop(StudyFile.__name__)
    file["properties"]["allocation"] = {"$ref": f"#/$defs/{allocation.__name__}"}
    whole = {"$schema": "https://json-schema.org/draft/2020-12/schema", **file, "$defs": definitions}
    for table in named:
        _add_names(whole, table)
    for table in named:
        definitions.pop(table.entry.__name__)
    return whole


def guide(schema: Mapping[str, Any]) -> list[TableGuide]:
    """The tables of a schema from :func:`json_schema`, in the order of the file."""
    return list(_tables(schema, "", schema, is_required=True))


def _plain(schema: Any) -> Any:
    """The schema without what TOML does not have (null) and nobody reads (titles of fields)."""
    if isinstance(schema, list):
        return [_plain(part) for part in schema]
    if not isinstance(schema, dict):
        return schema
    schema = {key: _plain(part) for key, part in schema.items() if not (key == "title" and isinstance(part, str))}
    if "anyOf" in schema:
        kinds = [kind for kind in schema["anyOf"] if kind != {"type": "null"}]
        schema = {key: part for key, part in schema.items() if key != "anyOf"}
        schema |= {"anyOf": kinds} if len(kinds) > 1 else kinds[0]
    if "description" in schema and isinstance(schema["description"], str):
        schema["description"] = " ".join(schema["description"].split())
    return {key: part for key, part in schema.items() if not (key == "default" and part is None)}


def _add_names(schema: dict[str, Any], table: NamedTables) -> None:
    """A field for each name, with the table of its unit."""
    *outer, last = table.place.split(".")
    owner: Any = schema
    for part in outer:
        owner = _resolved(schema, owner["properties"][part])
    place = owner["properties"][last]
    if table.model is not None:
        place = owner["properties"][last] = dict(schema["$defs"].pop(table.model.__name__))
    more = _in_unit(schema["$defs"][table.entry.__name__], None) if table.more else False
    place |= {"type": "object", "additionalProperties": more, "x-names": list(table.names)}
    fields = place.setdefault("properties", {})
    for name in table.names:
        unit = quantities.unit(name)
        entry = f"{table.entry.__name__}_{quantities.of(name).kind.replace(' ', '_')}"
        if entry not in schema["$defs"]:
            schema["$defs"][entry] = _in_unit(schema["$defs"][table.entry.__name__], unit)
        shown, _ = quantities.shown(name)
        fields[name] = {
            "anyOf": [{"$ref": f"#/$defs/{entry}"}, *([_size_schema(unit)] if table.place == "dimensions" else [])],
            "description": quantities.label(name) + (f" ({shown})" if shown else ""),
        }


def _size_schema(unit: str) -> dict[str, Any]:
    """A dimension that needs no table: its size in one text, or a plain number."""
    example = str(units.example(unit))
    return quantity_schema(unit) | {"examples": ["40 ±0.05 mm", "⌀40 H7"] if unit == "m" else [f"±{example}"]}


def _in_unit(schema: Any, unit: str | None) -> Any:
    """The schema of an entry, for a quantity in this unit; in any where it is None."""
    if isinstance(schema, list):
        return [_in_unit(part, unit) for part in schema]
    if not isinstance(schema, dict):
        return schema
    found = {key: _in_unit(part, unit) for key, part in schema.items()}
    if not OWN_UNIT.items() <= schema.items():
        return found
    return {**found, **({"type": ["number", "string"]} if unit is None else quantity_schema(unit))}


def _resolved(schema: Mapping[str, Any], part: Mapping[str, Any]) -> Mapping[str, Any]:
    if "$ref" not in part:
        return part
    return schema["$defs"][part["$ref"].rsplit("/", 1)[1]]


def _tables(
    schema: Mapping[str, Any], place: str, table: Mapping[str, Any], *, is_required: bool
) -> Iterator[TableGuide]:
    names = tuple(table.get("x-names", ()))
    own = {name: part for name, part in table.get("properties", {}).items() if name not in names}
    inner = {name: _resolved(schema, _table_of(part)) for name, part in own.items()}
    inner = {name: part for name, part in inner.items() if "properties" in part}
    required = table.get("required", ())
    fields = tuple(
        FieldGuide(place, name, part.get("description", ""), _written(part), _default(part, name in required))
        for name, part in own.items()
        if name not in inner or _table_of(part) is not part
    )
    yield TableGuide(place, table.get("description", ""), is_required, fields, names)
    if names:
        entry = _resolved(schema, table["properties"][names[0]]["anyOf"][0])
        yield from _tables(schema, f"{place}.NAME", entry, is_required=False)
    for name, part in inner.items():
        yield from _tables(schema, f"{place}.{name}".lstrip("."), part, is_required=name in required)


def _table_of(part: Mapping[str, Any]) -> Mapping[str, Any]:
    """The table that may stand in a field, or that its list is of; the field itself where there is no such."""
    kinds = [*part.get("anyOf", ()), part.get("items", {})]
    return next((kind for kind in kinds if "$ref" in kind), part)


def _written(part: Mapping[str, Any]) -> str:
    if "$ref" in part:
        return "a table"
    if "$comment" in part:
        return part["$comment"]
    if "anyOf" in part:
        return ", or ".join(_written(kind) for kind in part["anyOf"])
    words = [json.dumps(word) for word in part.get("enum", [part["const"]] if "const" in part else [])]
    if tuple(part.get("enum", ())) == quantities.OUTPUTS:
        return "the name of an output"
    if words:
        return " or ".join([", ".join(words[:-1]), words[-1]] if words[1:] else words)
    if part.get("type") == "array":
        return f"a list, each {_written(part['items'])}"
    return {"string": "a text", "boolean": "true or false", "object": "a table"}[part["type"]]


def _default(part: Mapping[str, Any], is_required: bool) -> str | None:
    if is_required:
        return None
    return json.dumps(part["default"]) if "default" in part else ""
