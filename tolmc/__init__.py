"""tolmc: tolerance choice for a rotating body in a bearing with large clearance."""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tolmc.commands.allocate import allocate as allocate
    from tolmc.mechanism.geometry import approximate_radius as approximate_radius
    from tolmc.mechanism.geometry import effective_radius as effective_radius
    from tolmc.mechanism.geometry import tilt_angle as tilt_angle
    from tolmc.mechanism.loads import Harmonic as Harmonic
    from tolmc.mechanism.loads import Loads as Loads
    from tolmc.mechanism.loads import Oscillation as Oscillation
    from tolmc.mechanism.operating import Operating as Operating
    from tolmc.mechanism.scene import Body as Body
    from tolmc.mechanism.scene import Joint as Joint
    from tolmc.mechanism.scene import Motion as Motion
    from tolmc.mechanism.scene import Scene as Scene
    from tolmc.report.write import write_report as write_report
    from tolmc.runs.life import LifeResult as LifeResult
    from tolmc.runs.life import life as life
    from tolmc.runs.run import StudyResult as StudyResult
    from tolmc.runs.run import replay as replay
    from tolmc.runs.run import resume as resume
    from tolmc.runs.run import run as run
    from tolmc.simulation.ensemble import simulate_many as simulate_many
    from tolmc.simulation.trajectory import Trajectory as Trajectory
    from tolmc.simulation.trajectory import simulate as simulate
    from tolmc.study.file import load_study as load_study
    from tolmc.study.study import Study as Study
    from tolmc.tolerances.dimension import Dimension as Dimension
    from tolmc.tolerances.dimension import Tolerances as Tolerances

__version__ = "0.2.0"

#: Where the public names live; the imports above say the same to type checkers and editors.
_HOME = {
    "Body": "mechanism.scene",
    "Dimension": "tolerances.dimension",
    "Harmonic": "mechanism.loads",
    "Joint": "mechanism.scene",
    "LifeResult": "runs.life",
    "Loads": "mechanism.loads",
    "Motion": "mechanism.scene",
    "Operating": "mechanism.operating",
    "Oscillation": "mechanism.loads",
    "Scene": "mechanism.scene",
    "Study": "study.study",
    "StudyResult": "runs.run",
    "Tolerances": "tolerances.dimension",
    "Trajectory": "simulation.trajectory",
    "allocate": "commands.allocate",
    "approximate_radius": "mechanism.geometry",
    "effective_radius": "mechanism.geometry",
    "life": "runs.life",
    "load_study": "study.file",
    "replay": "runs.run",
    "resume": "runs.run",
    "run": "runs.run",
    "simulate": "simulation.trajectory",
    "simulate_many": "simulation.ensemble",
    "tilt_angle": "mechanism.geometry",
    "write_report": "report.write",
}

__all__ = sorted(_HOME)


if not TYPE_CHECKING:  # to whom any name would be public

    def __getattr__(name: str) -> object:
        # Loaded on first use: `tolmc --help` must not pay for Numba, SciPy and pandas.
        if name not in _HOME:
            raise AttributeError(f"module 'tolmc' has no attribute {name!r}")
        value = getattr(import_module(f"tolmc.{_HOME[name]}"), name)
        globals()[name] = value
        return value


def __dir__() -> list[str]:
    return [*globals(), *__all__]
