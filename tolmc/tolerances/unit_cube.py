"""Points in the unit cube: random, Latin hypercube, scrambled Sobol'.

Row i depends on the seed and i alone (Latin hypercube: on the total as well), so that any division of a run
into blocks gives the same rows bit for bit; a longer random or Sobol' run begins with the shorter one's rows.
"""

from __future__ import annotations

from functools import lru_cache
from operator import index

import numpy as np
import scipy  # scipy.stats, half a second, is loaded when a Latin hypercube is first asked for

from tolmc.tolerances.scrambled_sobol import BITS, scrambled

SAMPLINGS = ("random", "latin_hypercube", "sobol")

#: Independent scramblings in a Sobol' run: row i is point i // SCRAMBLINGS of scrambling i % SCRAMBLINGS.
SCRAMBLINGS = 16

# Streams of one seed.
_RANDOM, _LATIN, _SOBOL, _LOTS = range(4)

_LARGEST = 1.0 - 2.0**-53


def _count(name: str, value) -> int:
    try:
        number = index(value)
    except TypeError:
        raise TypeError(f"sampling: {name} must be a whole number, got {value!r}.") from None
    if number < 0:
        raise ValueError(f"sampling: {name} = {number} is out of range; allowed: 0 or more.")
    return number


def _seed(seed: int, *stream: int) -> np.random.SeedSequence:
    return np.random.SeedSequence(_count("seed", seed), spawn_key=stream)


def cube_points(
    columns: int, count: int, *, sampling: str, seed: int, start: int = 0, total: int | None = None
) -> np.ndarray:
    """Rows start ... start + count - 1 of a set of points in the open unit cube.

    Parameters
    ----------
    columns : int
        Coordinates of a point.
    count, start : int
        Number of rows and index of the first.
    sampling : {"random", "latin_hypercube", "sobol"}
        Independent points; one point in each of `total` layers of every coordinate; 16 interleaved
        independent scramblings (linear matrix scramble and digital shift) of the Sobol' sequence.
    seed : int
        0 or more.
    total : int, optional
        Rows of the whole run; needed by "latin_hypercube" alone (start + count when start = 0).

    Returns
    -------
    numpy.ndarray (count, columns)
        0 < u < 1.

    Raises
    ------
    ValueError, TypeError
        For an unknown sampling, a negative number, or a Latin hypercube without its total.
    """
    if sampling not in SAMPLINGS:
        raise ValueError(f"sampling: {sampling!r} is unknown; allowed: {', '.join(SAMPLINGS)}.")
    count, start = _count("count", count), _count("start", start)
    if sampling == "latin_hypercube":
        total = _latin_total(count, start, total)
    if count == 0 or columns == 0:
        return np.empty((count, columns))
    if sampling == "random":
        return uniform_rows(columns, count, start, _seed(seed, _RANDOM))
    if sampling == "latin_hypercube":
        return _latin_points(columns, total, seed)[start : start + count]
    return _sobol_points(columns, count, start, seed)


def uniform_rows(columns: int, count: int, start: int, seed: np.random.SeedSequence) -> np.ndarray:
    """Rows start ... of independent uniform numbers: the generator is advanced, one draw a number."""
    generator = np.random.PCG64DXSM(seed)
    generator.advance(start * columns)
    u = np.random.Generator(generator).random((count, columns))
    return np.maximum(u, 2.0**-54, out=u)  # the generator can return 0, never 1


def lot_rows(columns: int, lots: np.ndarray, seed: int) -> np.ndarray:
    """A row of independent uniform numbers for each lot, (len(lots), columns); equal lots have equal rows."""
    first, last = int(lots.min()), int(lots.max())
    return uniform_rows(columns, last - first + 1, first, _seed(seed, _LOTS))[lots - first]


def lot_numbers(lot_size: int, count: int, *, sampling: str, start: int = 0) -> np.ndarray:
    """Lot of each of the rows start ... start + count - 1: consecutive rows, within a scrambling for Sobol'.

    Lots that reached across scramblings would tie these together, whose independence carries the intervals.
    """
    rows = np.arange(start, start + count)
    if sampling != "sobol":
        return rows // lot_size
    return rows // SCRAMBLINGS // lot_size * SCRAMBLINGS + rows % SCRAMBLINGS


def _latin_total(count: int, start: int, total: int | None) -> int:
    if total is None and start > 0:
        raise ValueError(
            f"sampling: latin_hypercube from row {start} needs total, the number of rows of the whole run; give it."
        )
    total = count if total is None else _count("total", total)
    if start + count > total:
        raise ValueError(
            f"sampling: rows up to {start + count} are outside a latin_hypercube of total = {total}. "
            "Its rows depend on the total: sample anew with a larger one, or use random or sobol, which "
            "extend."
        )
    return total


@lru_cache(maxsize=1)
def _latin_points(columns: int, total: int, seed: int) -> np.ndarray:
    # Kept, because every block needs the permutations of the whole run.
    engine = scipy.stats.qmc.LatinHypercube(columns, rng=np.random.default_rng(_seed(seed, _LATIN)))
    u = np.clip(engine.random(total), 2.0**-54, _LARGEST)
    u.setflags(write=False)
    return u


def _sobol_points(columns: int, count: int, start: int, seed: int) -> np.ndarray:
    """Interleaved scrambled Sobol' rows at any start, by the linearity of the sequence over bits.

    Point n is the shift XOR the direction numbers at the bits of n's Gray code. Two tables hold these sums,
    for its low and its high bits, so that a point costs two look-ups and none before it is made.
    """
    points = np.arange(start // SCRAMBLINGS, -(-(start + count) // SCRAMBLINGS))
    gray = points ^ (points >> 1)
    bits = max(int(points[-1]).bit_length(), 2)
    low, high = _sobol_tables(columns, bits, seed)
    words = low[gray % len(low)] ^ high[gray // len(low)]
    offset = start % SCRAMBLINGS
    # The middle of a cell of 2^-32 is exact and never 0 or 1.
    return (words.reshape(-1, columns)[offset : offset + count] + 0.5) * 2.0**-BITS


@lru_cache(maxsize=4)
def _sobol_tables(columns: int, bits: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Sums over the low bits (with the shift) and over the high bits, each (rows, SCRAMBLINGS, columns)."""
    rngs = (np.random.default_rng(_seed(seed, _SOBOL, k)) for k in range(SCRAMBLINGS))
    shifts, numbers = zip(*(scrambled(columns, rng) for rng in rngs), strict=True)
    shift, directions = np.array(shifts), np.stack(numbers, axis=1)[:bits]
    half = bits // 2
    return _sums(shift, directions[:half]), _sums(np.zeros_like(shift), directions[half:])


def _sums(first: np.ndarray, directions: np.ndarray) -> np.ndarray:
    table = first[None]
    for direction in directions:
        table = np.concatenate([table, table ^ direction])
    return table
