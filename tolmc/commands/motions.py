"""`tolmc simulate` and `tolmc replay`: one motion, as a table and a picture."""

from __future__ import annotations

from pathlib import Path

from tolmc.commands.written import written
from tolmc.pictures import plots
from tolmc.runs.nominal import study_motion
from tolmc.runs.progress import progress
from tolmc.study.file import load_study
from tolmc.tables.motion import motion_blocks, sample_table
from tolmc.terminal.grid import show


def simulate_study(path: Path, *, out: Path | None) -> None:
    """Integrate the nominal motion of a study file."""
    study = load_study(path)
    with progress(f"{study.title}: motion"):
        trajectory = study_motion(study)
    title = f"{study.title}: nominal motion"
    out = out or Path(f"{study.name}.png")
    plots.save(plots.draw_trajectory(trajectory, study.scene, title=title), out)
    show(motion_blocks(trajectory, study.scene, title=title))
    written(out)


def replay_sample(directory: Path, sample: int, *, out: Path | None) -> None:
    """Integrate a sample of the run in ``directory`` again."""
    from tolmc.runs.run import replay  # loads what a run needs, which the nominal motion does without

    with progress(f"Sample {sample}"):
        study, scene, trajectory, row = replay(directory, sample)
    title = f"{study.title}: sample {sample}"
    out = out or directory / f"sample_{sample}.png"
    plots.save(plots.draw_trajectory(trajectory, scene, title=title), out)
    row = {study.tolerances.shown_names.get(name, name): value for name, value in row.items()}
    show([sample_table(row), *motion_blocks(trajectory, scene, title=title)])
    written(out)
