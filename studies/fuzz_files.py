"""Damaged study files, CSV files of every dialect, and surroundings of every kind, for `fuzz.py` and the tests.

A case is run through the command line: one clear error, or the right result; never a traceback, a warning or a wrong number.
"""

from __future__ import annotations

import errno
import os
import warnings
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from unittest.mock import patch

import matplotlib as mpl
import numpy as np
import pandas as pd
from click.testing import CliRunner, Result

from tolmc import cli

#: What stands in the place of a value.
WORDS = (
    "nan", "inf", "-1", "0", "1e999", '""', '"5 kg"', '"1 m"', "true", "[]", "{}", '"x"', "9" * 400, "-1e308", "1979-05-27",
    '"20,5 mm"', '"20 ± 0.05 mm"', '"±0.05 mm"', '"1 234.5 mm"', '"20 MM"', '"20"', '"3000 U/min"', '"−20 mm"', '"25°"',
    '"40 H7"', '"40 h7"', '"40 d9/H7"', '"gaussian"', '"lhs"', '"csv\\bores.csv"', "'csv\\bores.csv'", "20 mm", "1,5", "-110",
    '{ nominal = 20 }', '{ max = "25 deg" }', '[1, "2 mm", 3]', "{ loc = 1 }", '"\\u0000"', "“20 mm”",
)  # fmt: skip
ENCODINGS = ("utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-32", "cp1252", "shift_jis")

STUDY = """title = "{title}"
[dimensions]
bearing_radius = {{ data = "measured.csv", column = "bore", unit = "0.5 mm"{notation} }}
journal_radius = {{ nominal = "19.9 mm", tolerance = "0.02 mm" }}
half_length = {{ nominal = "30 mm", tolerance = "0.1 mm" }}
[body]
mass = "2 kg"
solid_cylinder = {{ radius = "30 mm", length = "100 mm" }}
[motion]
alpha = "-100 deg"
beta = "-80 deg"
duration = "0.05 s"
[monte_carlo]
outputs = ["tilt_angle"]
workers = 1
"""
TITLES = ("Shaft", "Welle ⌀40 ± 0,1", "軸受", "a\\tb", "$x_{$", "\U0001f6de")


@dataclass(frozen=True)
class Case:
    """What came of a case: "run", "few computed", "refused" or "failed"; the rules that it broke, and how to see it again."""

    group: str
    outcome: str
    broken: tuple[str, ...]
    shown: str


def run_study(study: Path, out: Path, charset: str = "utf-8") -> Result:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        command = ["run", str(study), "--samples", "64", "--out", str(out)]
        return CliRunner(charset=charset).invoke(cli.main, command)


def _case(group: str, result: Result, out: Path, shown: str, *, wrong: str = "", may_fail: bool = False) -> Case:
    message = result.stderr.strip()
    refused = result.exit_code == 2 and "Error: " in message
    few = result.exit_code == 4 and result.stdout.strip().startswith(("Only ", "None of the "))  # samples computed
    ran = result.exit_code == 0 or few
    told = result.exit_code == 1 and "Error: " in message and str(out) in message and message.endswith(".")
    rules = {
        "a traceback": not isinstance(result.exception, (SystemExit, type(None))),
        "something is left behind by what was refused": refused and out.exists(),
        "neither run nor refused": not (ran or refused or (may_fail and told)),
        wrong: bool(wrong) and ran,
    }
    broken = tuple(rule for rule, is_broken in rules.items() if is_broken)
    outcome = "few computed" if few else "run" if ran else "refused" if refused else "failed"
    return Case(group, outcome, broken, f"{result.exception!r}\n{result.output[-2000:]}\n{shown}")


def study_case(rng: np.random.Generator, folder: Path, number: int, texts: list[str]) -> Case:
    """A study with one to three damages, in any encoding and with any ends of lines; geometry alone is quick."""
    lines = [
        line for line in rng.choice(texts).splitlines() if not line.startswith(("contact_force", "outputs", "until"))
    ]
    lines.insert(lines.index("[monte_carlo]") + 1, 'outputs = ["tilt_angle"]')
    for _ in range(rng.integers(1, 4)):
        damage(rng, lines)
    encoding = str(rng.choice(ENCODINGS)) if rng.random() < 0.3 else "utf-8"
    content = (
        str(rng.choice(["\n", "\r\n", "\n", "\r"], p=(0.7, 0.2, 0.05, 0.05))).join(lines).encode(encoding, "replace")
    )
    if rng.random() < 0.1:
        content = content[: rng.integers(len(content))] + bytes(rng.integers(0, 256, 3).tolist())
    file, out = folder / "study.toml", folder / f"run {number}"
    file.write_bytes(content)
    return _case("study files", run_study(file, out), out, repr(content))


def damage(rng: np.random.Generator, lines: list[str]) -> None:
    """One random change of the text: a line lost, doubled, moved or cut, or a value replaced."""
    at = int(rng.integers(len(lines)))
    kind = rng.integers(8)
    if kind == 0:
        del lines[at]
    elif kind == 1:
        lines.insert(at, lines[at])
    elif kind == 2:
        lines.insert(int(rng.integers(len(lines))), lines.pop(at))
    elif kind == 3:
        lines[at] = lines[at][: rng.integers(len(lines[at]) + 1)]
    elif "=" in lines[at]:
        name, _, value = lines[at].partition("=")
        word = WORDS[rng.integers(len(WORDS))]
        inner = value.find("= ") if kind > 5 else -1  # the first value within a table
        lines[at] = f"{name}={value[: inner + 2]}{word} }}" if inner > 0 else f"{name}= {word}"


def csv_case(rng: np.random.Generator, folder: Path, number: int) -> Case:
    """A CSV file in a random dialect, read as it is or as some other; bores of 40.39 to 40.41 mm are right, all else wrong."""
    separator, decimal = str(rng.choice([",", ";", "\t", "|"])), str(rng.choice([".", ","]))
    bores = np.round(rng.uniform(40.39, 40.41, rng.integers(2, 12)), 4)
    header, rows = ["bore", "chamfer"], [[f"{bore:.4f}", f"{bore + 1.1:.4f}"] for bore in bores]
    if rng.random() < 0.3:
        header, rows = ["bore"], [row[:1] for row in rows]
    elif rng.random() < 0.3:
        header, rows = header[::-1], [row[::-1] for row in rows]
    quote = '"' if rng.random() < 0.3 else ""
    lines = [
        separator.join(header),
        *(separator.join(f"{quote}{v.replace('.', decimal)}{quote}" for v in r) for r in rows),
    ]
    for _ in range(rng.integers(0, 3)):
        _damage_rows(rng, lines, separator)
    encoding = str(rng.choice(ENCODINGS)) if rng.random() < 0.3 else "utf-8"
    content = str(rng.choice(["\n", "\r\n"])).join(lines).encode(encoding)
    says = {"separator": separator, "decimal": decimal} if rng.random() < 0.6 else {}
    if rng.random() < 0.2:
        says = {"separator": str(rng.choice([",", ";", "\t", "|"])), "decimal": str(rng.choice([".", ","]))}
    notation = "".join(f", {key} = {value!r}" for key, value in says.items()).replace("'", '"')
    file, out = folder / "study.toml", folder / f"csv {number}"
    file.write_text(STUDY.format(title="Shaft", notation=notation), "utf-8")
    (folder / "measured.csv").write_bytes(content)
    result = run_study(file, out)
    wrong = ""
    if result.exit_code in (0, 4):
        found = 2e3 * pd.read_parquet(out / "samples.parquet")["bearing_radius"].to_numpy()
        if not np.isclose(found[:, None], bores, rtol=0, atol=1e-9).any(axis=1).all():
            wrong = "numbers that no part has"
    return _case("CSV files", result, out, f"{content!r}\n{notation}", wrong=wrong)


def _damage_rows(rng: np.random.Generator, lines: list[str], separator: str) -> None:
    at = int(rng.integers(len(lines)))
    changes = (
        lambda line: line + separator,
        lambda line: line + separator + "7.5",
        lambda line: line.partition(separator)[0],
        lambda line: "",
        lambda line: line.replace(separator, separator + " "),
        lambda line: line + '"',
        lambda line: f"# {line}",
        lambda line: line.replace("40", "4O"),
        lambda line: separator + line,
        lambda line: "nan",
    )
    lines[at] = changes[rng.integers(len(changes))](lines[at])


def surroundings_case(rng: np.random.Generator, folder: Path, number: int) -> Case:
    """A sound study in odd surroundings: streams, encodings, Matplotlib's settings, what filesystems answer."""
    file, out = folder / "study.toml", folder / f"surroundings {number}"
    file.write_text(STUDY.format(title=str(rng.choice(TITLES)), notation=""), "utf-8")
    (folder / "measured.csv").write_text("bore\n40.39\n40.40\n40.41\n", "utf-8")
    full = rng.random() < 0.1
    chosen, charset = [], str(rng.choice(["utf-8", "cp1252", "ascii", "cp437"]))
    with ExitStack() as stack:
        for name, surroundings in SURROUNDINGS.items():
            if rng.random() < 0.4:
                chosen.append(name)
                stack.enter_context(surroundings(rng))
        if full:
            chosen.append("full disk")
            stack.enter_context(_refusing("os.fsync", errno.ENOSPC))
        result = run_study(file, out, charset)
    may_fail = full or "flush" in chosen
    return _case("surroundings", result, out, f"{chosen}, {charset}", may_fail=may_fail)


def _refusing(name: str, number: int):
    def refuse(*_):
        raise OSError(number, os.strerror(number))

    return patch(name, refuse)


_SETTINGS = (
    {"text.usetex": True}, {"font.family": ["No Such Font"]}, {"savefig.bbox": "tight"}, {"figure.dpi": 1.0},
    {"axes.formatter.use_locale": True}, {"figure.constrained_layout.use": True}, {"path.sketch": (1.0, 100.0, 2.0)},
)  # fmt: skip
_ENVIRONMENT = (
    {"MPLBACKEND": "module://matplotlib_inline.backend_inline"}, {"MPLBACKEND": "nonsense"}, {"HOME": "/nonexistent"},
    {"COLUMNS": "1"}, {"TERM": "dumb"}, {"NO_COLOR": "1"}, {"FORCE_COLOR": "1"}, {"LC_ALL": "C"}, {"TZ": "nowhere"},
)  # fmt: skip
SURROUNDINGS: dict[str, Callable] = {
    "matplotlibrc": lambda rng: mpl.rc_context(_SETTINGS[rng.integers(len(_SETTINGS))]),
    "environment": lambda rng: patch.dict(os.environ, _ENVIRONMENT[rng.integers(len(_ENVIRONMENT))]),
    "no flush": lambda rng: _refusing(
        "os.fsync", int(rng.choice([errno.EINVAL, errno.ENOTSUP, errno.ENOSYS, errno.EPERM]))
    ),
    "no locks": lambda rng: _refusing("fcntl.flock", int(rng.choice([errno.ENOLCK, errno.ENOTSUP, errno.ENOSYS]))),
    "no pictures": lambda rng: patch("tolmc.pictures.plots.save", side_effect=RuntimeError("no font")),
}


def cases(rng: np.random.Generator, folder: Path, count: int, texts: list[str]) -> Iterator[Case]:
    """``count`` cases: six of ten are study files, three CSV files, one surroundings."""
    for number in range(count):
        kind = number % 10
        if kind < 6:
            yield study_case(rng, folder, number, texts)
        elif kind < 9:
            yield csv_case(rng, folder, number)
        else:
            yield surroundings_case(rng, folder, number)
