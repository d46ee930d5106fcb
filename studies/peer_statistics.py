"""Maxima and means of contact forces over continuous time, from canonical states on a grid of times."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numba
import numpy as np
from peer_equations import FLAGS, Coefficients, contact_forces, for_numbers_and_expressions, unpacked

PANEL_TIME = 0.2  # s; the motion's Taylor series converge over some 0.07 s, so that long panels need fewer nodes in all
NARROW = 2e-4  # panels, on each side: Newton on the central difference


class Grid(NamedTuple):
    """Gauss-Lobatto panels over [0, duration]; neighbours share their end node."""

    times: np.ndarray
    nodes: np.ndarray  # of one panel, on [-1, 1]
    weights: np.ndarray  # of one panel, for a mean over it
    barycentric: np.ndarray
    panels: int


@lru_cache
def lobatto_grid(duration: float, tolerance: float) -> Grid:
    """The sparsest grid whose interpolant follows the paper joint's contact forces to the relative tolerance."""
    panels = math.ceil(duration / PANEL_TIME)
    count = max(8, math.ceil(-math.log(tolerance) / 0.51) - 7)  # measured for peaks; means need half as many nodes
    last = np.polynomial.Legendre.basis(count - 1)
    nodes = np.concatenate([[-1.0], np.sort(last.deriv().roots().real), [1.0]])
    weights = 1 / (count * (count - 1) * last(nodes) ** 2)
    barycentric = np.sqrt(weights) * (-1.0) ** np.arange(count)
    edges = np.arange(panels)[:, None] + (nodes[:-1] + 1) / 2
    times = np.append(edges.ravel(), panels) * (duration / panels)
    return Grid(times, nodes, weights, barycentric, panels)


@numba.njit(**FLAGS)
def _forces_on_grid(x, p, force, lanes):
    # Flat views of x (times, 8, lanes), p (16, lanes), force (times, 2, lanes): indexed like this the loop is packed.
    for i in range(x.size // (8 * lanes)):
        a, b = 8 * lanes * i, 2 * lanes * i
        for j in range(lanes):
            state = (
                x[a + j], x[a + lanes + j], x[a + 2 * lanes + j], x[a + 3 * lanes + j],
                x[a + 4 * lanes + j], x[a + 5 * lanes + j], x[a + 6 * lanes + j], x[a + 7 * lanes + j],
            )  # fmt: skip
            k = Coefficients(
                p[j], p[lanes + j], p[2 * lanes + j], p[3 * lanes + j], p[4 * lanes + j], p[5 * lanes + j],
                p[6 * lanes + j], p[7 * lanes + j], p[8 * lanes + j], p[9 * lanes + j], p[10 * lanes + j],
                p[11 * lanes + j], p[12 * lanes + j], p[13 * lanes + j], p[14 * lanes + j], p[15 * lanes + j],
            )  # fmt: skip
            force[b + j], force[b + lanes + j] = contact_forces(state, k)


@for_numbers_and_expressions
def _force_at(t, end, lane, x, k, nodes, barycentric, panels, state):
    # t counts panels. The states are interpolated, not the forces: being smoother they need fewer nodes.
    panel = min(max(int(t), 0), panels - 1)
    first = panel * (len(nodes) - 1)
    position = 2.0 * (t - panel) - 1.0
    state[:] = 0.0
    total = 0.0
    for j in range(len(nodes)):
        weight = barycentric[j] / (position - nodes[j])
        total += weight
        for c in range(8):
            state[c] += weight * x[first + j, c, lane]
    for c in range(8):
        state[c] /= total
    return contact_forces(state, k)[end]


@for_numbers_and_expressions
def _vertex(t0, t1, t2, v0, v1, v2):
    # Place and height of the parabola's vertex; the middle is the highest of the three points.
    left, right = (v1 - v0) / (t1 - t0), (v2 - v1) / (t2 - t1)
    bend = (right - left) / (t2 - t0)
    if bend == 0.0:
        return t1, v1
    t = 0.5 * (t0 + t1) - 0.5 * left / bend
    return t, v1 - bend * (t - t1) ** 2


@numba.njit(**FLAGS)
def _statistics(force, x, p, times, nodes, weights, barycentric, panels, peak, mean):
    """Maxima over continuous time (nodes above their neighbours, refined by Newton) and means by quadrature."""
    width, last = len(nodes) - 1, len(times) - 1
    state = np.empty(8)
    for lane in range(force.shape[2]):
        k = unpacked(p[:, lane])
        for end in range(2):
            v = force[:, end, lane].copy()
            total = 0.0
            for panel in range(panels):
                for j in range(width + 1):
                    total += weights[j] * v[panel * width + j]
            mean[lane, end] = total / panels
            best = highest = max(v[0], v[last])
            for i in range(1, last):
                if v[i - 1] <= v[i] >= v[i + 1]:
                    t, height = _vertex(times[i - 1], times[i], times[i + 1], v[i - 1], v[i], v[i + 1])
                    highest = max(highest, height)
            for i in range(1, last):
                if not v[i - 1] <= v[i] >= v[i + 1]:
                    continue
                t, height = _vertex(times[i - 1], times[i], times[i + 1], v[i - 1], v[i], v[i + 1])
                if height < highest - 0.005 * abs(highest):
                    continue
                for _ in range(3):
                    v0 = _force_at(t - NARROW, end, lane, x, k, nodes, barycentric, panels, state)
                    v1 = _force_at(t, end, lane, x, k, nodes, barycentric, panels, state)
                    v2 = _force_at(t + NARROW, end, lane, x, k, nodes, barycentric, panels, state)
                    t, height = _vertex(t - NARROW, t, t + NARROW, v0, v1, v2)
                best = max(best, height)
            peak[lane, end] = best


def force_statistics(x: np.ndarray, p: np.ndarray, grid: Grid) -> tuple[np.ndarray, np.ndarray]:
    """Maxima and means (lanes, 2) over m r of N_D, N_E, from x (times, 8, lanes) on the grid and p (16, lanes)."""
    lanes = x.shape[2]
    force = np.empty((len(x), 2, lanes))
    _forces_on_grid(x.ravel(), p.ravel(), force.ravel(), lanes)
    peak, mean = np.empty((lanes, 2)), np.empty((lanes, 2))
    _statistics(force, x, p, grid.times * (grid.panels / grid.times[-1]), *grid[1:], peak, mean)
    return peak, mean
