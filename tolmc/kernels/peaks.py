"""Polynomials through a step's samples: where a quantity has its largest value within the step.

The quantities are N_D, -N_D, N_E, -N_E and |w|^2, numbered in this order: of all of them maxima are sought.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np

from tolmc.kernels.jit import piece, routine
from tolmc.kernels.lanes import WIDTH
from tolmc.kernels.tableaux import Tableau

QUANTITIES = 5


@dataclass(frozen=True)
class Peaks:
    """Functions for the samples of one tableau.

    ``of_step(samples, quantity, lane)``: a lane's five samples in order; ``range_of``: the highest and the lowest of five;
    ``estimate(samples, quantity, best, position)``: of every lane; ``vertex(samples, quantity, lane, back, forth)``: of one.
    """

    of_step: Callable
    range_of: Callable
    estimate: Callable
    vertex: Callable


@cache
def peaks_of(tableau: Tableau) -> Peaks:
    """Functions for the five samples of rk8 or the three of rk4, whose others are 0."""
    sample, at = np.array(tableau.samples), np.array(tableau.positions)
    # Coefficients of the polynomial through the samples, lowest power first: fit @ samples.
    fit, five = np.linalg.inv(np.vander(at, increasing=True)), len(sample) == 5

    @piece
    def of_step(samples, quantity, lane):
        sign, variable = -1.0 if quantity % 2 == 1 else 1.0, quantity // 2
        s0 = sign * samples[(4 * sample[0] + variable) * WIDTH + lane]
        s1 = sign * samples[(4 * sample[1] + variable) * WIDTH + lane]
        s2 = sign * samples[(4 * sample[2] + variable) * WIDTH + lane]
        s3, s4 = 0.0, 0.0
        if five:
            s3 = sign * samples[(4 * sample[3] + variable) * WIDTH + lane]
            s4 = sign * samples[(4 * sample[4] + variable) * WIDTH + lane]
        return s0, s1, s2, s3, s4

    @piece
    def range_of(s0, s1, s2, s3, s4):
        top, bottom = max(max(s0, s1), s2), min(min(s0, s1), s2)
        if five:
            top, bottom = max(max(top, s3), s4), min(min(bottom, s3), s4)
        return top, bottom

    @piece
    def polynomial(s0, s1, s2, s3, s4):
        """Coefficients c1 .. c4; the constant is s0."""
        if five:
            c1 = fit[1, 0] * s0 + fit[1, 1] * s1 + fit[1, 2] * s2 + fit[1, 3] * s3 + fit[1, 4] * s4
            c2 = fit[2, 0] * s0 + fit[2, 1] * s1 + fit[2, 2] * s2 + fit[2, 3] * s3 + fit[2, 4] * s4
            c3 = fit[3, 0] * s0 + fit[3, 1] * s1 + fit[3, 2] * s2 + fit[3, 3] * s3 + fit[3, 4] * s4
            c4 = fit[4, 0] * s0 + fit[4, 1] * s1 + fit[4, 2] * s2 + fit[4, 3] * s3 + fit[4, 4] * s4
        else:
            c1 = fit[1, 0] * s0 + fit[1, 1] * s1 + fit[1, 2] * s2
            c2 = fit[2, 0] * s0 + fit[2, 1] * s1 + fit[2, 2] * s2
            c3, c4 = 0.0, 0.0
        return c1, c2, c3, c4

    @routine
    def estimate(samples, quantity, best, position):
        """Estimated maximum over a step of each lane, from the polynomial through the samples, and its position.

        Positions beyond 1 tell that the polynomial still rises at the end: its maximum belongs to the next step.
        """
        for lane in range(WIDTH):
            s0, s1, s2, s3, s4 = of_step(samples, quantity, lane)
            c1, c2, c3, c4 = polynomial(s0, s1, s2, s3, s4)
            top, place = s0, 0.0
            top, place = (s1, at[1]) if s1 > top else (top, place)
            top, place = (s2, at[2]) if s2 > top else (top, place)
            if five:
                top, place = (s3, at[3]) if s3 > top else (top, place)
                top, place = (s4, at[4]) if s4 > top else (top, place)
            x = place
            for _ in range(3):
                slope = c1 + x * (2.0 * c2 + x * (3.0 * c3 + x * 4.0 * c4))
                curvature = 2.0 * c2 + x * (6.0 * c3 + x * 12.0 * c4)
                move = -slope / curvature if curvature < 0.0 else (1.0 if slope > 0.0 else -1.0)
                x = min(max(x + min(max(move, -0.2), 0.2), 0.0), 1.5)
            inside = min(x, 1.0)
            value = s0 + inside * (c1 + inside * (c2 + inside * (c3 + inside * c4)))
            best[lane] = value if value > top else top
            position[lane] = x if value > top or x > 1.0 else place

    @piece
    def vertex(samples, quantity, lane, back, forth):
        """Maximum near 0 over [back, forth] of the polynomial through a short step's samples, and where; in lengths of it."""
        s0, s1, s2, s3, s4 = of_step(samples, quantity, lane)
        c1, c2, c3, c4 = polynomial(s0, s1, s2, s3, s4)
        x = min(0.5, forth)
        for _ in range(3):
            slope = c1 + x * (2.0 * c2 + x * (3.0 * c3 + x * 4.0 * c4))
            curvature = 2.0 * c2 + x * (6.0 * c3 + x * 12.0 * c4)
            move = -slope / curvature if curvature < 0.0 else (1.0 if slope > 0.0 else -1.0)
            x = min(max(x + min(max(move, -3.0), 3.0), back), forth)
        return s0 + x * (c1 + x * (c2 + x * (c3 + x * c4))), x

    return Peaks(of_step, range_of, estimate, vertex)
