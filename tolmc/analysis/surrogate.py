"""A polynomial in place of the motion: the outputs over the box of the tolerances.

Tolerances are small against the dimensions, so over their box an output is nearly a polynomial of low degree. With every
varied input scaled to x in [-1, 1] over its range, the surrogate of an output is

    s(x) = sum over |a| <= p of c_a T_a1(x_1) ... T_ak(x_k)

with Chebyshev polynomials T and total degree p. The coefficients come from least squares on tens to hundreds of motions whose
points follow the arcsine density, for which the basis is orthogonal: the error is then about as small at the box's edge as
in its middle, and the edge is where the tail quantiles and the failures live. Each output takes the degree with the smallest
leave-one-out error (for least squares it needs no refit: the residual over one minus its leverage).

A surrogate says how wrong it is and never more: :mod:`tolmc.analysis.accelerated` corrects what it says by true motions.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations_with_replacement
from math import comb

import numpy as np
import pandas as pd
import scipy  # scipy.stats, half a second, is loaded when a surrogate is first trained

from tolmc.statistics.outcomes import contact_lost
from tolmc.tolerances.dimension import Tolerances

#: Inputs (a row a sample) -> outputs (a row a sample, a column an output; NaN where the motion failed).
Model = Callable[[pd.DataFrame], pd.DataFrame]


class MotionsFailed(ValueError):
    """Motions failed, which leaves the outputs unknown where they lie: few motions do not tell how far that reaches."""


class OutputsJump(ValueError):
    """A polynomial misses true motions by about as much as they differ: it does not stand for them."""


#: Held-out error over an output's spread above which a surrogate says next to nothing.
ROUGH = 0.5

MAX_DEGREE = 8
# Twice as many motions as coefficients keep least squares at arcsine points well conditioned.
MOTIONS_PER_TERM = 2
# Rows whose basis values stay in the second-level cache.
CHUNK = 2048


def multi_indices(inputs: int, degree: int) -> np.ndarray:
    """Exponents (m, inputs) of all monomials up to a total degree, lower degrees first."""
    return np.array(
        [
            np.bincount(factors, minlength=inputs) if factors else np.zeros(inputs, int)
            for total in range(degree + 1)
            for factors in combinations_with_replacement(range(inputs), total)
        ]
    )


def _recursion(exponents: np.ndarray) -> list[tuple[int, int, int]]:
    """For each term the earlier term, the input and the power whose product it is: one multiplication a term."""
    row = {tuple(a): i for i, a in enumerate(exponents.tolist())}
    steps = []
    for a in exponents[1:].tolist():
        last = max(j for j, power in enumerate(a) if power)
        steps.append((row[tuple(0 if j == last else power for j, power in enumerate(a))], last, a[last]))
    return steps


def basis(x: np.ndarray, exponents: np.ndarray, steps: Sequence[tuple[int, int, int]] | None = None) -> np.ndarray:
    """Values (m, n) of the basis at the scaled points x (k, n); ``steps`` is :func:`_recursion` of the exponents."""
    powers = np.polynomial.chebyshev.chebvander(x, int(exponents.max(initial=0)))  # (k, n, degree + 1)
    powers = np.ascontiguousarray(np.moveaxis(powers, 2, 1))
    values = np.ones((len(exponents), x.shape[1]))
    for term, (parent, j, power) in enumerate(_recursion(exponents) if steps is None else steps, start=1):
        np.multiply(values[parent], powers[j, power], out=values[term])
    return values


@dataclass(frozen=True, eq=False)
class Surrogate:
    """Polynomial outputs over a box; called like the model that it stands for.

    Attributes
    ----------
    box : mapping of input name to (low, high), SI units
        Where it was trained; equal limits mark an input that does not vary.
    outputs : tuple of str
    exponents : (m, k) int
        Of the basis in the varied inputs, lower total degrees first.
    coefficients : (m, number of outputs)
    degree : dict of output to its total degree
    held_out : dict of output to the root mean square of its leave-one-out errors, in the output's unit
    spread : dict of output to the standard deviation of its training values, in the output's unit
    motions, failed, contact_lost : int
        Motions spent on training, how many of them failed and were left out, and how many lost contact.
    """

    box: Mapping[str, tuple[float, float]]
    outputs: tuple[str, ...]
    exponents: np.ndarray
    coefficients: np.ndarray
    degree: Mapping[str, int]
    held_out: Mapping[str, float]
    spread: Mapping[str, float]
    motions: int
    failed: int
    contact_lost: int = 0

    @property
    def varied(self) -> tuple[str, ...]:
        """Names of the inputs whose range is not a point."""
        return tuple(name for name, (low, high) in self.box.items() if high > low)

    @cached_property
    def steps(self) -> list[tuple[int, int, int]]:
        """For each term after the first the earlier term, the varied input and the power whose product it is."""
        return _recursion(self.exponents)

    def __call__(self, inputs: pd.DataFrame) -> pd.DataFrame:
        """Outputs at the inputs (a row a sample); extra columns are ignored."""
        low, high = np.array([self.box[name] for name in self.varied]).T[:, :, None]
        x = np.array([inputs[name].to_numpy(float) for name in self.varied])
        x = (2.0 * x - (low + high)) / (high - low)
        values = np.empty((len(inputs), len(self.outputs)))
        for start in range(0, len(inputs), CHUNK):
            rows = slice(start, start + CHUNK)
            values[rows] = basis(x[:, rows], self.exponents, self.steps).T @ self.coefficients
        return pd.DataFrame(values, columns=list(self.outputs), index=inputs.index)

    def describe(self) -> pd.DataFrame:
        """A row an output: degree, held-out error in the output's unit and as a share of the output's spread."""
        table = pd.DataFrame({"degree": self.degree, "held_out_error": self.held_out, "spread": self.spread})
        share = table["held_out_error"] / table["spread"].where(table["spread"] > 0)
        return table.assign(held_out_share=share).rename_axis("output")


def training_box(tolerances: Tolerances) -> dict[str, tuple[float, float]]:
    """Range of every dimension, all but 2e-6 of its distribution: where a surrogate is trained."""
    ends = np.array([1e-6, 1.0 - 1e-6])
    return {
        dimension.name: tuple(dimension.ppf(ends).tolist()) if dimension.is_varied else (dimension.nominal,) * 2
        for dimension in tolerances.dimensions
    }


def training_points(box: Mapping[str, tuple[float, float]], count: int, seed: int) -> pd.DataFrame:
    """Points in the box with the arcsine density in every varied input, from a scrambled Sobol' sequence."""
    low, high = np.array(list(box.values()), float).T
    varied = high > low
    points = np.tile(0.5 * (low + high), (count, 1))
    # A power of two keeps the sequence balanced; the points that are left over are not used.
    u = scipy.stats.qmc.Sobol(int(varied.sum()), rng=np.random.default_rng([seed, 0x5A])).random_base2(
        max(count - 1, 1).bit_length()
    )
    points[:, varied] -= 0.5 * (high - low)[varied] * np.cos(np.pi * u[:count])
    return pd.DataFrame(points, columns=list(box))


def fit(
    model: Model,
    box: Mapping[str, tuple[float, float]],
    outputs: Sequence[str],
    *,
    motions: int = 256,
    max_degree: int = MAX_DEGREE,
    seed: int = 0,
) -> Surrogate:
    """Train a surrogate on motions in the box; the degree of each output by its leave-one-out error.

    Parameters
    ----------
    model : callable
        Inputs (DataFrame, the box's names as columns) to a DataFrame with at least the outputs.
    box : mapping of input name to (low, high), SI units
        Equal limits: the input does not vary.
    outputs : sequence of str
    motions : int
        How many motions to spend; at most half as many coefficients are fitted.
    max_degree : int
    seed : int
        Of the training points.

    Raises
    ------
    ValueError
        When no input varies, or (MotionsFailed) when too few motions succeed for a polynomial of degree one.
    """
    box = {name: (float(low), float(high)) for name, (low, high) in box.items()}
    k = sum(high > low for low, high in box.values())
    if k == 0:
        raise ValueError(
            "Surrogate: no input varies, so there is nothing to approximate; give a dimension a tolerance."
        )
    points = training_points(box, motions, seed)
    answers = model(points)
    values = answers[list(outputs)].to_numpy(float)
    good = np.isfinite(values).all(axis=1)
    count = int(good.sum())
    if count < MOTIONS_PER_TERM * (k + 1):
        raise MotionsFailed(
            f"Surrogate: {count} of {motions} training motions succeeded; at least {MOTIONS_PER_TERM * (k + 1)} are "
            f"needed for {k} varied inputs. Give more motions, or narrow the tolerances if the motions fail."
        )
    top = max(p for p in range(1, max_degree + 1) if p == 1 or MOTIONS_PER_TERM * comb(k + p, p) <= count)
    exponents = multi_indices(k, top)
    low, high = np.array([limits for limits in box.values() if limits[1] > limits[0]]).T
    varied = [name for name, limits in box.items() if limits[1] > limits[0]]
    x = (2.0 * points.loc[good, varied].to_numpy() - (low + high)) / (high - low)
    design = basis(x.T, exponents).T
    coefficients, degree, held_out = least_squares(design, values[good], [comb(k + p, p) for p in range(top + 1)])
    names = tuple(outputs)
    return Surrogate(
        box=box,
        outputs=names,
        exponents=exponents[: comb(k + max(degree), max(degree))],
        coefficients=coefficients[: comb(k + max(degree), max(degree))],
        degree=dict(zip(names, degree, strict=True)),
        held_out=dict(zip(names, held_out, strict=True)),
        spread=dict(zip(names, values[good].std(axis=0), strict=True)),
        motions=motions,
        failed=motions - count,
        contact_lost=int(contact_lost(answers).sum()),
    )


def refuse_rough(method: str, surrogate: Surrogate) -> None:
    """Raise OutputsJump where the held-out error of an output's surrogate is most of the output's own spread.

    So it is where impacts of both rims make outputs jump, or where the motion is chaotic.
    """
    for name, share in surrogate.describe()["held_out_share"].items():
        if share > ROUGH:
            raise OutputsJump(
                f"{method}: a polynomial misses the {name} of true motions by {100 * share:.0f} % of its spread (held-out "
                "error), as where impacts make it jump; nothing smooth stands for it. Use plain samples of true motions."
            )


def least_squares(design: np.ndarray, values: np.ndarray, sizes: Sequence[int]):
    """Coefficients, degree and leave-one-out error of each output; one factorisation serves every degree.

    ``sizes[p]`` columns of the design, which come in the order of their degree, make the basis of degree p.
    """
    q, r = np.linalg.qr(design)
    projection = q.T @ values
    leverage = np.cumsum(q * q, axis=1)
    errors = []
    for size in sizes:
        residual = values - q[:, :size] @ projection[:size]
        left_out = residual / np.maximum(1.0 - leverage[:, size - 1], np.finfo(float).eps)[:, None]
        errors.append(np.sqrt(np.mean(left_out**2, axis=0)))
    degree = np.argmin(errors, axis=0)
    coefficients = np.zeros((design.shape[1], values.shape[1]))
    for output, p in enumerate(degree):
        size = sizes[p]
        coefficients[:size, output] = scipy.linalg.solve_triangular(r[:size, :size], projection[:size, output])
    return coefficients, degree.tolist(), np.min(errors, axis=0).tolist()
