"""Several fits in one text: "H11/d11, H11/c11", with ranges of letters or grades "H11/a11-d11", "H7-H9/e8"."""

from __future__ import annotations

import re
import string

from tolmc.tolerances import fits

_CLASS = r"[A-Za-z]{1,2}\d{1,2}"
_FIT = re.compile(
    rf"(?P<size>[\d.]+\s+)?(?P<hole>{_CLASS}(?:\s*-\s*{_CLASS})?)\s*/\s*(?P<shaft>{_CLASS}(?:\s*-\s*{_CLASS})?)"
)


def fit_series(text: str, size: str | None) -> list[str]:
    """The fits that a text names, each with its size.

    Parameters
    ----------
    text : fits, with commas between them; a range holds both its ends
    size : nominal diameter in mm of fits that have none of their own

    Raises
    ------
    ValueError
        When the text is no list of fits, a class does not exist at the size, or there is no size.
    """
    found: dict[str, None] = {}
    for part in text.split(","):
        match = _FIT.fullmatch(part.strip())
        if match is None:
            raise ValueError(f"{part.strip()!r} is no fit; write fits such as 'H11/d11, H11/a11-c11'")
        nominal = (match["size"] or size or "").strip()
        if not nominal:
            raise ValueError(
                f"{part.strip()!r} has no size, and the study no fit; write one such as '40 {part.strip()}'"
            )
        for hole in _range(match["hole"], nominal):
            for shaft in _range(match["shaft"], nominal):
                found[fits.fit(f"{nominal} {hole}/{shaft}").designation] = None
    return list(found)


def _range(text: str, size: str) -> list[str]:
    """The classes of a range of letters or grades, both ends included; those between that the size lacks are left out."""
    ends = [re.fullmatch(r"([A-Za-z]+)(\d+)", end.strip()) for end in text.split("-")]
    (letter, grade), (last_letter, last_grade) = (match.groups() for match in (ends[0], ends[-1]) if match)
    if letter != last_letter and grade != last_grade:
        raise ValueError(f"{text!r} changes letter and grade; a range changes one of them")
    if grade != last_grade:
        low, high = sorted((int(grade), int(last_grade)))
        return [f"{letter}{number}" for number in range(low, high + 1)]
    if letter == last_letter:
        return [f"{letter}{grade}"]
    letters = string.ascii_uppercase if letter.isupper() else string.ascii_lowercase
    if not (letter in letters and last_letter in letters):
        raise ValueError(f"{text!r} is no range of letters; one goes from one letter to another, such as 'a11-d11'")
    low, high = sorted((letters.index(letter), letters.index(last_letter)))
    return [f"{between}{grade}" for between in letters[low : high + 1] if _exists(size, f"{between}{grade}")]


def _exists(size: str, tolerance_class: str) -> bool:
    try:
        fits.size_limits(f"{size} {tolerance_class}")
    except ValueError:
        return False
    return True
