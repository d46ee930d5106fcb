"""What a run says first: its outputs, its requirements, what became of the samples, how exact it is."""

from __future__ import annotations

import math
from collections.abc import Iterator

import pandas as pd

from tolmc import quantities
from tolmc.analysis.smoothness import ROWS, held_out_shares, rough
from tolmc.mechanism.circle_error import section_error_estimate
from tolmc.mechanism.scene import Joint
from tolmc.runs.run import StudyResult
from tolmc.statistics.intervals import Estimate
from tolmc.statistics.outcomes import ANY_REQUIREMENT, CONTACT_LOSS
from tolmc.study.study import Study
from tolmc.tables.outputs import budget_table, contact_law_table, outputs_table, statuses_table
from tolmc.tables.requirements import shares_table
from tolmc.tables.table import Note, Table
from tolmc.text.phrases import (
    cut_short,
    judged,
    jumps,
    model_doubt,
    model_turns_target,
    spoiled_by_jumps,
    too_few_computed,
)


def run_blocks(result: StudyResult) -> Iterator[Table | Note]:
    """Title, tables and what a reader of them must know, in this order."""
    study = result.study
    yield from _first(result)
    if outputs := outputs_table(result.summary, study.specification):
        yield outputs
    yield shares_table(result.requirements)
    yield from _verdict(study, result.requirements)
    yield from _contact_notes(result)
    yield statuses_table(result.statuses)
    yield from run_notes(result)
    yield from _step_note(result)
    if words := result.plan.chaotic_words():
        yield Note(f"Chaos: {words}", strong="Chaos")
    yield from _jump_note(result)
    if not math.isnan(result.plan.pilot_error):
        yield budget_table(result.summary)
    if law := contact_law_table(result.summary):
        yield law
    if study.scene.joint_in_operation.section == "circle" and any(
        quantities.of(name).kind == "force" for name in result.summary.index
    ):
        yield section_note(study.scene.joint_in_operation)


def run_notes(result: StudyResult) -> Iterator[Note]:
    """What went wrong beside the statistics, as is known once the pictures are drawn."""
    return (Note(f"Note: {note}") for note in result.notes)


def brief_blocks(result: StudyResult) -> Iterator[Table | Note]:
    """The title, the outputs that have limits (all, where none has), and the requirements."""
    study = result.study
    limited = [name for name in study.specification if name in result.summary.index]
    yield from _first(result)
    if outputs := outputs_table(result.summary.loc[limited or list(result.summary.index)]):
        yield outputs
    yield shares_table(result.requirements)
    yield from _verdict(study, result.requirements)
    yield from _contact_notes(result)
    if too_few_computed(result.statuses):
        yield from _step_note(result)


def _first(result: StudyResult) -> Iterator[Note]:
    """Whether too few samples could be computed; the title."""
    if warning := too_few_computed(result.statuses):
        yield Note(warning, strong=warning.partition(",")[0].partition(" (")[0], is_apart=True)
    study = result.study
    title = " ".join(study.title.split())
    yield Note(
        f"{title}: {study.samples:,} samples, {study.sampling.replace('_', ' ')}, seed {study.seed} ({result.elapsed:.1f} s)",
        strong=title,
        is_apart=True,
    )


def _verdict(study: Study, requirements: pd.DataFrame) -> Iterator[Note]:
    """Whether the share of parts that keep every limit reaches the target that the study names."""
    if study.target is None or not study.specification:
        return
    out = requirements.loc[ANY_REQUIREMENT]
    low, high = 1.0 - out["share_most_high"], 1.0 - out["share_least_low"]
    verdict = judged(Estimate(1.0 - out["share_most"], low, high), study.target)
    if model_turns_target(out):
        verdict = model_doubt(out)
    found = f"{100 * low:.6g} to {100 * high:.6g} % of the parts keep every limit"
    yield Note(
        f"Target {verdict}: {found} (95 % interval), {100 * study.target:.6g} % are asked for.",
        strong=f"Target {verdict}",
    )


def _step_note(result: StudyResult) -> Iterator[Note]:
    """Why motions miss the accuracy, and what to do."""
    if words := result.plan.unresolved_words():
        yield Note(f"Step: {words}", strong="Step")


def _jump_note(result: StudyResult) -> Iterator[Note]:
    """Which outputs impacts make jump, as measured on the samples, and what that spoils."""
    if not result.plan.features.one_sided:
        return
    study = result.study
    first = result.read(rows=ROWS).to_pandas()
    inputs = [dimension.name for dimension in study.tolerances.varied]
    shares = held_out_shares(first, inputs=inputs, outputs=quantities.responses_among(first.columns))
    if words := jumps(rough(shares), spoiled_by_jumps(study.sampling)):
        yield Note(f"Jumps: {words}", strong="Jumps")


def _contact_notes(result: StudyResult) -> Iterator[Note]:
    lost = result.requirements.loc[CONTACT_LOSS]
    if lost["out"] and result.study.on_contact_loss == "stop":
        yield Note(cut_short(lost["share_least"], lost["unknown"]))
    if result.study.specification and result.requirements.at[ANY_REQUIREMENT, "unknown"]:
        yield Note(
            "What is not known to keep its limits (motion not computed, or contact lost before) is counted both ways."
        )


def section_note(joint: Joint) -> Note:
    """How much the circle of constant radius may misstate on this joint."""
    share = {name: f"{100 * error:.3g} %" for name, error in section_error_estimate(joint).items()}
    return Note(
        f"Circle or exact section: on this joint the circle of constant radius misstates the axis's position by up to "
        f"{share['position']}, the tilt by up to {share['tilt']}, and contact-force peaks by up to about "
        f"{share['contact_force']} in nine motions of ten; --compare-section measures it.",
        strong="Circle or exact section",
        is_apart=True,
    )
