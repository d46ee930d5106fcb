"""Dimensions and constants of a study, as drawn and as the model takes them."""

from __future__ import annotations

import math
import re

import pandas as pd

from tolmc import quantities
from tolmc.study.study import Study
from tolmc.tables.table import Cell, Column, Number, Table, cells, typeset
from tolmc.text.numbers import NOTHING
from tolmc.text.phrases import distribution, quantity
from tolmc.text.typeset import deviations, number, span
from tolmc.tolerances import fits
from tolmc.tolerances.dimension import Dimension

#: Dimensions that a drawing gives twice as large as the model, with the sign before it.
_DRAWN_TWICE = {"bearing_radius": "⌀", "journal_radius": "⌀", "half_length": ""}


def dimensions_table(study: Study) -> Table:
    """Nominal values, limits and distributions, on the diameter where a drawing gives that."""
    rows, frame = [], {}
    for dimension in study.tolerances.dimensions:
        unit, factor = quantities.shown(dimension.name)
        nominal, low, high = (factor * x for x in (dimension.nominal, dimension.lower, dimension.upper))
        times = quantities.of(dimension.shown_name).times
        on_drawing = _on_drawing(dimension, nominal, low, high)
        rows.append(
            cells(
                quantities.label(dimension.shown_name),
                on_drawing,
                Cell(Number(nominal, 8), deviations=deviations(nominal, low, high)),
                Cell(
                    span(times * low, times * high) if high > low else Number(times * nominal, 8),
                    _in_rpm(study, dimension.name, dimension.lower, dimension.upper),
                ),
                unit,
                distribution(dimension),
            )
        )
        frame[dimension.name] = _record(dimension, on_drawing)
    return Table(
        "dimensions",
        (
            "Dimension",
            "on the drawing",
            "in the model",
            "limits",
            Column("unit", words=True),
            Column("distribution of the parts", words=True),
        ),
        tuple(rows),
        title="Dimensions",
        caption="Dimensions that vary from part to part, as drawn (diameter, length) and as the model takes them (radius, half "
        "length), and what the parts were assumed to follow between the limits.",
        frame=pd.DataFrame.from_dict(frame, orient="index").rename_axis("dimension"),
    )


def _record(dimension: Dimension, on_drawing: Cell) -> dict[str, str | float]:
    unit, factor = quantities.shown(dimension.name)
    return {
        "unit": unit,
        "drawing": on_drawing.written(typeset).line,
        "nominal": factor * dimension.nominal,
        "lower_limit": factor * dimension.lower,
        "upper_limit": factor * dimension.upper,
        "mean": factor * dimension.mean,
        "sd": factor * dimension.sd,
        "distribution": distribution(dimension),
    }


def _in_rpm(study: Study, name: str, *values: float) -> str:
    """Values of an angular velocity as a study that is written in rpm has them."""
    if quantities.unit(name) != "rad/s" or "rpm" not in study.source:
        return ""
    ends = dict.fromkeys(number(value * 30 / math.pi, 6) for value in values)
    return f"{' to '.join(ends)} rpm"


def drawn_class(dimension: Dimension) -> str:
    """Size and tolerance class as a drawing has them, such as "⌀40 H7"; empty where the limits come from none."""
    toleranced = dimension.toleranced_size
    if toleranced is None or dimension.name not in _DRAWN_TWICE:
        return ""
    return f"{_DRAWN_TWICE[dimension.name]}{_class_text(fits.size_limits(toleranced)[0], toleranced)}"


def _class_text(size: float, designation: str) -> str:
    """Size (m) and class as a drawing has them: ``40 H7``, however the study writes "⌀ 40mmH7"."""
    tolerance_class = re.sub(r"^\D*[\d.]+\s*(?:mm)?\s*", "", designation)
    return f"{number(1e3 * size, 8)} {tolerance_class.strip()}"


def _on_drawing(dimension: Dimension, nominal: float, low: float, high: float) -> Cell:
    if dimension.name not in _DRAWN_TWICE:
        return Cell(NOTHING)
    if drawn := drawn_class(dimension):
        return Cell(drawn)
    return Cell(
        f"{_DRAWN_TWICE[dimension.name]}{number(2 * nominal, 8)}", deviations=deviations(2 * nominal, 2 * low, 2 * high)
    )


def constants_table(study: Study) -> Table:
    """Scalars of the scene that are the same in every sample and not zero; of conditions, where the study sets them."""
    apart = {*study.tolerances.names, *(() if study.scene.operating else quantities.OPERATING)}
    held = {name: value for name, value in study.scene.scalars.items() if name not in apart and value != 0}
    held = {name: held[name] for name in quantities.SCALARS if name in held}
    rows = tuple(
        cells(quantities.label(name), Cell(quantity(name, value), _in_rpm(study, name, value)))
        for name, value in held.items()
    )
    frame = pd.DataFrame(
        {"unit": [quantities.unit(name) for name in held], "value": list(held.values())},
        index=pd.Index(held, name="quantity"),
    )
    return Table(
        "constants",
        ("Quantity", "value"),
        rows,
        title="Constants",
        caption="The same in every sample; what is not named is zero.",
        frame=frame,
    )
