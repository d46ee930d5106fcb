"""tolmc: tolerance choice for a rotating body in a bearing with large clearance."""

from importlib import import_module

_HOME = {
    "approximate_radius": "mechanism.geometry",
    "effective_radius": "mechanism.geometry",
    "tilt_angle": "mechanism.geometry",
    "Body": "mechanism.scene",
    "Joint": "mechanism.scene",
    "Loads": "mechanism.scene",
    "Motion": "mechanism.scene",
    "Scene": "mechanism.scene",
    "Trajectory": "simulation.trajectory",
    "simulate": "simulation.trajectory",
    "simulate_many": "simulation.ensemble",
    "Study": "study.study",
    "load_study": "study.file",
    "StudyResult": "runs.run",
    "run": "runs.run",
}

__all__ = sorted(_HOME)
__version__ = "0.1.0"


def __getattr__(name: str):
    # Loaded on first use: `tolmc --help` must not pay for Numba, SciPy and pandas.
    if name not in _HOME:
        raise AttributeError(f"module 'tolmc' has no attribute {name!r}")
    value = getattr(import_module(f"tolmc.{_HOME[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return [*globals(), *__all__]
