"""`tolmc allocate`: the cheapest tolerances of a study file, as tables and a picture."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from matplotlib.figure import Figure

from tolmc.allocation.allocate import AllocationResult
from tolmc.allocation.allocate import allocate as allocate_tolerances
from tolmc.allocation.offers import hull, offered_box
from tolmc.allocation.study_table import read_plan
from tolmc.analysis.model import study_model
from tolmc.analysis.surrogate import training_box
from tolmc.commands.written import written
from tolmc.pictures import plots
from tolmc.study.file import load_study
from tolmc.study.study import Study, StudyError
from tolmc.tables.allocation import allocation_blocks
from tolmc.tables.table import Table
from tolmc.terminal.grid import show


def allocate(study: Study | str | Path) -> AllocationResult:
    """The cheapest tolerances, of those that the study's [allocation] offers, with which it meets its requirements.

    Nothing is printed or written.

    Raises
    ------
    InputError
        When the study or its [allocation] cannot be used, or no choice has a predicted yield that could be shown.
    """
    study = study if isinstance(study, Study) else load_study(study)
    study.introduce()
    plan = read_plan(study)
    if not study.specification:
        raise StudyError(f"{study.title}: [specification] is missing; an allocation needs limits to keep.")
    box = hull(training_box(study.tolerances), offered_box(study.tolerances, plan.choices))
    model = study_model(study, tuple(study.specification), box=box)
    return allocate_tolerances(
        study.tolerances, study.specification, plan, model, on_contact_loss=study.on_contact_loss
    )


def allocate_study(path: str | Path, *, out: str | Path | None = None) -> AllocationResult:
    """Allocate the tolerances of a study file, print the tables and write them, with a picture.

    Parameters
    ----------
    out : path
        Directory of the files; ``runs/<study name>_allocation`` when not given.

    Raises
    ------
    InputError
        As :func:`allocate`.
    """
    study = load_study(path)
    result = allocate(study)
    blocks = list(allocation_blocks(result, title=study.title, shown_names=study.tolerances.shown_names))
    show(blocks)
    directory = Path(out or Path("runs") / f"{study.name}_allocation")
    tables = [block for block in blocks if isinstance(block, Table)]
    written(directory, write(result, directory, tables=tables, title=study.title))
    return result


def write(result: AllocationResult, directory: str | Path, *, tables: Iterable[Table], title: str) -> list[str]:
    """Write the tables as CSV (SI units) and cost_against_yield.png; the names of the files."""
    directory = Path(directory)
    directory.mkdir(parents=True, exist_ok=True)
    texts = {f"{table.name}.csv": table.csv() for table in tables if table.frame is not None}
    for name, text in texts.items():
        (directory / name).write_text(text, encoding="utf-8")
    picture = "cost_against_yield.png"
    plots.save(_picture(result, title), directory / picture)
    return [*texts, picture]


def _picture(result: AllocationResult, title: str) -> Figure:
    predicted, confirmed = (1e6 * (1.0 - share) for share in (result.predicted_yield, result.confirmed.low))
    return plots.draw_cost_against_yield(
        result.trade_off,
        winner=(result.winner.cost, predicted, confirmed),
        target_ppm=1e6 * (1.0 - result.plan.target_yield),
        is_met=result.is_met,
        title=title,
    )
