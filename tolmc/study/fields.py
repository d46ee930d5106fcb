"""Types of the fields of a study file, and the sentences about fields that cannot be used.

Pydantic checks; what it finds is put into our words: the field, its value, what is allowed, what to do.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import datetime
from difflib import get_close_matches
from inspect import getsource
from itertools import chain, islice, pairwise
from reprlib import Repr
from typing import Annotated, Any, TypeVar, cast, get_args

from pydantic import BaseModel, BeforeValidator, ConfigDict, GetJsonSchemaHandler, ValidationError, ValidationInfo
from pydantic.fields import FieldInfo
from pydantic_core import CoreSchema

from tolmc import quantities, units

_Table = TypeVar("_Table", bound="Section")


class Section(BaseModel):
    """A table of a study file; unknown fields are refused. The text below a field says what it means."""

    model_config = ConfigDict(extra="forbid")

    @classmethod
    def __get_pydantic_json_schema__(cls, core_schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        schema = handler(core_schema)
        properties = handler.resolve_ref_schema(schema).get("properties", {})
        for name, text in cls._texts().items():
            properties[name]["description"] = text
        return schema

    @classmethod
    def _texts(cls) -> dict[str, str]:
        """The texts below the fields, which only schemas have: read with every study they take 40 ms."""
        sections = [section for section in reversed(cls.__mro__) if issubclass(section, Section)]
        bodies = (cast(ast.ClassDef, ast.parse(getsource(section)).body[0]).body for section in sections)
        return {
            field.target.id: text.value.value
            for field, text in chain.from_iterable(map(pairwise, bodies))
            if isinstance(field, ast.AnnAssign)
            and isinstance(field.target, ast.Name)
            and isinstance(text, ast.Expr)
            and isinstance(text.value, ast.Constant)
            and isinstance(text.value.value, str)
        }


class Faults(Exception):
    """What is wrong with a file, a sentence each."""

    def __init__(self, *sentences: str) -> None:
        super().__init__(*sentences)
        self.sentences = sentences


@dataclass(frozen=True, eq=False)
class Form:
    """How the value of a field is written: for people, and as a JSON schema for editors.

    Attributes
    ----------
    words : what may stand there
    schema : the same as JSON schema, to which the words are a comment
    remedy : what to do where the field is missing
    """

    words: str
    schema: Mapping[str, Any]
    remedy: str = "add it"

    def __get_pydantic_json_schema__(self, core_schema: object, handler: object) -> dict[str, Any]:
        return {**self.schema, "$comment": self.words}


#: In a schema: a quantity in the unit that belongs to the name of its table.
OWN_UNIT = {"x-unit": "own"}


def form(info: FieldInfo) -> Form | None:
    """How the value of a field of a model is written, where its type says so."""
    optional = (part for union in get_args(info.annotation) for part in getattr(union, "__metadata__", ()))
    return next((part for part in (*info.metadata, *optional) if isinstance(part, Form)), None)


def quantity_schema(
    unit: str, *, positive: bool = False, least: float | None = None, most: float | None = None
) -> dict[str, Any]:
    """JSON schema of a quantity in the SI unit ``unit``."""
    schema = {"type": ["number", "string"], "examples": [units.example(unit)]}
    ends = {"exclusiveMinimum": 0 if positive else None, "minimum": least, "maximum": most}
    return schema | {name: end for name, end in ends.items() if end is not None}


def material(table: Mapping[str, float], unit: str):
    """Type of a property in the SI unit ``unit``: a quantity, or the name of a material in ``table``."""

    def read(value: Any) -> float:
        if isinstance(value, str) and value in table:
            return table[value]
        if isinstance(value, str) and not any(character.isdigit() for character in value):
            raise ValueError(
                f"no material of the table{suggestion(value, table) or ';'} allowed: {', '.join(table)}, or "
                f"{units.remedy(unit).removeprefix('give ')}"
            )
        return units.read(value, unit)

    schema = {"anyOf": [{"enum": list(table)}, quantity_schema(unit)]}
    return Annotated[
        float, BeforeValidator(read), Form(f"{units.kind(unit)}, or a material: {', '.join(table)}", schema)
    ]


def _three(item: Mapping[str, Any]) -> dict[str, Any]:
    return _several(item, 3)


def _several(item: Mapping[str, Any], count: int) -> dict[str, Any]:
    return {"type": "array", "items": dict(item), "minItems": count, "maxItems": count}


def quantity(
    unit: str,
    *,
    positive: bool = False,
    least: float | None = None,
    most: float | None = None,
    example: str = "",
    remedy: str | None = None,
):
    """Type of a field in the SI unit ``unit``; ``least`` and ``most``: the smallest and the largest value allowed."""

    shown = example or (f'"{units.example(unit)}"' if unit != "1" else "")
    ends = [
        *(["> 0"] if positive else []),
        *([] if least is None else [f"of at least {least:g} {unit}".removesuffix(" 1") if least else ">= 0"]),
        *([] if most is None else [f"at most {most:g} {unit}".removesuffix(" 1")]),
    ]
    words = f"{' '.join([units.kind(unit), ' and '.join(ends)]).rstrip()}{f', such as {shown}' if shown else ''}"

    def read(value: object) -> float:
        number = units.read(value, unit)
        below = (positive and number <= 0) or (least is not None and number < least)
        if below or (most is not None and number > most):
            raise ValueError(f"expected {words}")
        return number

    return Annotated[
        float,
        BeforeValidator(read),
        Form(words, quantity_schema(unit, positive=positive, least=least, most=most), remedy or units.remedy(unit)),
    ]


def whole(lowest: int, highest: int):
    """Type of a whole number in a range; strings carry units, and a count has none."""

    def read(value: Any) -> int:
        if isinstance(value, str):
            raise ValueError(f"expected a whole number from {lowest} to {highest}; write it without quotes")
        is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
        if not is_number or not lowest <= value <= highest or value != int(value):
            raise ValueError(f"expected a whole number from {lowest} to {highest}")
        return int(value)

    schema = {"type": "integer", "minimum": lowest, "maximum": highest}
    words = f"a whole number from {lowest}" + (f" to {highest:,}" if highest < 2**63 - 1 else "")
    return Annotated[int, BeforeValidator(read), Form(words, schema)]


def share(low: float, example: str = "0.9973 or '99.73 %'"):
    """Type of a share between ``low`` and 1."""

    def read(value: object) -> float:
        number = units.read(value, "1")
        if not low < number < 1.0:
            raise ValueError(f"expected {words}")
        return number

    words = f"a share between {low:g} and 1, such as {example}"
    return Annotated[float, BeforeValidator(read), Form(words, {"type": ["number", "string"]})]


def vector(unit: str):
    """Type of a vector [x, y, z] in the SI unit ``unit``."""

    def read(value: object) -> tuple[float, float, float]:
        if not isinstance(value, list) or len(value) != 3:
            raise ValueError(f"expected three values [x, y, z]; for each {units.remedy(unit)}")
        x, y, z = (units.read(v, unit) for v in value)
        return x, y, z

    words = f'three values [x, y, z], each {units.kind(unit)}, such as "{units.example(unit)}"'
    return Annotated[tuple, BeforeValidator(read), Form(words, _three(quantity_schema(unit)))]


def pair(unit: str):
    """Type of a pair [x, y] in the SI unit ``unit``."""

    def read(value: object) -> tuple[float, float]:
        if not isinstance(value, list) or len(value) != 2:
            raise ValueError(f"expected two values [x, y]; for each {units.remedy(unit)}")
        x, y = (units.read(v, unit) for v in value)
        return x, y

    words = f"two values [x, y], each {units.kind(unit)}"
    return Annotated[tuple, BeforeValidator(read), Form(words, _several(quantity_schema(unit), 2))]


def _read_inertia(value: object) -> tuple:
    if not isinstance(value, list) or len(value) != 3:
        raise ValueError("expected three moments of inertia or a 3x3 matrix, in kg m^2 or with units")
    if all(isinstance(row, list) and len(row) == 3 for row in value):
        return tuple(tuple(units.read(v, "kg m^2") for v in row) for row in value)
    return tuple(units.read(v, "kg m^2") for v in value)


_MOMENT = quantity_schema("kg m^2")

#: Type of an inertia: three moments or a 3x3 matrix.
Inertia = Annotated[
    tuple,
    BeforeValidator(_read_inertia),
    Form(
        "three moments of inertia, or a 3x3 matrix of them",
        {"anyOf": [_three(_MOMENT), _three(_three(_MOMENT))]},
    ),
]


@dataclass(frozen=True)
class OwnUnit:
    """In which SI unit the quantities of a table are read, and which share of what is written the model takes.

    The context in which a table that serves several quantities is validated.
    """

    unit: str
    share: float = 1.0

    @classmethod
    def of(cls, name: str) -> OwnUnit:
        """Of a table that is named after a quantity: half of what a drawing gives twice."""
        return cls(quantities.unit(name), 1.0 / quantities.of(name).times)

    def read(self, value: object) -> float:
        """A value in the model's quantity, SI unit."""
        return self.share * units.read(value, self.unit)

    def read_difference(self, value: object) -> float:
        """A difference of two such values."""
        return self.share * units.read(value, units.difference(self.unit))


def own_unit(info: ValidationInfo) -> OwnUnit:
    """The unit of the table that is being validated."""
    return cast(OwnUnit, info.context)


def _read_own(value: object, info: ValidationInfo) -> float:
    return own_unit(info).read(value)


def own(remedy: str = "add it"):
    """Type of a quantity whose SI unit is the context of the validation, for tables that serve several quantities."""
    return Annotated[float, BeforeValidator(_read_own), Form("a quantity of NAME's kind", OWN_UNIT, remedy)]


Own = own()


def _read_own_difference(value: object, info: ValidationInfo) -> float:
    return own_unit(info).read_difference(value)


#: Type of a spread of such a quantity: of a temperature in °C, a difference in K.
OwnDifference = Annotated[
    float, BeforeValidator(_read_own_difference), Form("a spread of what the table's name is", OWN_UNIT)
]


def validated(model: type[_Table], table: object, *where: str, context: OwnUnit | None = None) -> _Table:
    """The table as ``model``; Faults with a sentence for each field that cannot be used."""
    try:
        return model.model_validate(table, context=context)
    except ValidationError as error:
        raise Faults(*(_sentence(model, item, where) for item in error.errors(include_url=False))) from None


@contextmanager
def in_section(*where: str, written: object = None) -> Iterator[None]:
    """Errors of the objects that a section describes become Faults that name the section, and what is ``written`` there."""
    try:
        yield
    except (ValueError, TypeError, ArithmeticError) as error:
        stands = "" if written is None else f" = {short(written)}"
        raise Faults(f"{place(*where)}{stands}: {str(error).rstrip('.')}.") from None


def check_names(table: Mapping[str, object], allowed: Iterable[str], *where: str) -> None:
    """Faults where the table has a name that is not allowed."""
    allowed = tuple(allowed)
    unknown = [name for name in table if name not in allowed]
    if unknown:
        raise Faults(*(_unknown(place(*where, name), name, table[name], allowed) for name in unknown))


def place(*where: str | int) -> str:
    """A field as the file shows it: ``[body] solid_cylinder.radius``."""
    section, *fields = (str(part) for part in where)
    return f"[{section}] {'.'.join(fields)}".rstrip()


#: Other names of what a study may say, in lower case.
_SYNONYMS = {
    "gaussian": "normal", "gauss": "normal", "rectangular": "uniform", "flat": "uniform", "triangle": "triangular",
    "lhs": "latin_hypercube", "lhc": "latin_hypercube", "latin": "latin_hypercube", "monte_carlo": "random", "mc": "random",
    "qmc": "sobol", "rk": "rk8", "dop853": "rk8", "bore": "bearing_radius", "shaft": "journal_radius", "com": "center_of_mass",
    "centre_of_mass": "center_of_mass", "cog": "center_of_mass", "std": "sd", "stdev": "sd", "median": "q50",
}  # fmt: skip


def suggestion(word: str, allowed: Iterable[str]) -> str:
    """``; did you mean 'mass'?`` where something allowed is close or has that other name, otherwise nothing."""
    known = {name.casefold(): name for name in allowed}
    plain = re.sub(r"[\s-]+", "_", word.strip().casefold())
    close = [name for name in (_SYNONYMS.get(plain, plain),) if name in known] or get_close_matches(plain, known, 1)
    close = close or [name for name in known if len(plain) > 2 and name.startswith(plain)]
    return f"; did you mean {known[close[0]]!r}?" if close else ""


def choices(word: str, allowed: Iterable[str], listed: str = "") -> str:
    """What is meant and what is allowed in place of a word, to go behind "is unknown"; ``listed``: the allowed in words."""
    names = list(allowed)
    close = suggestion(word, names)
    return f"{f'{close} Allowed' if close else '; allowed'}: {listed or ', '.join(names)}"


class _Toml(Repr):
    """Values in a study's own notation, cut where they are long."""

    def __init__(self) -> None:
        super().__init__()
        self.maxstring = self.maxother = self.maxlong = 60

    def repr_bool(self, value: bool, level: int) -> str:
        return str(value).lower()

    def repr_dict(self, value: dict, level: int) -> str:
        shown = [f"{key} = {self.repr1(item, level - 1)}" for key, item in islice(value.items(), self.maxdict)]
        return f"{{ {', '.join([*shown, *(['...'] if len(value) > self.maxdict else [])])} }}" if value else "{}"

    def repr_datetime(self, value: datetime, level: int) -> str:
        return value.isoformat()

    repr_date = repr_time = repr_datetime


def short(value: object) -> str:
    """A value as an error message shows it."""
    return _Toml().repr(value)


def _unknown(field: str, name: str, value: object, allowed: tuple[str, ...]) -> str:
    shown = field if isinstance(value, dict) else f"{field} = {short(value)}"
    return f"{shown} is unknown{choices(name, allowed)}."


def _sentence(model: type[Section], item: Mapping[str, Any], where: tuple[str, ...]) -> str:
    loc = [part for part in item["loc"] if not str(part).startswith(("function-", "literal["))]
    field = place(*where, *loc) if where or len(loc) > 1 else str(loc[0])
    kind = item["type"]
    if kind == "missing":
        if not where and len(loc) == 1 and loc[0] in _EXAMPLES:
            return f"[{field}] is missing; add it with all it needs, [{field}] and below it such as {_EXAMPLES[field]}."
        written = form(_owner(model, loc).model_fields[loc[-1]])
        return f"{field} is missing; {written.remedy if written else 'add it'}."
    if kind == "extra_forbidden":
        return _unknown(field, str(loc[-1]), item["input"], tuple(_owner(model, loc).model_fields))
    value = short(item["input"])
    if kind == "value_error":
        return f"{field} = {value}: {item['ctx']['error']}."
    if kind == "literal_error":
        allowed = item["ctx"]["expected"]
        words = allowed.replace("'", "").replace(" or ", ", ").split(", ") if isinstance(item["input"], str) else ()
        return f"{field} = {value} is not possible{choices(str(item['input']), words, allowed)}."
    if kind in ("model_type", "dict_type"):
        return f"{field} = {value}: expected a table{_example(loc)}."
    expected = {"string_type": "a text in quotes", "bool_type": "true or false", "list_type": "a list in brackets"}
    return f"{field} = {value}: expected {expected.get(kind, item['msg'])}."


#: What a table holds, for those who wrote something else in its place.
_EXAMPLES = {
    "dimensions": 'bearing_radius = { nominal = "20 mm", tolerance = "0.05 mm" }',
    "body": 'mass = "0.5 kg"',
    "loads": 'gravity = [0, "-9.81 m/s^2", 0]',
    "motion": 'alpha = "-110 deg"',
    "model": 'section = "exact"',
    "monte_carlo": "samples = 100000",
    "correlation": "bearing_radius.journal_radius = 0.5",
    "specification": 'tilt_angle = { max = "25 deg" }',
    "solid_cylinder": 'radius = "30 mm", length = "100 mm"',
    "until": 'output = "contact_force_D_max", statistic = "mean", width = "0.01 N"',
    "arguments": 'loc = "20 mm", scale = "0.01 mm"',
}


def _example(loc: list) -> str:
    if not loc:
        return ', such as { max = "25 deg" }'
    example = _EXAMPLES.get(str(loc[-1]))
    if example is None:
        return ""
    return (
        f", such as {{ {example} }}"
        if len(loc) > 1 or loc[-1] == "arguments"
        else f": [{loc[-1]}] and below it {example}"
    )


def _owner(model: type[Section], loc: list) -> type[Section]:
    """The table in which the field at ``loc`` stands."""
    for part in loc[:-1]:
        if isinstance(part, int):  # of a list, whose tables are all of one kind
            continue
        annotation = model.model_fields[part].annotation
        model = next(m for m in (annotation, *get_args(annotation)) if isinstance(m, type) and issubclass(m, Section))
    return model
