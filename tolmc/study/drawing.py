"""Sizes as a drawing gives them: "40 ±0.05 mm", "40 +0.1/-0.2 mm", "⌀40 H7", "±5 g".

A drawing gives diameters and whole lengths. A study may name these, ``bearing_diameter`` for ``bearing_radius``,
``journal_diameter`` for ``journal_radius``, ``bearing_length`` for ``half_length``; the model takes half of what is written.
"""

from __future__ import annotations

import re
from typing import Any

from tolmc import quantities

#: What a study may call the dimension of the model, which is half of it.
MODEL_NAMES = {drawn: name for name, drawn in quantities.DRAWN.items()}

_NUMBER = r"(?:\d+(?:\.\d*)?|\.\d+)"
_UNIT = r"[^\W\d_](?:[^\d+±/^-]|/\s*[^\W\d_]|\^\d)*?|°|%"
_SIZE = re.compile(
    rf"\s*(?P<diameter>[⌀Øø∅])?\s*(?P<nominal>[+-]?{_NUMBER})?\s*(?P<unit>{_UNIT})?\s*"
    rf"(?:(?:±|\+/-|\+-)\s*(?P<plus_minus>{_NUMBER})|(?P<first>(?:[+-]\s*|(?<![\d.])){_NUMBER})\s*/\s*(?P<second>[+-]?\s*{_NUMBER}))"
    rf"\s*(?P<last_unit>{_UNIT})?\s*"
)
_CLASS = re.compile(r"\s*(?P<diameter>[⌀Øø∅])?\s*\d+(?:\.\d+)?\s*(?:mm)?\s*[A-Za-z]{1,2}\d{1,2}\s*")
_ALONE = re.compile(
    rf"\s*[⌀Øø∅]?\s*(?P<nominal>{_NUMBER})\s*(?:{_UNIT})?\s+(?P<deviation>[+-]\s*{_NUMBER})\s*(?P<unit>(?:{_UNIT})?)\s*"
)
_PLAIN = re.compile(r"\s*[⌀Øø∅]\s*(?P<rest>.*)")


def model_name(name: str) -> str:
    """The model's name of a dimension that a study names."""
    return MODEL_NAMES.get(name, name)


def size(name: str, text: str) -> dict[str, Any]:
    """A size or tolerance in one text as the table that says the same; any other text is a nominal value.

    Parameters
    ----------
    name : what the study calls the dimension
    text : such as "40 ±0.05 mm", "40 mm +0.1/-0.2 mm", "⌀40 H7", "±5 g"

    Raises
    ------
    ValueError
        When it is a diameter's, and the dimension is none; or deviations have no sign, or no unit.
    """
    if re.search(r"\d,\d", text) and re.search("±|[+]/?-|/", text):
        raise ValueError("its decimal sign is a comma; write a point, such as '40.5 ±0.05 mm'")
    if _CLASS.fullmatch(text):
        _refuse_other(name, "a tolerance class is for a diameter or a whole length")
        return {"diameter": text}
    match = _SIZE.fullmatch(text)
    sign = _PLAIN.fullmatch(text)
    if sign is not None:
        _refuse_other(name, "⌀ is a diameter")
    if match is None and (alone := _ALONE.fullmatch(text)):
        raise ValueError(
            f"it has one deviation; write both, such as '{alone['nominal'].strip()} {_both(alone['deviation'])} "
            f"{alone['unit'].strip() or 'mm'}', or ± for equal ones"
        )
    if match is None:
        return {"nominal": text if sign is None else sign["rest"]}
    unit = match["last_unit"] or match["unit"]
    if unit is None:
        raise ValueError("it has no unit; write it behind the tolerance, such as '40 ±0.05 mm'")
    found = {"tolerance": _deviations(match, unit)}
    if match["nominal"] is not None:
        found["nominal"] = f"{match['nominal']} {match['unit'] or unit}"
    return found


def deviations(text: str) -> str | list[str]:
    """A tolerance in one text, "±0.05 mm" or "+0.1/-0.2 mm", as one value or two; any other text as it is."""
    match = _SIZE.fullmatch(text)
    if match is None or match["nominal"] is not None or match["diameter"] is not None:
        return text
    unit = match["last_unit"] or match["unit"]
    if unit is None:
        raise ValueError("it has no unit; write it behind the tolerance, such as '+0.1/-0.2 mm'")
    return _deviations(match, unit)


def _both(deviation: str) -> str:
    deviation = deviation.replace(" ", "")
    return f"{deviation}/0" if deviation.startswith("+") else f"0/{deviation}"


def _deviations(match: re.Match, unit: str) -> str | list[str]:
    if match["plus_minus"] is not None:
        return f"{match['plus_minus']} {unit}"
    numbers = [match[part].replace(" ", "") for part in ("first", "second")]
    if any(number[0] not in "+-" and float(number) != 0 for number in numbers):
        raise ValueError("a deviation has no sign; write both with one, such as '40 +0.1/-0.2 mm'")
    return [f"{number} {unit}" for number in sorted(numbers, key=float)]


def _refuse_other(name: str, reason: str) -> None:
    if name not in MODEL_NAMES:
        drawn = quantities.DRAWN.get(name)
        remedy = f"call it {drawn}" if drawn else f"{name} is neither"
        raise ValueError(f"{reason}: {remedy}")
