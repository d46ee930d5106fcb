"""tolmc: tolerance choice for a rotating body in a bearing with large clearance."""

from importlib import import_module

_HOME = {
    "approximate_radius": "geometry",
    "effective_radius": "geometry",
    "tilt_angle": "geometry",
    "Body": "mechanism",
    "Joint": "mechanism",
    "Loads": "mechanism",
    "Motion": "mechanism",
    "Scene": "mechanism",
    "Trajectory": "simulation",
    "simulate": "simulation",
    "simulate_many": "simulation",
    "Study": "study",
    "load_study": "study",
    "StudyResult": "monte_carlo",
    "run": "monte_carlo",
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
