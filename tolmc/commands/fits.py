"""`tolmc fits`: the same study with several fits."""

from __future__ import annotations

from pathlib import Path

from tolmc.errors import InputError, StudyError
from tolmc.runs.fits import try_fits
from tolmc.study.file import load_study
from tolmc.tables.fits import fits_blocks
from tolmc.terminal.grid import show


def compare_fits(path: Path, tried: str, *, samples: int | None, csv: Path | None) -> None:
    """Run the study file with each fit and show them side by side; ``csv`` is where the table is written.

    Raises
    ------
    InputError
        When the study has no limits, or a fit cannot be used.
    """
    study = load_study(path).replaced(samples=samples)
    if not study.specification:
        raise StudyError(
            f"{path}: [specification] is missing; fits are compared by the share of parts that keep its limits."
        )
    try:
        found = try_fits(study, tried)
    except InputError:
        raise
    except ValueError as error:
        raise InputError(f"--try {tried!r}: {error}") from None
    show(fits_blocks(study, found, samples=study.samples))
    if csv is not None:
        found.to_csv(csv)
