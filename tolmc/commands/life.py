"""`tolmc life`: the parts of a study against running time, as a table and a picture."""

from __future__ import annotations

import json
from pathlib import Path

from tolmc.commands.written import written
from tolmc.pictures import plots
from tolmc.pictures.life import draw_life
from tolmc.runs import directory as run_directory
from tolmc.runs import life as ageing
from tolmc.runs.life import LifeResult
from tolmc.study.file import load_study
from tolmc.tables.life import life_blocks, life_sentences
from tolmc.tables.table import Table
from tolmc.terminal.grid import show


def life_study(
    path: Path,
    *,
    samples: int | None = None,
    seed: int | None = None,
    workers: int | None = None,
    out: Path | None = None,
) -> LifeResult:
    """Follow the wear of a study file's parts, print the table and write it, with a picture.

    Parameters
    ----------
    path : path
        A study file, or the directory of a run, for whose report the life is written beside its samples.
    out : path
        Directory of the files; ``runs/<study name>_life`` when not given. Steps of the same study that an earlier start has
        left there are not computed again.

    Raises
    ------
    InputError
        As :func:`tolmc.runs.life.life`.
    """
    study = (run_directory.read(path).study() if path.is_dir() else load_study(path)).replaced(
        samples=samples, seed=seed, workers=workers
    )
    directory = out or (path if path.is_dir() else Path("runs") / f"{study.name}_life")
    result = ageing.life(study, keep=directory / "life_steps")
    blocks = list(life_blocks(result))
    show(blocks)
    for table in (block for block in blocks if isinstance(block, Table)):
        (directory / f"{table.name}.csv").write_text(table.csv(), encoding="utf-8")
    said = {"life": result.life._asdict(), "sentences": life_sentences(result)}
    (directory / "life.json").write_text(json.dumps(said, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    picture = draw_life(
        result.table, result.shown, life=result.life, broken_share=result.section.broken_share,
        specification=study.specification, title=study.title,
    )  # fmt: skip
    plots.save(picture, directory / "life.png")
    written(directory, ("life.csv", "life.json", "life.png", "life_steps"))
    return result
