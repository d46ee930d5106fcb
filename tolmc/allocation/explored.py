"""Polynomials to explore a study with: they stand for its motions over a box in which nominal values and zones can move.

A run's own polynomials (:mod:`tolmc.analysis.accelerated`) reach as far as its tolerances. These reach further: over the
zones on offer, the ISO 286 classes beside the study's, and one width of its zone on either side of every dimension, as far
as all outputs stay smooth. What is smooth not even over the tolerances is refused, and it is said why.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace

import numpy as np
import pandas as pd

from tolmc import quantities
from tolmc.allocation.offers import hull, offered_box
from tolmc.allocation.study_table import read_plan
from tolmc.analysis.model import study_model
from tolmc.analysis.surrogate import Surrogate, fit, training_box, training_points
from tolmc.errors import InputError
from tolmc.statistics.outcomes import contact_lost, failed, rows_whose_status
from tolmc.study.study import Study
from tolmc.tolerances import fits
from tolmc.tolerances.dimension import Dimension
from tolmc.tolerances.interference import smallest_clearance

#: Motions that train the polynomials.
TRAINING = 512
#: Held-out error over the output's standard deviation in the run, from which on a polynomial is refused.
MOST_ERROR = 0.2
# The same, up to which a wider box is as good.
_GOOD_ERROR = 0.02
# Widths of a zone by which a box reaches beyond it.
_REACHES = (0.0, 0.25, 1.0)
# A standard deviation below this share of the largest value of its unit is the arithmetic's.
_ROUNDING = 1e-9
_LETTERS = "abcdefgh"
_GRADES_BESIDE = 3
# Of the smallest clearance, how much of it bore and journal leave each other.
_CLEARANCE_KEPT = 0.05


@dataclass(frozen=True, eq=False)
class Explored:
    """Polynomials of the outputs that are smooth (None: of none), and why not of others: {output: reason}."""

    surrogate: Surrogate | None
    refused: Mapping[str, str]

    def json(self) -> str:
        surrogate = None if self.surrogate is None else asdict(self.surrogate)
        return json.dumps({"surrogate": surrogate, "refused": dict(self.refused)}, default=np.ndarray.tolist)

    @classmethod
    def of_json(cls, text: str) -> Explored:
        """From :meth:`json`; ValueError, KeyError or TypeError where it is something else."""
        record = json.loads(text)
        if (known := record["surrogate"]) is None:
            return cls(None, record["refused"])
        known |= {"box": {name: tuple(ends) for name, ends in known["box"].items()}, "outputs": tuple(known["outputs"])}
        known |= {
            "exponents": np.array(known["exponents"], int),
            "coefficients": np.array(known["coefficients"], float),
        }
        return cls(Surrogate(**known), record["refused"])


def explore(study: Study, summary: pd.DataFrame) -> Explored:
    """Train the polynomials of every output of ``summary`` that varies (:func:`tolmc.statistics.summary.summarise`)."""
    spread = _spread(summary)
    narrow, *wider = _boxes(study)
    found, _ = _trained(study, narrow, spread)
    smooth = {} if found.surrogate is None else {name: spread[name] for name in found.surrogate.outputs}
    for box in wider if smooth else []:
        again, error = _trained(study, box, smooth)
        if again.refused or error > _GOOD_ERROR:
            break
        found = Explored(again.surrogate, found.refused)
    return found


def classes_beside(dimension: Dimension) -> list[Dimension]:
    """The dimension in its own ISO 286 class and in those beside it: other letters of clearance fits, other grades."""
    size, own, grade = fits.parts(str(dimension.toleranced_size))
    letters = _LETTERS if own.lower() in _LETTERS else [own.lower()]
    place = fits.GRADES.index(grade)
    found = []
    for letter in letters:
        for other in fits.GRADES[max(place - _GRADES_BESIDE, 0) : place + _GRADES_BESIDE + 1]:
            try:
                found.append(dimension.in_class(f"{size} {letter.upper() if own.isupper() else letter}{other}"))
            except ValueError:  # the standard does not have every letter in every grade and size
                continue
    return found


def _spread(summary: pd.DataFrame) -> dict[str, float]:
    """Standard deviation in the run of every output that varies by more than rounding."""
    outputs = quantities.responses_among(summary.index)
    largest = summary.loc[outputs, ["min", "max"]].abs().max(axis=1)
    scale = largest.groupby([quantities.unit(name) for name in outputs]).transform("max")
    return {name: float(sd) for name, sd in summary.loc[outputs, "sd"].items() if sd > _ROUNDING * scale[name]}


def _boxes(study: Study) -> Iterator[dict[str, tuple[float, float]]]:
    """The narrowest box first."""
    own = training_box(study.tolerances)
    around = [_widened(study, reach) for reach in _REACHES]
    yield from (_possible(study, box) for box in around)
    others = [{**own, d.name: training_box(replace(study.tolerances, dimensions=(d,)))[d.name]} for d in _others(study)]
    if "dimensions" in study.allocation:
        others.append(offered_box(study.tolerances, read_plan(study).choices))
    if others:
        yield _possible(study, hull(around[-1], *others))


def _others(study: Study) -> Iterator[Dimension]:
    for dimension in study.tolerances.varied:
        if dimension.toleranced_size is not None and not dimension.distribution.stands_alone:
            yield from classes_beside(dimension)


def _widened(study: Study, reach: float) -> dict[str, tuple[float, float]]:
    """The box of the tolerances and so many widths of each zone around it."""
    box = training_box(study.tolerances)
    for d in study.tolerances.varied:
        low, high = box[d.name]
        box[d.name] = (low - reach * (d.upper - d.lower), high + reach * (d.upper - d.lower))
    return box


def _possible(study: Study, box: Mapping[str, tuple[float, float]]) -> dict[str, tuple[float, float]]:
    """The box less what cannot be: a sign that no sample has, a share above 1, a journal without clearance."""
    own = training_box(study.tolerances)
    found = dict(own)
    for name in (dimension.name for dimension in study.tolerances.varied):
        low, high = box[name]
        if own[name][0] >= 0.0:
            low = max(low, 0.5 * own[name][0])
        if name == "restitution":
            high = min(high, 1.0)
        found[name] = (low, high)
    lost = smallest_clearance(study.tolerances) - smallest_clearance(study.tolerances, study.scene.scalars)
    clearance = own["bearing_radius"][0] - own["journal_radius"][1] - lost
    spare = 0.5 * (1.0 - _CLEARANCE_KEPT) * max(clearance, 0.0)
    low, high = own["bearing_radius"][0] - spare, own["journal_radius"][1] + spare
    found["bearing_radius"] = (max(found["bearing_radius"][0], low), found["bearing_radius"][1])
    found["journal_radius"] = (found["journal_radius"][0], min(found["journal_radius"][1], high))
    return found


def _trained(study: Study, box: dict[str, tuple[float, float]], spread: Mapping[str, float]) -> tuple[Explored, float]:
    """The polynomials over a box, and the largest of their held-out errors over the outputs' deviations in the run."""
    outputs = list(spread)
    if not outputs:
        return Explored(None, {}), 0.0
    try:
        model = study_model(study, outputs, box=box)
    except InputError as error:
        return Explored(
            None, dict.fromkeys(outputs, f"the motions around the study cannot be computed: {error}")
        ), math.inf
    answers = model(training_points(box, TRAINING, study.seed))
    refused = {name: reason for name in outputs if (reason := _jumps(study, answers, name))}
    smooth = [name for name in outputs if name not in refused]
    if not smooth:
        return Explored(None, refused), math.inf
    try:
        surrogate = fit(lambda _: answers, box, smooth, motions=TRAINING, seed=study.seed)
    except ValueError as error:
        return Explored(None, refused | dict.fromkeys(smooth, str(error))), math.inf
    share = {name: surrogate.held_out[name] / spread[name] for name in smooth}
    errors = [round(100 * error) for error in share.values() if error > MOST_ERROR]
    reason = (
        f"polynomials miss the motions by {' to '.join(map(str, dict.fromkeys((min(errors), max(errors)))))} % of the standard "
        "deviation, as where an output jumps"
        if errors
        else ""
    )
    rough = {name: reason for name, error in share.items() if error > MOST_ERROR}
    kept = [name for name in smooth if name not in rough]
    return Explored(_only(surrogate, kept) if kept else None, refused | rough), max(share.values())


def _jumps(study: Study, answers: pd.DataFrame, name: str) -> str:
    """Why the output of these motions is not smooth over their box; "" where nothing says that."""
    impossible = rows_whose_status(answers, "geometry invalid".__eq__)
    without_number = int(np.count_nonzero(failed(answers) & ~impossible))
    if 2 * int(np.count_nonzero(impossible)) > len(answers):
        return "most of the box around the study leaves no clearance"
    if quantities.output(name).settled == "at start":
        return ""
    if without_number:
        return f"{without_number} of {len(answers)} training motions could not be computed"
    lost = int(np.count_nonzero(contact_lost(answers)))
    if lost and study.on_contact_loss != "continue":
        meaning = "impacts follow" if study.on_contact_loss == "follow" else "what follows is cut off"
        return f"in {lost} of {len(answers)} training motions contact is lost and {meaning}: the output jumps there"
    if not np.isfinite(answers[name].to_numpy(float)[~impossible]).all():
        return "it has no value in some of the training motions"
    return ""


def _only(surrogate: Surrogate, names: Sequence[str]) -> Surrogate:
    """The surrogate of some of its outputs."""
    columns = [surrogate.outputs.index(name) for name in names]
    degree = {name: surrogate.degree[name] for name in names}
    terms = surrogate.exponents.sum(axis=1) <= max(degree.values())
    return replace(
        surrogate,
        outputs=tuple(names),
        exponents=surrogate.exponents[terms],
        coefficients=surrogate.coefficients[terms][:, columns],
        degree=degree,
        held_out={name: surrogate.held_out[name] for name in names},
        spread={name: surrogate.spread[name] for name in names},
    )
