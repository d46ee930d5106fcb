"""The paper's circle against the exact section, on the same samples."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from tolmc import quantities
from tolmc.commands.written import written
from tolmc.errors import InputError
from tolmc.mechanism.scene import SECTIONS
from tolmc.runs.run import StudyResult, run
from tolmc.statistics.summary import QUANTILES
from tolmc.tables.sections import comparison_tables
from tolmc.terminal.grid import show

_STATISTICS = ("mean", "sd", "min", *QUANTILES, "max")
_SHARES = ("share_least", "share_most")
_NOT_COMPARED = {*quantities.GEOMETRY, *quantities.CHECKS}


def compare_run(result: StudyResult, directory: Path) -> None:
    """Compare the sections on the samples of a run, print the tables and write section_comparison.csv into ``directory``."""
    comparison = compare_sections(result)
    path = directory / "section_comparison.csv"
    comparison.to_csv(path)
    show(comparison_tables(comparison))
    written(path)


def compare_sections(result: StudyResult) -> pd.DataFrame:
    """Everything a run says with ``section = "circle"`` and ``"exact"``, the other one run now on the same samples.

    Returns
    -------
    pandas.DataFrame, index ``output``, ``statistic``
        ``circle`` and ``exact`` in the output's unit (N, rad, s), ``difference`` = circle - exact, ``difference_percent`` of
        the exact value (NaN where that is 0). Rows: the statistics of every output, but for the geometry (equations
        (1)-(3)), which is the same in both; ``share_least`` and ``share_most`` of every requirement, of any being broken
        and of contact loss, as :func:`tolmc.statistics.summary.summarise_requirements` names them; under ``status``,
        the share of every status.

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
    found = {joint.section: _everything(result), other: _everything(run(changed))}
    keys = list(found["circle"] | found["exact"])
    # Only a status may be missing in one of them, which then has no such samples.
    columns = {section: [float(values.get(key, 0.0)) for key in keys] for section, values in found.items()}
    index = pd.MultiIndex.from_tuples(keys, names=["output", "statistic"])
    table = pd.DataFrame(columns, index, columns=list(SECTIONS))
    table["difference"] = table["circle"] - table["exact"]
    table["difference_percent"] = 100 * table["difference"] / table["exact"].abs().replace(0.0, np.nan)
    return table


def _everything(result: StudyResult) -> dict[tuple[str, str], float]:
    """{(output, statistic): value} of a run, requirements and statuses with it."""
    compared = result.summary.drop(index=_NOT_COMPARED, errors="ignore")
    rows = {(output, name): compared.at[output, name] for output in compared.index for name in _STATISTICS}
    shares = result.requirements
    rows |= {(requirement, name): shares.at[requirement, name] for requirement in shares.index for name in _SHARES}
    return rows | {("status", str(status)): share for status, share in result.statuses["share"].items()}
