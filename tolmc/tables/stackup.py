"""Worst case, root sum square, Monte Carlo and the accelerated estimate side by side.

Everything here is from :func:`tolmc.analysis.side_by_side.side_by_side`: for a terminal every quantity of every output, for a
page the limits, with the accelerated estimates in a table of their own.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

import pandas as pd

from tolmc import quantities
from tolmc.analysis.four_answers import Answers
from tolmc.analysis.side_by_side import Linear, Worst
from tolmc.tables.requirements import yields_table
from tolmc.tables.table import Cell, Column, Estimated, Note, Number, Table, cells, plain, typeset
from tolmc.text.numbers import without_rounding_errors
from tolmc.text.phrases import STATISTICS, cut_short, unit

_KINDS = {"worst_case": "worst case", "root_sum_square": "root sum square", "monte_carlo": "Monte Carlo"}
_ESTIMATED = ("monte_carlo", "accelerated")
_LIMITS = ("lower limit", "upper limit")
_TONES = {Linear.GOOD: "good", Linear.OPEN: "open", Linear.MISLEADS: "bad"}
_UNUSABLE = (Worst.EXCEEDED, Worst.UNKNOWN)


def answers_blocks(answers: Answers) -> Iterator[Table | Note]:
    """The four answers, the yield by two of them, and what a reader of both must know."""
    yield answers_table(answers.stackup)
    if answers.yields is not None:
        yield yields_table(answers.yields)
    yield from map(Note, _grounds(answers.stackup))
    if answers.contact_lost:
        yield Note(cut_short(answers.contact_lost))
    if answers.no_yields:
        yield Note(f"No accelerated yield: {answers.no_yields}")


def answers_table(stackup: pd.DataFrame) -> Table:
    """Every quantity of every output: a row that heads the output, and below it a row a quantity."""
    shown = without_rounding_errors(stackup, _in_unit(("worst_case", "root_sum_square", *_ESTIMATED)))
    rows = []
    for output, answers in shown.groupby("output", sort=False):
        factor, of_output = quantities.shown(output)[1], answers.droplevel("output")
        heading = Cell(quantities.label(output), unit(output), tone="heading")
        rows.append(cells(heading, "", "", "", _surrogate(of_output.iloc[0]), ""))
        for quantity, row in of_output.iterrows():
            rows.append(
                cells(
                    f"  {quantity}",
                    *(Number(row[kind] * factor) for kind in ("worst_case", "root_sum_square")),
                    *(Estimated.of(row, kind, factor) for kind in _ESTIMATED),
                    Cell(", ".join(_verdict_parts(row)), tone=_tone(row)),
                )
            )
    return Table(
        "answers",
        ("Output", "worst", "RSS", "MC", "accelerated", Column("verdict", words=True)),
        tuple(rows),
        title="Worst case, root sum square (RSS), Monte Carlo (MC), accelerated; 95 % intervals (±); % of the spread",
        frame=stackup,
        is_dense=True,
    )


def _surrogate(row: pd.Series) -> Cell:
    """Degree and held-out error of the surrogate behind the accelerated estimate."""
    if math.isnan(row["accelerated_degree"]):
        return Cell()
    error = row["accelerated_held_out"]
    known = "" if math.isnan(error) else f", error {plain.number(error, 1)}"
    return Cell(detail=f"degree {row['accelerated_degree']:.0f}{known}")


def _tone(row: pd.Series) -> str:
    """How the verdict on root sum square and worst case looks: bad where either leads astray."""
    return "bad" if row["worst_case_is"] in _UNUSABLE else _TONES.get(row["root_sum_square_is"], "")


def _verdict_parts(row: pd.Series) -> Iterator[str]:
    error = "" if math.isnan(row["error_percent"]) else f" ({_percent(row['error_percent'], '+')})"
    yield f"RSS {row['root_sum_square_is']}{error}"
    match row["worst_case_is"]:
        case Worst.WIDER:
            yield f"worst {_percent(max(row['excess_percent'], 0.0))} wider"
        case Worst.EXCEEDED:
            yield f"worst exceeded by {_percent(row['beyond_percent'])}"
        case Worst.UNKNOWN:
            yield "worst not known"


def _percent(value: float, sign: str = "") -> str:
    return f"{value:{sign}.{'0f' if abs(value) > 99 else '2g'}} %"


def _grounds(stackup: pd.DataFrame) -> Iterator[str]:
    """What the columns cannot say: a worst case that is not known or exceeded, and the accelerated estimate's grounds."""
    limits = stackup.loc[stackup["worst_case_is"].isin(_UNUSABLE), "verdict"]
    sentences: dict[str, list[str]] = {}
    for (output, quantity), verdict in limits.items():
        sentence = verdict.partition("; ")[2]
        sentences.setdefault(sentence, []).append(f"{quantities.label(output)}, {quantity}")
    limits_of_all = len(_LIMITS) * stackup.index.get_level_values("output").nunique()
    for sentence, places in sentences.items():
        where = "every limit" if len(places) == limits_of_all else "; ".join(places)
        yield f"{sentence[0].upper()}{sentence[1:]} ({where})."
    missing = stackup["accelerated_missing"].iloc[0]
    if missing:
        yield f"No accelerated estimate: {missing}"
    else:
        yield (
            "Accelerated: a polynomial of the degree shown, corrected by true motions; error: its held-out error over the "
            "output's spread."
        )


def stackup_table(stackup: pd.DataFrame) -> Table:
    """Both limits of each output by each method, with how far worst case and root sum square are off."""
    stackup = stackup.drop(index=list(quantities.CHECKS), level="output", errors="ignore")
    missing = stackup["accelerated_missing"].dropna()
    kinds = dict(_KINDS)
    if stackup["accelerated"].notna().any():
        kinds["accelerated"] = "accelerated"
    limits = without_rounding_errors(stackup, _in_unit(kinds))
    limits = limits[limits.index.isin(_LIMITS, level="quantity")]
    return Table(
        "stackup",
        ("Output", Column("limit", words=True), *kinds.values(), Column("verdict", words=True)),
        tuple(_side_by_side(name, quantity, row, kinds) for (name, quantity), row in limits.iterrows()),
        title="Limits by worst case, root sum square, Monte Carlo",
        caption="The limits of each output by worst case (all parts), and by the other methods (99.73 % of the parts). Small "
        "print: 95 % intervals, and how far worst case and root sum square are from Monte Carlo, in percent of the distance of "
        "its limits. Root sum square misleads where it leaves the interval of the Monte Carlo limit by more than 2 %; the "
        "worst case, sought at the corners and inside the limits, is exceeded where samples lie beyond it, and not known where "
        "motions within the limits have no value."
        + (f" No accelerated estimate: {missing.iloc[0]}" if len(missing) else ""),
        frame=stackup,
    )


def _in_unit(kinds: Iterable[str]) -> list[str]:
    """Columns of the stack-up in the output's unit."""
    return [f"{kind}{end}" for kind in kinds for end in (("", "_low", "_high") if kind in _ESTIMATED else ("",))]


def _side_by_side(name: str, quantity: str, row: pd.Series, kinds: Iterable[str]) -> tuple[Cell, ...]:
    factor = quantities.shown(name)[1]
    decimals = _decimals(row, factor)
    details = {
        "worst_case": _percent_off(row["excess_percent"], "wider"),
        "root_sum_square": _percent_off(row["error_percent"], "off"),
        **{kind: typeset.estimate(*Estimated.of(row, kind, factor).ends)[1] for kind in _ESTIMATED},
    }
    found = (Cell(Number(row[kind] * factor, decimals=decimals), details[kind]) for kind in kinds)
    first = Cell(quantities.label(name), unit(name)) if quantity == _LIMITS[0] else ""
    return cells(first, quantity.split()[0], *found, _verdict(row))


def _decimals(row: pd.Series, factor: float) -> int:
    """Decimals that show a thousandth of what the methods differ by."""
    found = [abs(row[kind] - row["monte_carlo"]) * factor for kind in ("worst_case", "root_sum_square")]
    difference = max((x for x in found if 0 < x < math.inf), default=0.0)
    size = abs(row["monte_carlo"]) * factor
    finest = difference / 100 if difference else size * 1e-4
    return min(max(-math.floor(math.log10(finest)), 0), 9) if finest > 0 else 0


def _percent_off(percent: float, of: str) -> str:
    return "" if math.isnan(percent) else f"{typeset.number(percent, 2)} % {of}"


def _verdict(row: pd.Series) -> Cell:
    """On root sum square, and below it on the worst case where that misleads."""
    if row["root_sum_square_is"] == Linear.CONSTANT:
        return Cell(Linear.CONSTANT.value)
    worst = {
        Worst.EXCEEDED: f"samples {typeset.number(row['beyond_percent'], 2)} % beyond the worst case",
        Worst.UNKNOWN: "worst case not known",
    }.get(row["worst_case_is"], "")
    return Cell(f"root sum square {row['root_sum_square_is']}", worst, tone=_tone(row))


def accelerated_table(stackup: pd.DataFrame) -> Table:
    """The accelerated estimate of every output, and the surrogate behind it."""
    stackup = stackup.drop(index=list(quantities.CHECKS), level="output", errors="ignore").dropna(subset="accelerated")
    shown = without_rounding_errors(stackup, _in_unit(("accelerated",)))
    rows = []
    for name, answers in shown.groupby("output", sort=False):
        surrogate = answers.iloc[0]
        rows.append(
            cells(
                Cell(quantities.label(name), unit(name)),
                *(Estimated.of(row, "accelerated", quantities.shown(name)[1]) for _, row in answers.iterrows()),
                Number(surrogate["accelerated_degree"], 2),
                Number(surrogate["accelerated_held_out"], 2),
            )
        )
    estimates = (STATISTICS[key] for key in ("mean", "sd", "q0.135", "q99.865"))
    return Table(
        "accelerated",
        ("Output", *estimates, "degree", "held-out error"),
        tuple(rows),
        title="Accelerated estimates with 95 % intervals",
        caption="The accelerated estimate with 95 % intervals: a polynomial in place of the motion, corrected by true motions, "
        "so that a poor polynomial widens the interval and nothing else. Degree: that of the polynomial. Held-out error: its "
        "error at motions that it was not fitted to, over the output's spread.",
        frame=stackup[[*_in_unit(("accelerated",)), "accelerated_degree", "accelerated_held_out"]],
    )
