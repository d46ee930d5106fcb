"""Life of a joint that wears: its clearance, forces, tilt and share of good parts against running time.

A sequence of studies on the same parts, one a step of running time: the motion gives every part's worn volume per time
(Archard, `wear_rate`), the volume opens its clearance (:mod:`tolmc.mechanism.wear`), and the next study moves in that. The
motion is short beside the wear, so that each study sees a joint that stays as it is. Volumes are integrated by the formula of
Adams and Bashforth of order 2, which takes one study a step; the number of steps is chosen on the nominal joint.

The model's clearance is the same all round: the worn depth counts in every direction.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from tolmc.mechanism.operating import operating_dimensions
from tolmc.mechanism.wear import bore_depth, journal_depth
from tolmc.runs.files import flush_names, write_whole
from tolmc.runs.integrate import integrate_study, status_words, study_plan
from tolmc.runs.nominal import study_motion
from tolmc.runs.progress import progress
from tolmc.simulation.trajectory import Trajectory
from tolmc.statistics.intervals import Estimate
from tolmc.statistics.life import part_lives
from tolmc.statistics.observations import Observations
from tolmc.statistics.outcomes import ANY_REQUIREMENT, failed
from tolmc.statistics.rows import Rows
from tolmc.statistics.summary import as_columns, summarise_requirements
from tolmc.study.file import load_study
from tolmc.study.sections import LifeSection
from tolmc.study.study import Study, StudyError
from tolmc.tolerances.draw import sample

HOUR = 3600.0
#: Shown against running time, beside what has limits.
SHOWN = ("approximate_radius", "contact_force_D_max", "contact_force_E_max", "tilt_angle", "tilt_max", "wear_rate")
QUANTILES = {"q5": 0.05, "q50": 0.5, "q95": 0.95}
#: Steps that are tried on the nominal joint, and how much of its worn depth twice as many may change.
_FEWEST, _MOST, _STEP_ERROR = 20, 320, 0.01
_MIDDLE = 0.9  # share of the impulse of the contact forces that lies within the arc


@dataclass(frozen=True)
class LifeResult:
    """What a sequence of studies found.

    Attributes
    ----------
    study : Study
    shown : tuple of str
        The outputs in the table.
    table : DataFrame, index ``hours``
        For each output shown ``NAME q5``, ``NAME q50`` and ``NAME q95`` over the parts, SI units, each with its 95 % interval
        ``_low``, ``_high``; ``inside``, the share of the parts that keep every limit, with its interval; ``unknown``, parts
        without numbers.
    life : Estimate
        Hours after which the [life] broken_share of the parts breaks a limit, infinite beyond the running time; its interval
        is that of sampling and counts parts without numbers both ways.
    contact_arc : float, rad
        Over which the contact wanders.
    step_error : float
        Share of the nominal joint's worn depth by which twice as many steps change it; NaN where the study gives the steps.
    """

    study: Study
    shown: tuple[str, ...]
    table: pd.DataFrame
    life: Estimate
    contact_arc: float
    step_error: float

    @property
    def section(self) -> LifeSection:
        """The study's [life] table."""
        return life_section(self.study)


def life_section(study: Study) -> LifeSection:
    """The [life] table of a study; StudyError where it has none."""
    if study.life is None:
        raise StudyError(
            f'{study.title}: [life] is missing; add it with running_time = "2000 h", and [contact] wear_coefficient.'
        )
    return study.life


def life(study: Study | Mapping[str, Any] | str | Path, *, keep: Path | None = None) -> LifeResult:
    """Follow the wear of a study's parts over their running time.

    Parameters
    ----------
    study : Study, path, or mapping as :meth:`tolmc.study.study.Study.from_dict` takes it
        With a [life] table, [contact] wear_coefficient, and limits.
    keep : path, optional
        Directory where every step's samples are kept; steps of the same study that are there already are not computed again.

    Raises
    ------
    StudyError
        Where something of that is missing, or the nominal joint has no motion.
    """
    if isinstance(study, Mapping):
        study = Study.from_dict(study)
    study = study if isinstance(study, Study) else load_study(study)
    study.introduce()
    section = life_section(study)
    if not study.specification:
        raise StudyError(f"{study.title}: [specification] is missing; a life ends where limits are broken.")
    if study.outputs is not None:
        study = replace(study, outputs=tuple(dict.fromkeys([*study.outputs, "wear_rate", "approximate_radius"])))
    arc = section.contact_arc
    with progress(f"{study.title}: choosing the steps of running time"):
        arc = contact_arc(study_motion(study)) if arc is None else min(arc, 2.0 * math.pi)
        steps, error = (section.steps, math.nan) if section.steps else _chosen_steps(study, section, arc)
    parts = sample(study.tolerances, study.samples, sampling=study.sampling, seed=study.seed, total=study.samples)
    hours = np.linspace(0.0, section.running_time / HOUR, steps + 1)
    with progress(study.title, (steps + 1) * study.samples) as counted:
        frames = [_needed(study, table) for table in counted(_aged(study, parts, section, steps, arc, keep))]
    shown = _shown(study, frames[0])
    return LifeResult(study, shown, *_found(study, section, hours, frames), contact_arc=arc, step_error=error)


def contact_arc(motion: Trajectory) -> float:
    """Arc of the bore, rad, that holds the middle 90 % of the contact forces' impulse: the larger of both ends'."""
    length = motion.scene.joint_in_operation.half_length if motion.scene else 1.0
    offset = length * motion.axis[:, :2] / motion.axis[:, 2:]
    arcs = []
    for side, points in enumerate((motion.origin + offset, motion.origin - offset)):
        angle = np.unwrap(np.arctan2(points[:, 1], points[:, 0]))
        force = np.maximum(motion.contact_force[:, side], 0.0)
        impulse = 0.5 * (force[1:] + force[:-1]) * np.diff(motion.time)
        order = np.argsort(angle[1:])
        passed = np.cumsum(impulse[order])
        low, high = np.searchsorted(passed, np.array([0.5 - 0.5 * _MIDDLE, 0.5 + 0.5 * _MIDDLE]) * passed[-1])
        arcs.append(float(angle[1:][order][high] - angle[1:][order][low]) if passed[-1] > 0.0 else 0.0)
    return min(max(arcs), 2.0 * math.pi)


def _chosen_steps(study: Study, section: LifeSection, arc: float) -> tuple[int, float]:
    """Steps with which the nominal joint's worn depth is known to :data:`_STEP_ERROR`, and how well it is."""
    nominal = pd.DataFrame([{dimension.name: dimension.nominal for dimension in study.tolerances.dimensions}])

    def opened(steps: int) -> float:
        first, *_, last = (table.to_pandas() for table in _aged(study, nominal, section, steps, arc, None))
        if first["status"].iloc[0] != "ok":
            raise StudyError(
                f"{study.title}: the nominal motion is {first['status'].iloc[0]!r}; nothing says what it wears."
            )
        return float(last["approximate_radius"].iloc[0] - first["approximate_radius"].iloc[0])

    steps, coarse = _FEWEST, opened(_FEWEST)
    while True:
        fine = opened(2 * steps)
        error = abs(fine - coarse) / fine if fine > 0.0 else 0.0
        if error <= _STEP_ERROR or 2 * steps > _MOST:
            return steps, error
        steps, coarse = 2 * steps, fine


def _aged(
    study: Study, parts: pd.DataFrame, section: LifeSection, steps: int, arc: float, keep: Path | None
) -> Iterator[pa.Table]:
    """The parts at the start and after every step of running time: dimensions, outputs, ``worn_volume`` (m^3)."""
    nominal = study.scene.scalars
    new = {
        name: parts[name].to_numpy() if name in parts else np.full(len(parts), value) for name, value in nominal.items()
    }
    bore, journal, half_length = (np.asarray(size) for size in operating_dimensions(new))
    volume, before = np.zeros(len(parts)), None
    length = section.running_time / steps
    for step in range(steps + 1):
        with np.errstate(all="ignore"):  # parts without a joint have no wear either
            area = volume / (2.0 * half_length)
            worn = {
                "bearing_wear": new["bearing_wear"]
                + bore_depth((1.0 - section.journal_share) * area, bore, journal, arc),
                "journal_wear": new["journal_wear"] + journal_depth(section.journal_share * area, journal),
            }
        table = _study_of(
            study, parts.assign(**worn, worn_volume=volume), _step_file(keep, step), f"{steps} {arc!r} {step}"
        )
        yield table
        # A part without a motion wears no further: it stays without one.
        rate = np.nan_to_num(table["wear_rate"].to_numpy())
        volume = volume + length * np.maximum(rate if before is None else 1.5 * rate - 0.5 * before, 0.0)
        before = rate


def _step_file(keep: Path | None, step: int) -> Path | None:
    return None if keep is None else keep / f"step_{step:04d}.parquet"


def _study_of(study: Study, parts: pd.DataFrame, path: Path | None, step: str) -> pa.Table:
    """Samples of the worn parts; from the file of an earlier start where it holds them."""
    stamp = {
        b"tolmc.life": hashlib.sha256(f"{study.sha256} {study.samples} {study.seed} {step}".encode())
        .hexdigest()
        .encode()
    }
    if path is not None and path.exists():
        kept = pq.read_table(path)
        if (kept.schema.metadata or {}).get(b"tolmc.life") == stamp[b"tolmc.life"]:
            return kept
    volume = parts.pop("worn_volume")
    worn = ("bearing_wear", "journal_wear")
    plan = study_plan(study, {name: (np.nanmin(parts[name]), np.nanmax(parts[name])) for name in worn})
    columns: dict[str, Any] = integrate_study(study, plan, parts, workers=study.workers)
    columns |= {"worn_volume": volume.to_numpy(), "status": status_words(columns["status"])}
    table = pa.table(columns).replace_schema_metadata(stamp)
    if path is not None:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, partial(pq.write_table, table))
        flush_names(path.parent)
    return table


def _found(
    study: Study, section: LifeSection, hours: np.ndarray, frames: list[pd.DataFrame]
) -> tuple[pd.DataFrame, Estimate]:
    """The table against running time, and the life."""
    drawn: dict[str, Any] = {"sampling": study.sampling, "lot_size": study.tolerances.lot_size or 1}
    judging: dict[str, Any] = {"specification": study.specification, "on_contact_loss": study.on_contact_loss}
    shown = _shown(study, frames[0])
    rows = []
    for frame in frames:
        out = summarise_requirements(frame, **judging, **drawn).loc[ANY_REQUIREMENT]
        inside = Estimate(1 - out["share_most"], 1 - out["share_most_high"], 1 - out["share_least_low"])
        rows.append({**_bands(frame, shown, Rows(**drawn)), **as_columns("inside", inside), "unknown": out["unknown"]})
    earliest, latest = part_lives(frames, hours, **judging)
    ends = [Observations(lives, Rows(**drawn)).quantile(section.broken_share) for lives in (earliest, latest)]
    last = hours[-1]
    values = (value if value < last else math.inf for value in (ends[1].value, ends[0].low, ends[1].high))
    return pd.DataFrame(rows, index=pd.Index(hours, name="hours")), Estimate(*values)


def _shown(study: Study, frame: pd.DataFrame) -> tuple[str, ...]:
    return tuple(name for name in dict.fromkeys([*study.specification, *SHOWN]) if name in frame)


def _needed(study: Study, table: pa.Table) -> pd.DataFrame:
    """What is asked of every step's samples, which are all kept at once."""
    names = [*_shown(study, frame := table.to_pandas()), "worn_volume", "status", "contact_loss_time"]
    return frame[[name for name in dict.fromkeys(names) if name in frame]]


def _bands(frame: pd.DataFrame, shown: tuple[str, ...], rows: Rows) -> dict[str, float]:
    """Quantiles of the outputs over the parts, with their intervals."""
    broken = failed(frame)
    found: dict[str, float] = {}
    for name in [*shown, "worn_volume"]:
        seen = Observations(np.where(broken, np.nan, frame[name].to_numpy(float)), rows)
        for key, estimate in zip(QUANTILES, seen.quantiles(list(QUANTILES.values())), strict=True):
            found |= as_columns(f"{name} {key}", estimate)
    return found
