"""ISO 286 limits of size: ``limits(50, "H7")`` and ``fit("40 H7/d9")``.

A tolerance class such as H7 is a fundamental deviation (the letter: capital for a hole, small for a shaft)
and a standard tolerance grade (IT7, the width). The tables (folder iso286) hold the values of ISO 286-1:2010
in micrometres, the rest follows from the standard's rules, with a..h for clearance, k..zc for transition and interference:

- shaft a..h: es = -table, ei = es - IT; shaft k..zc: ei = table, es = ei + IT;
- hole A..H: EI = table, ES = EI + IT; hole K..ZC: ES = -table + Delta, EI = ES - IT, where
  Delta = IT_n - IT_(n-1) for sizes over 3 up to 500 mm in K, M, N up to IT8 and P..ZC up to IT7, else 0;
- js, JS: +-IT/2, unrounded as in the edition of 2010 (that of 1988 rounded JS7..JS11 to whole micrometres);
- j, J: values of their own.
"""

from __future__ import annotations

import re
from bisect import bisect_left
from dataclasses import dataclass
from pathlib import Path
from typing import cast

GRADES = ("01", "0", *(str(n) for n in range(1, 19)))


class _Table:
    """A table by size (rows, mm, up to and including) and column name, micrometres; '-' is undefined."""

    def __init__(self, name: str) -> None:
        text = (Path(__file__).parent / "iso286" / f"{name}.txt").read_text(encoding="utf-8")
        lines = [line.split() for line in text.splitlines() if not line.startswith("#")]
        self.columns = tuple(lines.pop(0))
        self.sizes = [float(line[0]) for line in lines]
        self.rows = [dict(zip(self.columns, line[1:], strict=True)) for line in lines]

    def __call__(self, size: float, column: str) -> float:
        row = bisect_left(self.sizes, size)
        if row == len(self.sizes) or self.rows[row][column] == "-":
            defined = [k for k, values in enumerate(self.rows) if values[column] != "-"]
            lowest = self.sizes[defined[0] - 1] if defined[0] else 0.0
            raise ValueError(
                f"ISO 286: {column} is not defined at {size:g} mm; allowed: over {lowest:g} up to "
                f"{self.sizes[defined[-1]]:g} mm. Choose another letter or grade, or give the limits."
            )
        return float(self.rows[row][column])


_it = _Table("grades")
_clearance = _Table("clearance")
_interference = _Table("interference")
_j = _Table("j")

_LETTERS = (*_clearance.columns, "js", "j", *_interference.columns)


def _size(size_mm: float) -> float:
    size = float(size_mm)
    if not 0.0 < size <= _it.sizes[-1]:
        raise ValueError(
            f"ISO 286: size = {size_mm!r} mm is out of range; allowed: 0 < size <= {_it.sizes[-1]:g} mm. "
            "Give the limits instead."
        )
    return size


def _grade(grade: int | str) -> str:
    text = str(grade).upper().removeprefix("IT")
    if text not in GRADES:
        raise ValueError(f"ISO 286: grade {grade!r} is unknown; allowed: {', '.join(GRADES)}, with or without 'IT'.")
    return text


def it_grade(size_mm: float, grade: int | str) -> float:
    """Standard tolerance of a grade (ISO 286-1, table 1): the width of the tolerance zone.

    Parameters
    ----------
    size_mm : float, mm
        Nominal size (a diameter), 0 < size <= 3150.
    grade : int or str
        1 ... 18, "01" or 0; "IT7" is read as 7. IT01 and IT0 end at 500 mm.

    Returns
    -------
    float, m
        Of the diameter: a radius has half of it.

    Raises
    ------
    ValueError
        When size or grade is outside the standard; the message says what is allowed.
    """
    return _it(_size(size_mm), f"IT{_grade(grade)}") / 1e6


def limits(size_mm: float, designation: str) -> tuple[float, float]:
    """Lower and upper limit deviation of a tolerance class.

    Parameters
    ----------
    size_mm : float, mm
        Nominal size (a diameter), 0 < size <= 3150.
    designation : str
        Letter and grade: "H7" (capital: hole), "d9" (small: shaft).

    Returns
    -------
    (lower, upper) : float, m
        Deviations of the diameter from the nominal size: EI, ES of a hole, ei, es of a shaft.

    Raises
    ------
    ValueError
        When the class is unknown or the standard has no value for it at this size.
    """
    size = _size(size_mm)
    match = re.fullmatch(r"([A-Z]{1,2}|[a-z]{1,2})(01|\d{1,2})", designation)
    if match is None or match[1].lower() not in _LETTERS:
        raise ValueError(
            f"ISO 286: tolerance class {designation!r} is unknown; allowed: a letter of {' '.join(_LETTERS)} "
            "(capitals for holes) and a grade, such as 'H7' or 'd9'."
        )
    letter, grade = match[1], _grade(match[2])
    width = _it(size, f"IT{grade}")
    if letter.lower() == "js":
        lower, upper = -width / 2, width / 2
    elif letter.isupper():
        lower, upper = _hole(size, letter.lower(), grade, width)
    else:
        lower, upper = _shaft(size, letter, grade, width)
    return lower / 1e6, upper / 1e6


def _shaft(size: float, letter: str, grade: str, width: float) -> tuple[float, float]:
    if letter in _clearance.columns:
        upper = 0.0 - _clearance_deviation(size, letter)  # not a unary minus: -0.0 would be printed
        return upper - width, upper
    if letter == "j":
        lower = _j(size, _known(letter + grade))
    elif letter == "k" and grade not in ("4", "5", "6", "7"):
        lower = 0.0
    else:
        lower = _interference(size, letter)
    return lower, lower + width


def _hole(size: float, letter: str, grade: str, width: float) -> tuple[float, float]:
    if letter in _clearance.columns:
        lower = _clearance_deviation(size, letter)
        return lower, lower + width
    upper = _j(size, _known("J" + grade)) if letter == "j" else _upper_of_tight_hole(size, letter, grade)
    return upper - width, upper


def _clearance_deviation(size: float, letter: str) -> float:
    if letter in "ab" and size <= 1.0:
        raise ValueError(
            f"ISO 286: {letter}, {letter.upper()} are not defined up to 1 mm, got {size:g} mm; choose c or C."
        )
    return _clearance(size, letter)


def _known(tolerance_class: str) -> str:
    if tolerance_class not in _j.columns:
        raise ValueError(
            f"ISO 286: {tolerance_class} is not defined; allowed: {', '.join(_j.columns)}. "
            "Choose js or JS, which have every grade."
        )
    return tolerance_class


def _upper_of_tight_hole(size: float, letter: str, grade: str) -> float:
    """ES of a hole K .. ZC, micrometres, with the standard's Delta rule and its exceptions."""
    number = 0 if grade == "01" else int(grade)
    deviation = _interference(size, letter)
    if letter == "k" and number > 8 and size > 3.0:
        raise ValueError(
            f"ISO 286: K{grade} is not defined at {size:g} mm; above 3 mm K ends at grade 8. "
            f"Choose JS{grade} or N{grade}."
        )
    if letter == "n" and number > 8 and size <= 500.0:
        if size <= 1.0:
            raise ValueError(f"ISO 286: N{grade} is not defined up to 1 mm, got {size:g} mm; choose JS{grade}.")
        if size > 3.0:
            return 0.0
    delta_applies = 3.0 < size <= 500.0 and number <= (8 if letter in "kmn" else 7)
    if not delta_applies:
        return 0.0 - deviation
    if number < 3:
        raise ValueError(
            f"ISO 286: {letter.upper()}{grade} is not defined at {size:g} mm; between 3 and 500 mm holes "
            "K..ZC begin at grade 3. Choose JS or a coarser grade."
        )
    if (letter, number) == ("m", 6) and 250.0 < size <= 315.0:
        return -9.0  # the standard's one exception to the rule, which would give -11
    return -deviation + _it(size, f"IT{number}") - _it(size, f"IT{number - 1}")


@dataclass(frozen=True)
class Fit:
    """A hole and a shaft of the same nominal size.

    Parameters
    ----------
    designation : str
        As written, such as "40 H7/d9".
    size : float, m
        Nominal diameter.
    hole, shaft : (lower, upper), m
        Limit deviations of the diameters.
    """

    designation: str
    size: float
    hole: tuple[float, float]
    shaft: tuple[float, float]

    @property
    def toleranced_sizes(self) -> tuple[str, str]:
        """Hole and shaft as single toleranced sizes, such as ("40 H7", "40 d9")."""
        size, hole, shaft = cast(re.Match[str], _FIT.fullmatch(self.designation.strip())).groups()
        return f"{size} {hole}", f"{size} {shaft}"

    @property
    def clearance(self) -> tuple[float, float]:
        """Smallest and largest clearance on the diameter, m; negative: interference."""
        return self.hole[0] - self.shaft[1], self.hole[1] - self.shaft[0]

    @property
    def bearing_radius(self) -> tuple[float, float]:
        """Limits of R*, m: half the hole's limits of size."""
        return (self.size + self.hole[0]) / 2, (self.size + self.hole[1]) / 2

    @property
    def journal_radius(self) -> tuple[float, float]:
        """Limits of r*, m: half the shaft's limits of size."""
        return (self.size + self.shaft[0]) / 2, (self.size + self.shaft[1]) / 2


_NOMINAL = r"[⌀Øø∅]?\s*([0-9]+(?:\.[0-9]+)?)\s*(?:mm)?\s*"
_FIT = re.compile(_NOMINAL + r"([A-Z]{1,2}\d{1,2})\s*/\s*([a-z]{1,2}\d{1,2})")
_TOLERANCED_SIZE = re.compile(_NOMINAL + r"([A-Za-z]{1,2})(\d{1,2})")


def fit(designation: str) -> Fit:
    """Limits of a fit, such as ``fit("40 H7/d9")``: nominal diameter in mm, hole, shaft.

    Raises
    ------
    ValueError
        When the text is no fit, or a class is not defined at this size.
    """
    match = _FIT.fullmatch(designation.strip())
    if match is None:
        raise ValueError(
            f"ISO 286: fit {designation!r} is not understood{_meant_fit(designation)} diameter in mm, class of the "
            "hole (capital letter), '/', class of the shaft (small letter), such as '40 H7/d9'."
        )
    size = float(match[1])
    return Fit(designation, size / 1e3, limits(size, match[2]), limits(size, match[3]))


_SLIPPED_FIT = re.compile(
    r"[⌀Øø∅]?\s*([0-9]+(?:[.,][0-9]+)?)\s*(?:mm)?\s*([A-Za-z]{1,2})\s*([0-9]{1,2})\s*[-/\\,;:\s]\s*"
    r"([A-Za-z]{1,2})\s*([0-9]{1,2})"
)


def _meant_fit(designation: str) -> str:
    """``; allowed:``, before it ``did you mean '40 H7/d9'?`` where letters or the order of the classes are wrong."""
    match = _SLIPPED_FIT.fullmatch(designation.strip())
    if match is None:
        return "; allowed:"
    size, first, first_grade, second, second_grade = match.groups()
    classes = [(first, first_grade), (second, second_grade)]
    if first.islower() and second.isupper():
        classes.reverse()
    (hole, hole_grade), (shaft, shaft_grade) = classes
    return (
        f"; did you mean '{size.replace(',', '.')} {hole.upper()}{hole_grade}/{shaft.lower()}{shaft_grade}'? Allowed:"
    )


def is_hole(designation: str) -> bool:
    """Whether a single toleranced size is that of a hole (capital letter) and not of a shaft.

    Raises
    ------
    ValueError
        When the text is no toleranced size, or its letters differ in size.
    """
    letter = parts(designation)[1]
    if letter.isupper() == letter.islower():
        raise ValueError(
            f"ISO 286: {designation!r} has a capital and a small letter; allowed: {letter.upper()} for a hole, "
            f"{letter.lower()} for a shaft."
        )
    return letter.isupper()


def exchanged(designation: str) -> str:
    """The toleranced size with the class of the hole in place of the shaft's and the other way round."""
    size, letter, grade = parts(designation)
    return f"{size} {letter.swapcase()}{grade}"


def size_limits(designation: str) -> tuple[float, float, float]:
    """Nominal size and limits of size of a single toleranced size, such as ``size_limits("40 H7")``: m.

    Raises
    ------
    ValueError
        When the text is no toleranced size, or the class is not defined at this size.
    """
    text, letter, grade = parts(designation)
    size = float(text)
    lower, upper = limits(size, letter + grade)
    return size / 1e3, size / 1e3 + lower, size / 1e3 + upper


def with_grade(designation: str, grade: int | str) -> str:
    """The toleranced size with its letter in another grade: ``with_grade("40 H7", "IT9")`` is "40 H9".

    Raises
    ------
    ValueError
        When the text is no toleranced size, or the grade is unknown.
    """
    size, letter, _ = parts(designation)
    return f"{size} {letter}{_grade(grade)}"


def grade_of(designation: str) -> str:
    """The grade of a toleranced size: "7" of "40 H7".

    Raises
    ------
    ValueError
        When the text is no toleranced size.
    """
    return parts(designation)[2]


def held_limit(designation: str) -> str:
    """The limit that the fundamental deviation holds when the grade changes: "lower", "upper", or "middle" (js, JS).

    Raises
    ------
    ValueError
        When the text is no toleranced size.
    """
    letter = parts(designation)[1]
    if letter.lower() == "js":
        return "middle"
    return "lower" if letter.isupper() == (letter.lower() in _clearance.columns) else "upper"


def parts(designation: str) -> tuple[str, str, str]:
    """Size, letter and grade of a toleranced size, as written."""
    match = _TOLERANCED_SIZE.fullmatch(designation.strip())
    if match is None:
        comma = "; allowed" if "," not in designation else f"; did you mean {designation.replace(',', '.')!r}? Allowed"
        raise ValueError(
            f"ISO 286: {designation!r} is not understood{comma}: size in mm and a tolerance class, such as "
            "'40 H7' or '40 d9'."
        )
    size, letter, grade = match.groups()
    return size, letter, grade
