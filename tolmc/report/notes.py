"""The small print of a report: relations between dimensions, trust, what the model leaves out, how to run it again."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
import pandas as pd

from tolmc import quantities
from tolmc.mechanism.circle_error import section_error_estimate
from tolmc.mechanism.scene import Joint
from tolmc.statistics.looks import Looks
from tolmc.statistics.outcomes import CONTACT_LOSS
from tolmc.statistics.summary import error_budget
from tolmc.study.study import Study
from tolmc.text import phrases, typeset

_SCATTER = {
    "sobol": "from the scatter among 16 independent scramblings of the Sobol' sequence",
    "latin_hypercube": "as for independent samples, which for a Latin hypercube is on the safe side",
    "random": "for independent samples",
    "lots": "from the scatter among the lots",
}
_ON_CONTACT_LOSS = {
    "stop": "the statistics of such a sample end there",
    "end": "such a sample ends there",
    "continue": "such a sample goes on as if the wall could pull, and its numbers after that instant have no physical meaning",
}


def relations(study: Study) -> str:
    """Correlations and lots; empty where there are none."""
    tolerances = study.tolerances
    sentences = []
    if tolerances.correlation is not None:
        matrix = np.array(tolerances.correlation)
        labels = [quantities.label(dimension.shown_name) for dimension in tolerances.dimensions]
        pairs = [
            f"{labels[i]} and {labels[j]}: {typeset.number(matrix[i, j])}"
            for i, j in zip(*np.nonzero(np.triu(matrix, 1)), strict=True)
        ]
        if pairs:
            sentences.append(f"Correlation of {'; '.join(pairs)}.")
    shares = [
        f"{quantities.label(dimension.shown_name)} {typeset.number(100 * dimension.between_lots, 3)} %"
        for dimension in tolerances.varied
        if dimension.between_lots
    ]
    if shares:
        sentences.append(
            f"Parts come in lots of {tolerances.lot_size}; share of the variance between lots: {phrases.joined(shares)}."
        )
    return " ".join(sentences)


def of_sampling(samples: int, *, sampling: str, lot_size: int) -> str:
    """What the intervals are made from, and what they do not tell."""
    scatter = _SCATTER["lots" if lot_size > 1 and sampling != "sobol" else sampling]
    return (
        f"Sampling: all intervals hold with 95 % confidence and are computed {scatter}. They tell how well {samples:,} samples "
        "know the population that the distributions above describe, not how well those describe the shop."
    )


def of_looks(looks: Looks, stopped_at: int | None) -> str:
    """How a sequential run looked at its samples."""
    ended = "has not stopped yet" if stopped_at is None else f"stopped at {stopped_at:,} samples"
    return (
        f"Sequential sampling: the run {ended}, of at most {looks.largest:,}. It could stop at each of "
        f"{len(looks.sizes)} looks; the intervals of each are wide enough to hold together with {100 * looks.confidence:g} % "
        "confidence."
    )


def of_contact(shares: pd.DataFrame, *, is_watched: bool, on_contact_loss: str) -> list[str]:
    """How many samples lost contact, and how many failed."""
    lost = shares.loc[CONTACT_LOSS]
    value, interval = phrases.share_between(lost)
    seen = f"Contact: the journal left the wall in {lost['out']:,.0f} of {phrases.computed(lost)}, {value} ({interval})"
    seen += f"; {phrases.AFTER_LOSS[on_contact_loss]}." if lost["out"] else "."
    failed = (
        f"Failed samples: {lost['unknown']:,.0f} have no numbers. Yields count them as out, and the intervals reach to where "
        "they are in."
    )
    return ([seen] if is_watched else []) + [failed if lost["unknown"] else "Failed samples: none."]


def of_integration(plan: Mapping, summary: pd.DataFrame, pilot: str = "") -> str:
    """How the motions were integrated, and how large the error of that is against the sampling error.

    ``pilot`` is what the choice of the step has left to say.
    """
    if set(summary.index) <= set(quantities.GEOMETRY):
        return "Integration: none; the outputs follow from the dimensions alone."
    sentences = [
        f"Integration: {plan['steps']:,} steps of {plan['method']} ({plan['formulation']} form) for each motion.",
        _pilot(plan, error_budget(summary)["ratio"]),
        *([pilot] if pilot else []),
    ]
    errors = summary.loc[summary.index.isin(quantities.CHECKS) & (summary["used"] > 0), "max"]
    if len(errors):
        found = phrases.joined(f"{phrases.phrase(name)} {typeset.number(value, 2)}" for name, value in errors.items())
        sentences.append(f"Largest relative error of the invariants over the samples that could be computed: {found}.")
    return " ".join(sentences)


def _pilot(plan: Mapping, ratios: pd.Series) -> str:
    if "pilot_error" not in plan:
        allowed = typeset.number(plan["accuracy"])
        return f"The study sets the step; motions with a relative energy error above {allowed} count as failed."
    error = typeset.number(plan["pilot_error"], 2)
    found = (
        f"Halving the steps at the nominal dimensions and at the corners of the tolerances shows an error of {error}"
    )
    if plan.get("chaotic"):
        found += (
            f"; in {plan['chaotic']} of these motions impacts amplify whatever a step leaves, and their energy balance at "
            "rounding stands for it (the table compares statistics of the first samples at twice the steps)"
        )
        if plan.get("agreeing_impacts", -1) >= 0:
            found += f"; halved steps agree up to {plan['agreeing_impacts']:,} impacts"
    worst = ratios[np.isfinite(ratios)].max()
    if math.isnan(worst):
        return f"{found}, relative to the largest value."
    judged = "does not limit these results" if worst < 0.5 else (
        "limits at least one of these estimates; a smaller [monte_carlo] accuracy gives it more digits"
    )  # fmt: skip
    return (
        f"{found}, relative to the largest value: at most {typeset.number(worst, 2)} of the smallest sampling error of an "
        f"output (table). Integration {judged}."
    )


def limits(study: Study) -> list[str]:
    """What the model leaves out."""
    return [
        *_of_wall(study),
        _section(study.scene.joint_in_operation),
        "Bore and journal are perfect cylinders: errors of form (roundness, straightness, coaxiality), roughness"
        f"{_of_operation(study)} have to be part of the limits of R*, r* and L.",
        f"One motion is judged: this start, these loads, {phrases.quantity('status_time', study.scene.duration)}. Other "
        "starts, other loads and longer times may be worse.",
        "The parts follow the distributions in the table of dimensions. Other machines, worn tools or sorted parts give other "
        "yields.",
    ]


def _of_operation(study: Study) -> str:
    """What temperature and wear are left to: limits, unless the study has its conditions of operation."""
    return "" if study.scene.operating is not None else ", wear and thermal expansion"


def _of_wall(study: Study) -> list[str]:
    """What the wall does, and what it does not."""
    if study.scene.joint.restitution is None:
        return [
            "Journal, bearing and body are rigid; the contact has no lubricant film, no compliance and no impact.",
            _of_friction(study),
            "The journal touches the bearing at both ends all the time. Where a contact force would turn negative the real "
            f"journal leaves the wall: {_ON_CONTACT_LOSS[study.on_contact_loss]}.",
        ]
    force = (
        "an impulse" if study.scene.joint.contact_stiffness is None else "an impulse, and a peak force by Hertz's law,"
    )
    return [
        "Journal, bearing and body are rigid; the contact has no lubricant film.",
        _of_friction(study),
        "The wall only pushes: the journal leaves it, flies and hits it, and its normal speed after an impact is the "
        f"restitution times that before. A rigid impact has {force} and lasts no time; bounces too low to matter are left out, "
        "and impacts are counted down to that height.",
    ]


def _of_friction(study: Study) -> str:
    """The law of friction, or that there is none."""
    joint = study.scene.joint
    if joint.friction == 0.0 and all(row.name != "friction" for row in study.tolerances.varied):
        return "The contact has no friction."
    return (
        f"Friction is Coulomb's with μ = {joint.friction:.4g}, made regular: at slips below "
        f"{phrases.quantity('slip_speed', joint.slip_speed)} it falls off with the slip, so that a journal that would stick "
        "creeps. Friction's torque, power and work and the slip work are of lasting contact; the share of impacts is in the "
        "energy that these lose."
    )


def of_impacts(summary: pd.DataFrame) -> str:
    """How often the journal leaves the wall, when first, and how hard it hits; empty without one-sided contact."""
    if "free_share" not in summary.index:
        return ""
    lost, hit = summary.loc["contact_loss_time"], summary.loc["first_impact_time"]
    hardest = summary.loc[[f"impulse_{end}_max" for end in "DE"], "max"].max()
    leaves = ""
    if lost["used"]:
        share = typeset.share_of(lost["used"], lost["samples"])
        first = phrases.quantity("contact_loss_time", lost["min"], 3)
        leaves = f"the journal leaves the wall in {share} of the parts, first after {first}, "
    hits = f"it hits the wall in {typeset.share_of(hit['used'], hit['samples'])} of them"
    strength = f", with up to {phrases.quantity('impulse_D_max', hardest, 3)}" if hit["used"] else ""
    return f"Impacts: {leaves}{'and ' if leaves else ''}{hits}{strength}."


def _section(joint: Joint) -> str:
    if joint.section == "exact":
        return (
            "The bearing's rims touch the tilted cylinder exactly, each in one point. Contact in two points of a rim or on the "
            "bore's surface is not covered."
        )
    errors = section_error_estimate(joint)
    position, force = (typeset.number(100 * errors[name], 2) for name in ("position", "contact_force"))
    return (
        "The journal's axis rests on circles of constant radius r, which is exact at the largest tilt only. At these nominal "
        f"dimensions that misstates the axis's position by up to {position} % and the peaks of the contact forces by about "
        f'{force} % or less in most motions; section = "exact" in [model] does without it.'
    )


def reproduction(study: Study, record: Mapping) -> str:
    """How to run the study again."""
    files = ", ".join(study.data_files)
    beside = f", with its data files ({files}) beside it" if files else ""
    of_the_count = " and the number of samples" if study.sampling == "latin_hypercube" else ""
    return (
        f"Save the study file below as study.toml{beside}, install tolmc {record['versions']['tolmc']} and run the commands. "
        f"Sample i depends on the seed{of_the_count} and i alone, so that the numbers come out the same for any number of "
        "workers; with the same versions on a like machine, bit for bit."
    )


def commands(study: Study) -> str:
    """The commands, a line each."""
    run = ["tolmc", "run", "study.toml", "--samples", str(study.samples), "--seed", str(study.seed), "--out", "again"]
    return f"{' '.join(run)}\ntolmc report again"


def facts(record: Mapping) -> dict[str, str]:
    """What made the numbers."""
    machine = record.get("machine", {})
    plan = ", ".join(f"{key} = {value}" for key, value in record["plan"].items())
    known = {
        "Study (SHA-256)": record["study_sha256"],
        "Samples, sampling, seed": f"{record['samples']}, {record['sampling']}, {record['seed']}",
        "Integration": plan,
        "Started, finished": f"{record.get('started', '')}, {record.get('finished', '')}",
        "Run time": f"{record['seconds']} s" if "seconds" in record else "",
        "Machine": f"{machine['platform']}, {machine['cores']} cores" if machine else "",
        "Versions": ", ".join(f"{name} {number}" for name, number in record["versions"].items()),
        "Versions at the end": ", ".join(f"{n} {v}" for n, v in record.get("versions_at_finish", {}).items()),
    }
    return {name: value for name, value in known.items() if value.strip(", ")}
