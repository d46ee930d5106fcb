"""What the explorer's scripts read: dimensions of some thousand parts, polynomials of the outputs, limits, costs, the study.

parts       deviation of each part from its nominal value, in widths of the tolerance zone, for every dimension that varies.
            A zone that moves or widens keeps its distribution's shape: x = nominal + deviation * width
polynomials of :class:`tolmc.allocation.explored.Explored`
"""

from __future__ import annotations

import json
import tomllib
from base64 import b64encode
from collections.abc import Iterator, Mapping
from dataclasses import asdict
from importlib import resources
from math import comb
from typing import Any

import numpy as np
import pandas as pd

from tolmc import quantities, units
from tolmc.allocation.explored import Explored, classes_beside
from tolmc.allocation.offers import Curve, Grades, zone
from tolmc.allocation.study_table import read_plan
from tolmc.analysis.surrogate import Surrogate
from tolmc.quantities import JOINT
from tolmc.report.explorer.slots import inline, study_slots
from tolmc.study.drawing import MODEL_NAMES
from tolmc.study.study import Study
from tolmc.text import phrases
from tolmc.tolerances import fits
from tolmc.tolerances.dimension import Dimension
from tolmc.tolerances.distributions import Normal, Scipy, Triangular

#: Parts that the explorer shows: as many as leave the report this small, bytes, beside its pictures and its text.
FEWEST_PARTS, MOST_PARTS = 1_000, 10_000
LARGEST_REPORT, OF_TEXT = 1_500_000, 180_000
SCRIPTS = ("arithmetic.js", "study_text.js", "elements.js", "limits.js", "page.js")
# What a study file says of limits, which the explorer writes anew.
_LIMITS = ("size", "nominal", "tolerance", "lower", "upper", "diameter")
_CURVE_STEPS = 9


def parts_of(study: Study, pictures: int) -> int:
    """How many of the run's first samples the explorer takes beside pictures of so many bytes."""
    numbers = (LARGEST_REPORT - OF_TEXT - pictures) * 3 // 4 // 8  # doubles in base64
    room = numbers // max(len(study.tolerances.varied), 1)
    return min(study.samples, max(min(room, MOST_PARTS), FEWEST_PARTS))


def explorer_content(
    study: Study,
    explored: Explored,
    samples: pd.DataFrame,
    summary: pd.DataFrame,
    target: float,
    *,
    of_section: str = "",
) -> dict[str, Any]:
    """For the template: ``data`` (JSON; "" where nothing can be explored), ``scripts``, ``style`` and the ``refusals``.

    Parameters
    ----------
    samples : the run's first :func:`parts_of` rows, of the dimensions that vary
    summary : of the run
    target : yield that is asked for
    of_section : what the exact section makes of the requirements, where it turns them: no yield here is then a verdict
    """
    surrogate = explored.surrogate
    folder = resources.files("tolmc.report.explorer")
    data: Mapping[str, Any] = {}
    if surrogate is not None:
        data = _data(study, surrogate, samples, summary, target) | {"undecided": bool(of_section)}
    return {
        "data": _json(data) if data else "",
        "scripts": [(folder / name).read_text(encoding="utf-8") for name in SCRIPTS],
        "style": (folder / "style.css").read_text(encoding="utf-8"),
        "refusals": list(_refusals(explored)),
        "section": of_section.partition("(")[2].rstrip(")"),
        "motions": 0 if surrogate is None else surrogate.motions,
        "parts": len(samples),
    }


def _json(data: Mapping[str, Any]) -> str:
    """JSON that ends no script element."""
    return json.dumps(data, ensure_ascii=False, allow_nan=False).replace("<", "\\u003c")


def _refusals(explored: Explored) -> Iterator[str]:
    """A sentence for each reason, with the outputs that it keeps out."""
    for reason in dict.fromkeys(explored.refused.values()):
        names = [phrases.phrase(name) for name, why in explored.refused.items() if why == reason]
        yield f"Not explored: {phrases.joined(names)}, because {reason}."


def _data(
    study: Study,
    surrogate: Surrogate,
    samples: pd.DataFrame,
    summary: pd.DataFrame,
    target: float,
) -> dict[str, Any]:
    tolerances = study.tolerances
    source, slots, requirements = study_slots(study.source, [d.name for d in tolerances.varied])
    lot = tolerances.lot_size or 1
    spin = abs(study.scene.scalars.get("spin_rate", 0.0))
    nominal = study.scene.scalars
    return {
        "parts": len(samples),
        "lot": 1 if study.sampling == "sobol" else lot,
        "independent": _independent(study, len(samples)),
        "target": target,
        "targetMoves": "target_yield" not in study.allocation,
        "joint": {name: float(nominal[name]) for name in JOINT},
        "inOperation": study.scene.operating is not None,
        "dimensions": [_dimension(study, d, samples[d.name].to_numpy(float), surrogate) for d in tolerances.varied],
        "outputs": [_output(study, name, surrogate, summary) for name in _ordered(study, surrogate)],
        "unknown": _unknown(study, surrogate),
        "model": _model(study, surrogate),
        "motions": surrogate.motions,
        "choices": [_choice(*offer) for offer in _offers(study)],
        "source": source,
        "requirements": asdict(requirements),
        "slots": [asdict(slot) | ({"spin": spin} if slot.word == "unbalance" else {}) for slot in slots],
    }


def _independent(study: Study, parts: int) -> float | None:
    """How many of the parts stand for themselves; None: their scramblings say, as in :class:`tolmc.statistics.rows.Rows`."""
    if study.sampling == "sobol":
        return None
    return parts / (1.0 + ((study.tolerances.lot_size or 1) - 1) * study.tolerances.lot_correlation)


def _unknown(study: Study, surrogate: Surrogate) -> str:
    """The outputs with limits that cannot be explored, within a sentence."""
    names = [f"the {phrases.phrase(name)}" for name in study.specification if name not in surrogate.outputs]
    return phrases.joined(names) if names else ""


def _numbers(values: np.ndarray) -> str:
    return b64encode(np.ascontiguousarray(values, "<f8").tobytes()).decode()


def _ordered(study: Study, surrogate: Surrogate) -> list[str]:
    """Limited outputs first."""
    limited = [name for name in study.specification if name in surrogate.outputs]
    return limited + [name for name in surrogate.outputs if name not in limited]


def _model(study: Study, surrogate: Surrogate) -> dict[str, Any]:
    names, k = _ordered(study, surrogate), len(surrogate.varied)
    columns = [surrogate.outputs.index(name) for name in names]
    low, high = np.array([surrogate.box[name] for name in surrogate.varied]).T
    return {
        "low": low.tolist(),
        "high": high.tolist(),
        "degree": int(surrogate.exponents.max(initial=0)),
        "steps": surrogate.steps,
        "stride": len(surrogate.exponents),
        "terms": [comb(k + surrogate.degree[name], k) for name in names],
        "coefficients": _numbers(surrogate.coefficients[:, columns].T),
    }


def _output(study: Study, name: str, surrogate: Surrogate, summary: pd.DataFrame) -> dict[str, Any]:
    limits = study.specification.get(name, {})
    return {
        "name": name,
        "label": quantities.label(name),
        "unit": quantities.shown(name)[0],
        "shownUnit": phrases.unit(name),
        "factor": quantities.shown(name)[1],
        "min": limits.get("min"),
        "max": limits.get("max"),
        "margin": surrogate.held_out[name],
        "sd": float(summary.at[name, "sd"]),
    }


def _dimension(study: Study, dimension: Dimension, values: np.ndarray, surrogate: Surrogate) -> dict[str, Any]:
    name, shown = dimension.name, dimension.shown_name
    unit, factor = quantities.shown(shown)
    width = dimension.upper - dimension.lower
    return {
        "name": name,
        "word": shown,
        "label": quantities.label(shown),
        "unit": unit,
        "shownUnit": phrases.unit(shown),
        "differenceUnit": units.difference(unit),
        "factor": factor,
        "nominal": dimension.nominal,
        "lower": dimension.lower,
        "upper": dimension.upper,
        "size": _size(dimension),
        "isSize": name in JOINT,
        "isDrawn": shown in MODEL_NAMES,
        "movable": not dimension.distribution.stands_alone,
        "classes": [_class(other) for other in _classes(dimension)],
        "options": _options(study, dimension),
        "deviations": _numbers((values - dimension.nominal) / width),
        "low": surrogate.box[name][0],
        "high": surrogate.box[name][1],
    }


def _classes(dimension: Dimension) -> list[Dimension]:
    if dimension.toleranced_size is None or dimension.distribution.stands_alone:
        return []
    return classes_beside(dimension)


def _size(dimension: Dimension) -> str | None:
    """Nominal size and class as a study has them: "40 H7"."""
    if dimension.toleranced_size is None:
        return None
    size, letter, grade = fits.parts(dimension.toleranced_size)
    return f"{size} {letter}{grade}"


def _class(dimension: Dimension) -> dict[str, Any]:
    _, letter, grade = fits.parts(str(dimension.toleranced_size))
    ends = {"nominal": dimension.nominal, "width": dimension.upper - dimension.lower}
    return {"size": _size(dimension), "letter": letter, "grade": int(grade), **ends}


def _options(study: Study, dimension: Dimension) -> list[dict[str, Any]]:
    """What the study's table says of the dimension beside its limits; places and widths move with the zone."""
    table = tomllib.loads(study.source)["dimensions"]
    word = next((word for word in (dimension.name, dimension.shown_name) if word in table), None)
    entry = table[word] if word is not None and isinstance(table[word], dict) else {}
    moving = _moving(dimension)
    fixed = {key: value for key, value in entry.items() if key not in (*_LIMITS, *moving)}
    if dimension.name == "center_of_mass_x" and "unbalance" in table:
        fixed = {"distribution": "uniform"}
    return [{"key": key, "text": inline(value)} for key, value in fixed.items()] + [
        {"key": key, **value} for key, value in moving.items() if key in entry
    ]


def _moving(dimension: Dimension) -> dict[str, dict[str, Any]]:
    """Places and widths of the distribution that the zone takes along."""
    follows = dimension.distribution
    found: dict[str, dict[str, Any]] = {} if dimension.lot_sd is None else {"lot_sd": {"width": dimension.lot_sd}}
    if isinstance(follows, Normal) and isinstance(follows.mean, float):
        found["mean"] = {"place": follows.mean}
    if isinstance(follows, Triangular) and follows.mode is not None:
        found["mode"] = {"place": follows.mode}
    if isinstance(follows, Scipy) and follows.truncated:
        shapes = {key: value for key, value in follows.arguments.items() if key not in ("loc", "scale")}
        ends = {"loc": follows.arguments.get("loc", 0.0), "scale": follows.arguments.get("scale", 1.0)}
        found["arguments"] = {"place": ends["loc"], "width": ends["scale"], "shapes": shapes}
    return found


def _offers(study: Study) -> list[tuple[Dimension, Grades | Curve]]:
    """What [allocation] prices; nothing where it prices a dimension that does not vary."""
    if "dimensions" not in study.allocation:
        return []
    varied = {dimension.name: dimension for dimension in study.tolerances.varied}
    choices = read_plan(study).choices
    known = all(choice.name in varied for choice in choices)
    return [(varied[choice.name], choice) for choice in choices] if known else []


def _choice(dimension: Dimension, choice: Grades | Curve) -> dict[str, Any]:
    """What a dimension costs, and the zones with which its cost and the yield are followed.

    ``slope``: how far the nominal value moves with the width of the zone, where no class says where the zone lies.
    """
    if isinstance(choice, Curve):
        widths = np.geomspace(choice.narrowest, choice.widest, _CURVE_STEPS).tolist()
        names = ("law", "fixed", "variable", "at", "narrowest", "widest")
        costs: dict[str, Any] = {name: getattr(choice, name) for name in names}
        sizes: list[str] = []
    else:
        widths = [choice.widths[place] for place in choice.offered]
        costs = {"widths": widths, "costs": [choice.costs[place] for place in choice.offered]}
        sizes = [choice.toleranced_sizes[place] for place in choice.offered if choice.toleranced_sizes]
    options = [_class(dimension.in_class(size)) for size in sizes] or [{"width": width} for width in widths]
    return {"dimension": dimension.name, **costs, "options": options, "slope": _slope(dimension, choice.anchor)}


def _slope(dimension: Dimension, anchor: str | None) -> float:
    width = dimension.upper - dimension.lower
    share = (dimension.nominal - dimension.lower) / width
    return (zone(dimension, 2.0 * width, anchor)[0] + share * 2.0 * width - dimension.nominal) / width
