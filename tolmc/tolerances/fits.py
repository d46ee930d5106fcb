"""ISO 286 limits of size: ``limits(50, "H7")`` and ``fit("40 H7/d9")``.

A tolerance class such as H7 is a fundamental deviation (the letter: capital for a hole, small for a shaft)
and a standard tolerance grade (IT7, the width). The tables hold the values of ISO 286-1:2010 in micrometres,
the rest follows from the standard's rules, with a..h for clearance, k..zc for transition and interference:

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
from typing import cast

GRADES = ("01", "0", *(str(n) for n in range(1, 19)))

# Standard tolerances IT01, IT0, IT1 ... IT18, micrometres; a row holds up to and including its size in mm.
_IT = """
   3  0.3 0.5 0.8 1.2   2   3   4   6  10  14  25  40   60  100  140  250  400   600  1000  1400
   6  0.4 0.6   1 1.5 2.5   4   5   8  12  18  30  48   75  120  180  300  480   750  1200  1800
  10  0.4 0.6   1 1.5 2.5   4   6   9  15  22  36  58   90  150  220  360  580   900  1500  2200
  18  0.5 0.8 1.2   2   3   5   8  11  18  27  43  70  110  180  270  430  700  1100  1800  2700
  30  0.6   1 1.5 2.5   4   6   9  13  21  33  52  84  130  210  330  520  840  1300  2100  3300
  50  0.6   1 1.5 2.5   4   7  11  16  25  39  62 100  160  250  390  620 1000  1600  2500  3900
  80  0.8 1.2   2   3   5   8  13  19  30  46  74 120  190  300  460  740 1200  1900  3000  4600
 120    1 1.5 2.5   4   6  10  15  22  35  54  87 140  220  350  540  870 1400  2200  3500  5400
 180  1.2   2 3.5   5   8  12  18  25  40  63 100 160  250  400  630 1000 1600  2500  4000  6300
 250    2   3 4.5   7  10  14  20  29  46  72 115 185  290  460  720 1150 1850  2900  4600  7200
 315  2.5   4   6   8  12  16  23  32  52  81 130 210  320  520  810 1300 2100  3200  5200  8100
 400    3   5   7   9  13  18  25  36  57  89 140 230  360  570  890 1400 2300  3600  5700  8900
 500    4   6   8  10  15  20  27  40  63  97 155 250  400  630  970 1550 2500  4000  6300  9700
 630    -   -   9  11  16  22  32  44  70 110 175 280  440  700 1100 1750 2800  4400  7000 11000
 800    -   -  10  13  18  25  36  50  80 125 200 320  500  800 1250 2000 3200  5000  8000 12500
1000    -   -  11  15  21  28  40  56  90 140 230 360  560  900 1400 2300 3600  5600  9000 14000
1250    -   -  13  18  24  33  47  66 105 165 260 420  660 1050 1650 2600 4200  6600 10500 16500
1600    -   -  15  21  29  39  55  78 125 195 310 500  780 1250 1950 3100 5000  7800 12500 19500
2000    -   -  18  25  35  46  65  92 150 230 370 600  920 1500 2300 3700 6000  9200 15000 23000
2500    -   -  22  30  41  55  78 110 175 280 440 700 1100 1750 2800 4400 7000 11000 17500 28000
3150    -   -  26  36  50  68  96 135 210 330 540 860 1350 2100 3300 5400 8600 13500 21000 33000
"""

# -es of shafts, EI of holes.
_CLEARANCE = """
         a    b   c  cd   d   e  ef   f  fg   g  h
   3   270  140  60  34  20  14  10   6   4   2  0
   6   270  140  70  46  30  20  14  10   6   4  0
  10   280  150  80  56  40  25  18  13   8   5  0
  18   290  150  95  70  50  32  23  16  10   6  0
  30   300  160 110  85  65  40  28  20  12   7  0
  40   310  170 120 100  80  50  35  25  15   9  0
  50   320  180 130 100  80  50  35  25  15   9  0
  65   340  190 140   - 100  60   -  30   -  10  0
  80   360  200 150   - 100  60   -  30   -  10  0
 100   380  220 170   - 120  72   -  36   -  12  0
 120   410  240 180   - 120  72   -  36   -  12  0
 140   460  260 200   - 145  85   -  43   -  14  0
 160   520  280 210   - 145  85   -  43   -  14  0
 180   580  310 230   - 145  85   -  43   -  14  0
 200   660  340 240   - 170 100   -  50   -  15  0
 225   740  380 260   - 170 100   -  50   -  15  0
 250   820  420 280   - 170 100   -  50   -  15  0
 280   920  480 300   - 190 110   -  56   -  17  0
 315  1050  540 330   - 190 110   -  56   -  17  0
 355  1200  600 360   - 210 125   -  62   -  18  0
 400  1350  680 400   - 210 125   -  62   -  18  0
 450  1500  760 440   - 230 135   -  68   -  20  0
 500  1650  840 480   - 230 135   -  68   -  20  0
 630     -    -   -   - 260 145   -  76   -  22  0
 800     -    -   -   - 290 160   -  80   -  24  0
1000     -    -   -   - 320 170   -  86   -  26  0
1250     -    -   -   - 350 195   -  98   -  28  0
1600     -    -   -   - 390 220   - 110   -  30  0
2000     -    -   -   - 430 240   - 120   -  32  0
2500     -    -   -   - 480 260   - 130   -  34  0
3150     -    -   -   - 520 290   - 145   -  38  0
"""

# ei of shafts, -ES of holes before Delta. k holds for IT4 ... IT7 and is 0 in the other grades.
_INTERFERENCE = """
       k   m   n   p   r    s    t    u   v   x    y    z   za   zb   zc
   3   0   2   4   6  10   14    -   18   -  20    -   26   32   40   60
   6   1   4   8  12  15   19    -   23   -  28    -   35   42   50   80
  10   1   6  10  15  19   23    -   28   -  34    -   42   52   67   97
  14   1   7  12  18  23   28    -   33   -  40    -   50   64   90  130
  18   1   7  12  18  23   28    -   33  39  45    -   60   77  108  150
  24   2   8  15  22  28   35    -   41  47  54   63   73   98  136  188
  30   2   8  15  22  28   35   41   48  55  64   75   88  118  160  218
  40   2   9  17  26  34   43   48   60  68  80   94  112  148  200  274
  50   2   9  17  26  34   43   54   70  81  97  114  136  180  242  325
  65   2  11  20  32  41   53   66   87 102 122  144  172  226  300  405
  80   2  11  20  32  43   59   75  102 120 146  174  210  274  360  480
 100   3  13  23  37  51   71   91  124 146 178  214  258  335  445  585
 120   3  13  23  37  54   79  104  144 172 210  254  310  400  525  690
 140   3  15  27  43  63   92  122  170 202 248  300  365  470  620  800
 160   3  15  27  43  65  100  134  190 228 280  340  415  535  700  900
 180   3  15  27  43  68  108  146  210 252 310  380  465  600  780 1000
 200   4  17  31  50  77  122  166  236 284 350  425  520  670  880 1150
 225   4  17  31  50  80  130  180  258 310 385  470  575  740  960 1250
 250   4  17  31  50  84  140  196  284 340 425  520  640  820 1050 1350
 280   4  20  34  56  94  158  218  315 385 475  580  710  920 1200 1550
 315   4  20  34  56  98  170  240  350 425 525  650  790 1000 1300 1700
 355   4  21  37  62 108  190  268  390 475 590  730  900 1150 1500 1900
 400   4  21  37  62 114  208  294  435 530 660  820 1000 1300 1650 2100
 450   5  23  40  68 126  232  330  490 595 740  920 1100 1450 1850 2400
 500   5  23  40  68 132  252  360  540 660 820 1000 1250 1600 2100 2600
 560   0  26  44  78 150  280  400  600   -   -    -    -    -    -    -
 630   0  26  44  78 155  310  450  660   -   -    -    -    -    -    -
 710   0  30  50  88 175  340  500  740   -   -    -    -    -    -    -
 800   0  30  50  88 185  380  560  840   -   -    -    -    -    -    -
 900   0  34  56 100 210  430  620  940   -   -    -    -    -    -    -
1000   0  34  56 100 220  470  680 1050   -   -    -    -    -    -    -
1120   0  40  66 120 250  520  780 1150   -   -    -    -    -    -    -
1250   0  40  66 120 260  580  840 1300   -   -    -    -    -    -    -
1400   0  48  78 140 300  640  960 1450   -   -    -    -    -    -    -
1600   0  48  78 140 330  720 1050 1600   -   -    -    -    -    -    -
1800   0  58  92 170 370  820 1200 1850   -   -    -    -    -    -    -
2000   0  58  92 170 400  920 1350 2000   -   -    -    -    -    -    -
2240   0  68 110 195 440 1000 1500 2300   -   -    -    -    -    -    -
2500   0  68 110 195 460 1100 1650 2500   -   -    -    -    -    -    -
2800   0  76 135 240 550 1250 1900 2900   -   -    -    -    -    -    -
3150   0  76 135 240 580 1400 2100 3200   -   -    -    -    -    -    -
"""

# ei of shafts j, ES of holes J: neither follows from the other.
_J = """
      j5  j6  j7  j8  J6  J7  J8
   3  -2  -2  -4  -6   2   4   6
   6  -2  -2  -4   -   5   6  10
  10  -2  -2  -5   -   5   8  12
  18  -3  -3  -6   -   6  10  15
  30  -4  -4  -8   -   8  12  20
  50  -5  -5 -10   -  10  14  24
  80  -7  -7 -12   -  13  18  28
 120  -9  -9 -15   -  16  22  34
 180 -11 -11 -18   -  18  26  41
 250 -13 -13 -21   -  22  30  47
 315 -16 -16 -26   -  25  36  55
 400 -18 -18 -28   -  29  39  60
 500 -20 -20 -32   -  33  43  66
"""


class _Table:
    """A table by size (rows, mm, up to and including) and column name, micrometres; '-' is undefined."""

    def __init__(self, text: str, columns: tuple[str, ...] | None = None) -> None:
        lines = [line.split() for line in text.strip().splitlines()]
        self.columns = columns or tuple(lines.pop(0))
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


_it = _Table(_IT, tuple(f"IT{grade}" for grade in GRADES))
_clearance = _Table(_CLEARANCE)
_interference = _Table(_INTERFERENCE)
_j = _Table(_J)

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
            f"ISO 286: fit {designation!r} is not understood{_meant_fit(designation)}; allowed: diameter in mm, class of the "
            "hole (capital letter), '/', class of the shaft (small letter), such as '40 H7/d9'."
        )
    size = float(match[1])
    return Fit(designation, size / 1e3, limits(size, match[2]), limits(size, match[3]))


_SLIPPED_FIT = re.compile(
    r"[⌀Øø∅]?\s*([0-9]+(?:[.,][0-9]+)?)\s*(?:mm)?\s*([A-Za-z]{1,2})\s*([0-9]{1,2})\s*[-/\\,;:\s]\s*"
    r"([A-Za-z]{1,2})\s*([0-9]{1,2})"
)


def _meant_fit(designation: str) -> str:
    """``; did you mean '40 H7/d9'?`` where letters have the wrong size or the classes the wrong order."""
    match = _SLIPPED_FIT.fullmatch(designation.strip())
    if match is None:
        return ""
    size, first, first_grade, second, second_grade = match.groups()
    classes = [(first, first_grade), (second, second_grade)]
    if first.islower() and second.isupper():
        classes.reverse()
    (hole, hole_grade), (shaft, shaft_grade) = classes
    return f"; did you mean '{size.replace(',', '.')} {hole.upper()}{hole_grade}/{shaft.lower()}{shaft_grade}'?"


def is_hole(designation: str) -> bool:
    """Whether a single toleranced size is that of a hole (capital letter) and not of a shaft.

    Raises
    ------
    ValueError
        When the text is no toleranced size, or its letters differ in size.
    """
    letter = _parts(designation)[1]
    if letter.isupper() == letter.islower():
        raise ValueError(
            f"ISO 286: {designation!r} has a capital and a small letter; allowed: {letter.upper()} for a hole, "
            f"{letter.lower()} for a shaft."
        )
    return letter.isupper()


def exchanged(designation: str) -> str:
    """The toleranced size with the class of the hole in place of the shaft's and the other way round."""
    size, letter, grade = _parts(designation)
    return f"{size} {letter.swapcase()}{grade}"


def size_limits(designation: str) -> tuple[float, float, float]:
    """Nominal size and limits of size of a single toleranced size, such as ``size_limits("40 H7")``: m.

    Raises
    ------
    ValueError
        When the text is no toleranced size, or the class is not defined at this size.
    """
    text, letter, grade = _parts(designation)
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
    size, letter, _ = _parts(designation)
    return f"{size} {letter}{_grade(grade)}"


def held_limit(designation: str) -> str:
    """The limit that the fundamental deviation holds when the grade changes: "lower", "upper", or "middle" (js, JS).

    Raises
    ------
    ValueError
        When the text is no toleranced size.
    """
    letter = _parts(designation)[1]
    if letter.lower() == "js":
        return "middle"
    return "lower" if letter.isupper() == (letter.lower() in _clearance.columns) else "upper"


def _parts(designation: str) -> tuple[str, str, str]:
    """Size, letter and grade of a toleranced size, as written."""
    match = _TOLERANCED_SIZE.fullmatch(designation.strip())
    if match is None:
        comma = "" if "," not in designation else f"; did you mean {designation.replace(',', '.')!r}?"
        raise ValueError(
            f"ISO 286: {designation!r} is not understood{comma}; allowed: size in mm and a tolerance class, such as "
            "'40 H7' or '40 d9'."
        )
    size, letter, grade = match.groups()
    return size, letter, grade
