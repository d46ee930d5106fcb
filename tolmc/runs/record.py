"""What run.json says of a run: written, read back and checked field by field."""

from __future__ import annotations

import json
import math
import platform
from collections.abc import Mapping
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError

from tolmc import __version__
from tolmc.errors import InputError
from tolmc.study.fields import short
from tolmc.study.sections import MAX_SAMPLES
from tolmc.tolerances.unit_cube import SAMPLINGS

#: Number of the layout above. Raise it when the layout changes, and teach :func:`read_record` the earlier one.
FORMAT = 1
_PACKAGES = ("numpy", "numba", "scipy", "pandas", "pyarrow")


class RunDirectoryError(InputError):
    """A directory that a run may not use; the message says why and what to do."""


class _Recorded(BaseModel):
    # What a later version adds passes: it is that version's to judge.
    model_config = ConfigDict(extra="allow", strict=True)


def _read_infinity(value: object) -> object:
    return math.inf if value == "Infinity" else value


class _Plan(_Recorded):
    """A plan of integration, tolmc.simulation.plan.Plan, in JSON: an infinite error is a word there."""

    formulation: Literal["slope", "published", "published-regular"]
    method: Literal["rk4", "rk8"]
    steps: Annotated[int, Field(ge=1, le=10**9)]
    accuracy: Annotated[float, Field(gt=0, allow_inf_nan=False)]
    pilot_error: Annotated[float, BeforeValidator(_read_infinity), Field(ge=0)] = 0.0
    features: dict[str, bool] = Field(default_factory=dict)
    halving: bool = False
    unresolved: Annotated[int, Field(ge=0)] = 0
    chaotic: Annotated[int, Field(ge=0)] = 0
    bounded: bool = False
    agrees_until: Annotated[float, Field(gt=0, allow_inf_nan=False)] | None = None
    growth: Annotated[float, Field(gt=0, allow_inf_nan=False)] | None = None
    agreeing_impacts: Annotated[int, Field(ge=-1)] = -1


_Count = Annotated[int, Field(ge=1, le=MAX_SAMPLES)]


class _Record(_Recorded):
    """What run.json must hold for a run to go on."""

    title: str
    study_sha256: Annotated[str, Field(pattern="^[0-9a-f]{64}$")]
    samples: _Count
    #: Of a sequential run: its largest number of samples, and the number at which it stopped once it did.
    most_samples: _Count | None = None
    stopped_at: _Count | None = None
    #: What the choice of the step has left to say.
    pilot: str = ""
    sampling: Literal[SAMPLINGS]
    seed: Annotated[int, Field(ge=0, lt=2**63)]
    block: Annotated[int, Field(ge=1)]
    plan: _Plan
    state: Literal["running", "complete"]
    versions: dict[str, str]


def versions() -> dict[str, str]:
    """Versions of everything that takes part in a run's numbers."""
    return {"python": platform.python_version(), "tolmc": __version__, **{name: _version(name) for name in _PACKAGES}}


@cache
def _version(package: str) -> str:
    return version(package)


def read_record(path: Path) -> dict:
    file = path / "run.json"
    try:
        # Infinity and NaN, which are no JSON but which Python reads and once wrote, are words from here on.
        record = json.loads(file.read_text(encoding="utf-8"), parse_constant=str)
    except (FileNotFoundError, NotADirectoryError):
        raise RunDirectoryError(f"{path} is no run directory: it has no run.json. Give one that a run wrote.") from None
    except (OSError, ValueError, RecursionError) as error:
        raise RunDirectoryError(f"{file} cannot be read: {error}. Restore it, or run into a new directory.") from None
    if not isinstance(record, dict) or not isinstance(record.get("format"), int):
        raise RunDirectoryError(f"{file} was not written by tolmc. Choose another directory.")
    if record["format"] > FORMAT:
        raise RunDirectoryError(
            f"{file} has format {record['format']}, this tolmc reads formats up to {FORMAT}. Update tolmc."
        )
    try:
        _Record.model_validate(record)
    except ValidationError as error:
        raise RunDirectoryError(
            f"{file} is damaged: {_fault(error.errors(include_url=False)[0])}. Restore it, or run anew."
        ) from None
    return record


def _fault(item: Mapping[str, Any]) -> str:
    field = ".".join(str(part) for part in item["loc"])
    if item["type"] == "missing":
        return f"{field} is missing"
    return f"{field} = {short(item['input'])}: {item['msg'][0].lower()}{item['msg'][1:]}"
