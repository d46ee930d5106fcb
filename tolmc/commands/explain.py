"""`tolmc explain` and `tolmc schema`: the study file, field by field, from the models that read it."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator
from difflib import get_close_matches
from functools import cache
from typing import Any

from tolmc import quantities
from tolmc.allocation.study_table import AllocationSection, ChoiceSection
from tolmc.errors import InputError
from tolmc.quantities import OUTPUTS, SCALARS
from tolmc.study.drawing import MODEL_NAMES
from tolmc.study.guide import FieldGuide, NamedTables, TableGuide, guide, json_schema

_WIDTH = 100
#: Tolerances and limits as a study has them, by the name of a quantity or, for all others, by what it measures.
_TOLERANCES = {
    "length": '"±0.05 mm"', "mass": '"±5 g"', "angle": '"±2 deg"', "frequency": '"±0.5 Hz"', "angular velocity": '"±30 rpm"',
    "force": '"±50 N"', "torque": '"±0.02 N m"', "rate": '{ tolerance = "0.5 1/s" }', "acceleration": '"±0.05 m/s^2"',
    "contact stiffness": '{ tolerance = "2e8 N/m^1.5" }', "inertia": '"±5 kg mm^2"', "speed": '"±0.01 m/s"',
    "wear coefficient": '{ tolerance = "2e-7 mm^3/(N m)" }', "temperature": '"±10 K"',
    "expansion": '{ tolerance = "1e-6 1/K" }',
    "bearing_radius": '"20 ±0.05 mm"', "journal_radius": '"19.8 +0/-0.03 mm"', "half_length": '"20 ±0.1 mm"',
    "slip_speed": '"±0.2 mm/s"', "friction": "{ tolerance = 0.03 }", "restitution": "{ tolerance = 0.1 }",
    "slope_x": "{ tolerance = 0.001 }", "slope_y": "{ tolerance = 0.001 }",
}  # fmt: skip
_LIMITS = {
    "length": 'max = "0.5 mm"', "angle": 'max = "0.5 deg"', "force": 'max = "50 N"', "torque": 'max = "0.2 N m"',
    "speed": 'max = "0.1 m/s"', "impulse": 'max = "0.05 N s"', "energy": 'max = "2 J"', "power": 'max = "5 W"',
    "angular velocity": 'max = "20 rad/s"', "volume rate": 'max = "0.5 mm^3/h"', "time": 'min = "0.5 s"', "count": "max = 20",
    "share": 'max = "5 %"', "error": "max = 1e-6", "component": "max = 0.1",
    "operating_bearing_radius": 'max = "20.1 mm"', "operating_journal_radius": 'min = "19.7 mm"',
    "operating_half_length": 'min = "19.9 mm"', "contact_force_D_min": 'min = "1 N"', "contact_force_E_min": 'min = "1 N"',
    "closed_share_D": 'min = "90 %"', "closed_share_E": 'min = "90 %"', "spin_end": 'min = "1450 rpm"',
    "impact_energy_loss": 'max = "0.05 J"', "impact_force_D_max": 'max = "2 kN"', "impact_force_E_max": 'max = "2 kN"',
}  # fmt: skip


@cache
def study_schema() -> dict[str, Any]:
    """JSON schema of the whole study file."""
    return json_schema(AllocationSection, NamedTables("allocation.dimensions", (*MODEL_NAMES, *SCALARS), ChoiceSection))


def explain(word: str | None) -> str:
    """What a field, a table, a dimension or an output is; without a word, what there is.

    Raises
    ------
    InputError
        When nothing is called so; the message names what comes close.
    """
    tables = guide(study_schema())
    if word is None:
        return "\n".join(_contents(tables))
    asked = word.strip().strip("[").replace("] ", ".").replace("]", "").strip(".")
    found = [*_quantity(asked), *_of_tables(tables, asked)] or [*_of_entry(tables, asked)]
    if not found:
        close = get_close_matches(asked, _all_names(tables), 3, 0.5)
        near = f"; did you mean {' or '.join(repr(name) for name in close)}?" if close else "."
        raise InputError(
            f"nothing in a study file is called {word!r}{near} 'tolmc explain' lists all tables; "
            "'tolmc explain outputs' says how an output of the study's own is named."
        )
    return "\n\n".join(found)


def markdown() -> str:
    """The whole study file as Markdown."""
    tables = guide(study_schema())
    return "\n".join(_markdown(tables)) + "\n"


def _contents(tables: list[TableGuide]) -> Iterator[str]:
    yield "A study file has these tables and fields. More about one of them: tolmc explain FIELD, such as body.mass."
    for table in tables:
        names = [field.name for field in table.fields]
        yield ""
        yield f"[{table.name}]{_required(table)}" if table.name else "at the top"
        if table.meaning:
            yield textwrap.indent(textwrap.fill(table.meaning, _WIDTH), "  ")
        if names:
            yield textwrap.fill(", ".join(names), _WIDTH, initial_indent="  Fields: ", subsequent_indent="    ")
        if table.names:
            yield textwrap.fill(", ".join(table.names), _WIDTH, initial_indent="  NAME: ", subsequent_indent="    ")


def _quantity(name: str) -> Iterator[str]:
    """What a dimension or an output is, where the word is its name."""
    name = name.split(".")[-1]
    if not quantities.is_known(name):
        return
    shown, _ = quantities.shown(name)
    what = f"{name}: {quantities.label(name)}" + (f", shown in {shown}" if shown else "") + "."
    kind = quantities.of(name).kind
    if name in MODEL_NAMES:
        half = f"the model takes {MODEL_NAMES[name]}, half of it"
        yield f'{what}\n  As on the drawing: [dimensions] {name} = "40 ±0.05 mm"; {half}.'
    elif name in SCALARS:
        yield f"{what}\n  May have a tolerance: [dimensions] {name} = {_TOLERANCES.get(name) or _TOLERANCES[kind]}"
    elif name in OUTPUTS:
        yield f"{what}\n  An output; may have limits: [specification] {name} = {{ {_LIMITS.get(name) or _LIMITS[kind]} }}"


def _of_tables(tables: list[TableGuide], asked: str) -> Iterator[str]:
    """The tables and fields that are called so."""
    for table in tables:
        if table.name and asked in (table.name, table.name.rsplit(".", 1)[-1]):
            yield "\n".join(_contents([table])).split("\n\n", 1)[-1].strip()
        for field in table.fields:
            if asked in (field.name, f"{table.name}.{field.name}".lstrip(".")):
                yield _field_text(field)


def _of_entry(tables: list[TableGuide], asked: str) -> Iterator[str]:
    """The table of an entry that has a name of the study's choice or a quantity's, such as specification.sag."""
    outer = asked.rpartition(".")[0]
    if outer in ("dimensions", "specification"):
        yield from _of_tables(tables, f"{outer}.NAME")


def _field_text(field: FieldGuide) -> str:
    meaning = textwrap.indent(textwrap.fill(field.meaning, _WIDTH), "  ")
    return f"{field.place}\n{meaning}\n  {field.written[0].upper()}{field.written[1:]}; {field.need}."


def _all_names(tables: list[TableGuide]) -> list[str]:
    names = {*MODEL_NAMES, *SCALARS, *OUTPUTS}
    for table in tables:
        names |= {table.name, *(field.name for field in table.fields)}
        names |= {f"{table.name}.{field.name}".lstrip(".") for field in table.fields}
    return sorted(names - {""})


def _markdown(tables: list[TableGuide]) -> Iterator[str]:
    yield "# The study file"
    yield ""
    yield "Made by `tolmc explain --markdown` from the models that read a study; `tolmc explain FIELD` shows one field,"
    yield "`tolmc schema > study.schema.json` is what an editor completes and checks a study from (Even Better TOML: a first"
    yield "line `#:schema study.schema.json`), and `tolmc init NAME.toml --kind shaft` writes a study to begin with."
    yield ""
    yield 'A number is in SI units, a text carries its unit: `"20 mm"`, `"-110 deg"`, `"1500 rpm"`, `"12 N"`. `NAME` stands for'
    yield "the name of a dimension or output."
    for table in tables:
        yield ""
        yield f"## `[{table.name}]`{_required(table)}" if table.name else "## At the top"
        yield ""
        if table.meaning:
            yield table.meaning
        if table.fields:
            yield from ("", "| field | what it means | what may stand there | when not given |", "|---|---|---|---|")
        for field in table.fields:
            default = "**required**" if field.default is None else f"`{field.default}`" if field.default else "–"
            yield f"| `{field.name}` | {_cell(field.meaning)} | {_cell(field.written)} | {default} |"
        if table.names and table.name in ("dimensions", "specification"):
            yield from ("", "| NAME | what it is | unit |", "|---|---|---|")
            for name in table.names:
                yield f"| `{name}` | {_cell(quantities.label(name))} | {quantities.shown(name)[0] or '–'} |"


def _required(table: TableGuide) -> str:
    return ", required" if table.is_required else ""


def _cell(text: str) -> str:
    return text.replace("|", "\\|")
