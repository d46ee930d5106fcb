"""From a study file (TOML) to a validated :class:`Study`.

Numbers are SI; strings carry their unit ("20 mm", "-110 deg", "1500 rpm"). Whatever is unknown, missing, of the wrong
kind or out of range ends in a :class:`StudyError` that names the field, its value, what is allowed and what to do.
"""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

from tolmc.encoding import decoded
from tolmc.errors import StudyError
from tolmc.study.fields import Faults, short
from tolmc.study.study import Study


def load_study(path: str | Path, *, data_folder: str | Path | None = None) -> Study:
    """Read and check a study file.

    Parameters
    ----------
    path : path of a TOML file
    data_folder : path, optional
        Folder to which the names of data files are relative; that of the study file when not given.

    Raises
    ------
    StudyError
        With everything that is wrong in the first section that has faults.
    """
    path = Path(path)
    try:
        source = decoded(path.read_bytes())
    except OSError as error:
        raise StudyError(f"{path} cannot be read: {error.strerror or error}. Check the path of the study.") from None
    except ValueError as error:
        raise StudyError(f"{path} has {error}. A study is a TOML file.") from None
    try:
        content = tomllib.loads(source)
    except (ValueError, RecursionError) as error:
        raise StudyError(f"{path} is no valid TOML: {error}.{_toml_remedy(str(error), source)}") from None
    try:
        return Study.of_file(content, source, name=path.stem, data_folder=data_folder or path.parent)
    except Faults as faults:
        raise StudyError("\n".join(f"{path}: {sentence}" for sentence in faults.sentences)) from None


def _toml_remedy(error: str, source: str) -> str:
    """What to do about a sentence of the TOML reader, by the line that it names."""
    at = re.search(r"at line (\d+)", error)
    line = source.splitlines()[int(at[1]) - 1].strip() if at and int(at[1]) <= len(source.splitlines()) else ""
    if error.startswith("Cannot overwrite"):
        key = line.partition("=")[0].strip()
        return f" {key} is given twice in its table: {short(line)} and before; keep one."
    if error.startswith("Cannot declare"):
        return f" {line.partition('#')[0].strip()} is there twice; put everything of it below one."
    if "\\" in line and '"' in line:
        return f" In {short(line)} a backslash starts an escape; write paths with / or in single quotes."
    if re.search("[\u2018\u2019\u201c\u201d\u201e]", line):
        return f' {short(line)} has typographic quotes; write ".'
    if re.search(r"=\s*[+-]?[0-9.]+\s*[A-Za-z°µ%]", line):
        return f' In {short(line)} a value with a unit needs quotes, such as "20 mm".'
    if re.search(r"=\s*[+-]?[0-9]+,[0-9]", line):
        return f" In {short(line)} the decimal sign is a comma; write a point."
    return " See https://toml.io for the syntax."
