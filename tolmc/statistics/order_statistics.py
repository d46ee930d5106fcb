"""Order statistics of large samples without sorting them.

Only windows about the ranks that are asked for are sorted: a sorted part of the sample says between which values they must
lie, counting says whether they do. The few ranks that quantiles and their intervals need take a fifth of a sort's time.
"""

from __future__ import annotations

import math

import numpy as np

# Values of a part of a sample that says where to look for ranks of the whole: sorted in half a millisecond.
_PILOT = 2**14


def _holds(window: tuple[int, np.ndarray], first: int, last: int) -> bool:
    start, values = window
    return start <= first and last < start + len(values)


class OrderStatistics:
    """``[i]`` is the value of rank i, from 0, of a sample without NaN."""

    def __init__(self, values: np.ndarray) -> None:
        self._values = values
        self._windows: list[tuple[int, np.ndarray]] = []
        # An odd stride, so that every scrambling is seen.
        self._pilot = np.sort(values[:: len(values) // _PILOT | 1])
        if len(self._pilot) == len(values):
            self._windows.append((0, self._pilot))

    def __len__(self) -> int:
        return len(self._values)

    def place(self, first: int, last: int) -> tuple[int, np.ndarray]:
        """A window, its first rank and its sorted values, that holds the ranks ``first`` to ``last``."""
        for window in self._windows:
            if _holds(window, first, last):
                return window
        window = self._window(first, last)
        if not _holds(window, first, last):
            window = 0, np.sort(self._values)
        self._windows.append(window)
        return window

    def _window(self, first: int, last: int) -> tuple[int, np.ndarray]:
        low, high = self._stray(first, -1), self._stray(last, 1)
        inside = self._values >= low
        start = len(self) - np.count_nonzero(inside)
        inside &= self._values <= high
        return int(start), np.sort(self._values[inside])

    def _stray(self, rank: int, side: int) -> float:
        """A value that is almost surely on that side of the rank: five standard errors of the pilot's order statistic."""
        level, size = rank / len(self), len(self._pilot)
        place = math.floor(level * size + side * (5 * math.sqrt(size * level * (1 - level)) + 2))
        return float(self._pilot[place]) if 0 <= place < size else side * math.inf

    def __getitem__(self, rank: int) -> float:
        start, window = self.place(rank, rank)
        return float(window[rank - start])

    def at(self, rank: float) -> float:
        """Order statistic of fractional rank, 1 .. n; infinite outside."""
        if rank < 1:
            return -math.inf
        if rank > len(self):
            return math.inf
        below = min(int(rank), len(self)) - 1
        above = min(below + 1, len(self) - 1)
        return self[below] + (rank - 1 - below) * (self[above] - self[below])
