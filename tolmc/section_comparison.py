"""The paper's circle against the exact section, on the same samples."""

from __future__ import annotations

from dataclasses import replace

import pandas as pd

from tolmc import units
from tolmc.errors import InputError
from tolmc.mechanism import SECTIONS
from tolmc.monte_carlo import StudyResult, run

_STATISTICS = ("mean", "sd", "min", "max", "q0.135", "q5", "q50", "q95", "q99.865")
_SAME_IN_BOTH = {"tilt_angle", "effective_radius", "approximate_radius"}
_NOT_COMPARED = _SAME_IN_BOTH | set(units.CHECKS)


def compare_sections(result: StudyResult) -> pd.DataFrame:
    """Every statistic of a run with ``section = "circle"`` and ``"exact"``, the other one run now on the same samples.

    Returns
    -------
    pandas.DataFrame, index ``output``, ``statistic``
        ``circle`` and ``exact`` in the output's unit (N, rad, s), ``difference`` = circle - exact, ``difference_percent`` of
        the exact value. The geometry (equations (1)-(3)) is the same in both and left out.

    Raises
    ------
    InputError
        For the paper's own coordinates, which know the circle only.
    """
    study = result.study
    if study.formulation != "slope":
        raise InputError(f"formulation = {study.formulation!r} knows the circle only; compare sections with 'slope'.")
    joint = study.scene.joint
    other = next(section for section in SECTIONS if section != joint.section)
    changed = replace(study, scene=replace(study.scene, joint=replace(joint, section=other)))
    summaries = {joint.section: result.summary, other: run(changed).summary}
    rows = {
        (output, statistic): {section: summaries[section].at[output, statistic] for section in SECTIONS}
        for output in result.summary.index
        if output not in _NOT_COMPARED
        for statistic in _STATISTICS
    }
    table = pd.DataFrame.from_dict(rows, orient="index", columns=list(SECTIONS), dtype=float)
    table.index = pd.MultiIndex.from_tuples(table.index, names=["output", "statistic"])
    table["difference"] = table["circle"] - table["exact"]
    table["difference_percent"] = 100 * table["difference"] / table["exact"].abs()
    return table
