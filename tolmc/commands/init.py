"""`tolmc init`: a commented study to begin with."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

from tolmc.errors import InputError

#: What there are studies of, the first when none is asked for.
KINDS = ("shaft", "spindle", "hinge", "rotor", "pin")


def example(kind: str) -> str:
    """Text of the study of this kind."""
    return files("tolmc.study").joinpath("examples", f"{kind}.toml").read_text(encoding="utf-8")


def write_example(path: Path, kind: str) -> None:
    """Write the study of this kind to a new file.

    Raises
    ------
    InputError
        When the file exists, or is no name of a study.
    """
    if path.suffix != ".toml":
        raise InputError(f"{path}: a study is a TOML file; call it {path.with_suffix('.toml')}.")
    try:
        with path.open("x", encoding="utf-8", newline="\n") as file:
            file.write(example(kind))
    except FileExistsError:
        raise InputError(f"{path} exists and is left as it is; choose another name.") from None
