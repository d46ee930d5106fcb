"""Where a study file writes its dimensions and its limits: the lines that a changed study has others for."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import tomli_w

from tolmc.quantities import DRAWN
from tolmc.study.drawing import model_name


@dataclass(frozen=True)
class Slot:
    """A line of a study file that gives dimensions.

    Attributes
    ----------
    line : number of the line, from 0
    word : what stands before its equals sign
    names : of the dimensions, as the model has them
    comment : at its end, with the sign
    drops : lines that go where the dimensions of a fit are written one by one
    """

    line: int
    word: str
    names: tuple[str, ...]
    comment: str = ""
    drops: tuple[int, ...] = ()


@dataclass(frozen=True)
class Requirements:
    """Where a study file writes its [specification].

    Attributes
    ----------
    lines : {output, or target: (number of its line, comment at its end)}
    after : number of the line below which others go; None: the study has no such section
    """

    lines: Mapping[str, tuple[int, str]]
    after: int | None


def study_slots(source: str, names: Iterable[str]) -> tuple[str, list[Slot], Requirements]:
    """The study file with a line for each of the dimensions ``names`` and each limit, and these lines.

    It is the study's own text where each of them has a line in it, else the same study written anew.
    """
    content = tomllib.loads(source)
    words = _words(content["dimensions"], names)
    slots, requirements = _found(source, content, words), _requirements(source, content)
    if slots is None or requirements is None:
        source = _rewritten(content)
        slots, requirements = _found(source, content, words), _requirements(source, content)
    if slots is None:  # a text of the study that no line holds
        slots = []
    return source, slots, requirements or Requirements({}, None)


def _requirements(source: str, content: Mapping[str, Any]) -> Requirements | None:
    if "specification" not in content:
        return Requirements({}, None)
    lines, header = _lines(source, content, "specification")
    if header is None or not set(content["specification"]) <= set(lines):
        return None
    return Requirements(lines, max([header, *(number for number, _ in lines.values())]))


def _words(table: Mapping[str, Any], names: Iterable[str]) -> dict[str, tuple[str, ...]]:
    """{word of the table that sets the limits: the dimensions that it sets}."""
    written = {model_name(word): word for word in table}
    words: dict[str, tuple[str, ...]] = {}
    for name in names:
        entry = table.get(written.get(name, ""))
        sets_limits = not isinstance(entry, dict) or {"tolerance", "size", "lower", "diameter"} & set(entry)
        if name in written and (sets_limits or "fit" not in table):
            word = written[name]
        else:
            word = "fit" if name in DRAWN else "unbalance"
        words[word] = (*words.get(word, ()), name)
    if "fit" in words:
        words["fit"] = ("bearing_radius", "journal_radius")
    return words


def _found(source: str, content: Mapping[str, Any], words: Mapping[str, tuple[str, ...]]) -> list[Slot] | None:
    lines, _ = _lines(source, content, "dimensions")
    if not set(words) <= set(lines):
        return None
    own = {model_name(word): number for word, (number, _) in lines.items()}
    return [
        Slot(
            lines[word][0],
            word,
            names,
            lines[word][1],
            tuple(own[name] for name in names if name in own) if word == "fit" else (),
        )
        for word, names in words.items()
    ]


def _lines(source: str, content: Mapping[str, Any], table: str) -> tuple[dict[str, tuple[int, str]], int | None]:
    """{word: its line and the comment there} of the entries of a table with a line of their own; the line of its header."""
    found, header, section = {}, None, ""
    for number, line in enumerate(source.split("\n")):
        if title := re.match(r"\s*\[([^\[\]]*)\]\s*(#.*)?$", line):
            section = title[1].strip()
            header = number if section == table else header
        match = re.match(r"\s*([\w-]+)\s*=", line)
        if section != table or match is None or match[1] not in content[table]:
            continue
        for end in [*(place for place, sign in enumerate(line) if sign == "#"), len(line)]:
            if _parsed(line[:end]) == {match[1]: content[table][match[1]]}:
                found[match[1]] = number, line[end:]
                break
    return found, header


def _parsed(line: str) -> dict[str, Any] | None:
    try:
        return tomllib.loads(line)
    except tomllib.TOMLDecodeError:
        return None


def _rewritten(content: Mapping[str, Any]) -> str:
    by_line = [name for name in ("dimensions", "specification") if name in content]
    top = {key: value for key, value in content.items() if not isinstance(value, dict)}
    rest = {key: value for key, value in content.items() if isinstance(value, dict) and key not in by_line}
    tables = [
        "\n".join([f"[{name}]", *(f"{word} = {inline(value)}" for word, value in content[name].items()), ""])
        for name in by_line
    ]
    return "\n".join([tomli_w.dumps(top), *tables, tomli_w.dumps(rest)])


def inline(value: Any) -> str:
    """A value as TOML writes it within a line."""
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{json.dumps(key)} = {inline(part)}" for key, part in value.items()) + " }"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(inline, value)) + "]"
    return json.dumps(value, ensure_ascii=False) if isinstance(value, str | bool) else repr(value)
