"""The interval that ends sampling when it is narrow enough."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from tolmc.study.fields import Faults, place
from tolmc.study.sections import MonteCarloSection


@dataclass(frozen=True)
class Until:
    """The interval that ends sampling when it is narrow enough.

    Attributes
    ----------
    statistic : "mean", "sd", a quantile in percent such as "q99.865", or "yield"
    width : float
        Of the interval, upper less lower bound, at most; in the output's SI unit, for the yield a number.
    output : str or None
        None for the yield, the share of samples that meet every requirement.
    """

    statistic: str
    width: float
    output: str | None = None

    @property
    def level(self) -> float:
        """Share of the samples below the quantile."""
        return float(self.statistic.removeprefix("q")) / 100


def read_until(table: dict[str, Any] | None, settings: MonteCarloSection, specification: dict) -> Until | None:
    """From the table of [monte_carlo]; None where there is none."""
    if table is None:
        return None
    until, field = Until(**table), place("monte_carlo", "until")
    if settings.sampling == "latin_hypercube":
        raise Faults(
            f"{field} adds samples until an interval is narrow enough, and a Latin hypercube is made for its number of "
            'samples; use sampling = "sobol" or "random".'
        )
    if settings.samples < 2:
        raise Faults(
            f"{place('monte_carlo', 'samples')} = {settings.samples!r}: with until, the largest number; give > 1."
        )
    if until.statistic == "yield":
        if until.output is not None:
            raise Faults(f"{field}.output = {until.output!r}: the yield is that of all requirements; leave output out.")
        if not specification:
            raise Faults(f"{field}.statistic = 'yield' needs requirements; add limits under [specification].")
    elif until.output is None:
        raise Faults(f"{field}.output is missing; name the output whose {until.statistic!r} is meant.")
    elif settings.outputs is not None and until.output not in settings.outputs:
        raise Faults(f"{field}.output = {until.output!r} is not among [monte_carlo] outputs; add it there.")
    return until
