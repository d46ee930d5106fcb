"""Floating-point operations of a step of the block kernel, counted on the kernel's own source.

The device functions run as plain Python on numbers that record what is done to them; only what the results depend on
counts, as in compiled code. An addition, a multiplication, a division and a square root are one operation each, an inverse
root two, whatever it is made of.
"""

from __future__ import annotations

import numpy as np

from tolmc.kernels.formulations import slope_symmetric
from tolmc.kernels.tableaux import RK8, TABLEAUX


class Traced:
    """A number that remembers the operation and the operands it came from."""

    def __init__(self, value: float, *operands: object) -> None:
        self.value = float(value)
        self.operands = [operand for operand in operands if isinstance(operand, Traced)]
        self.counts = bool(operands)

    def _with(self, other, operation):
        if isinstance(other, (int, float, Traced)):
            plain = other.value if isinstance(other, Traced) else other
            return Traced(operation(self.value, plain), self, other)
        return NotImplemented

    def __add__(self, other):
        return self._with(other, lambda a, b: a + b)

    def __sub__(self, other):
        return self._with(other, lambda a, b: a - b)

    def __rsub__(self, other):
        return self._with(other, lambda a, b: b - a)

    def __mul__(self, other):
        return self._with(other, lambda a, b: a * b)

    def __truediv__(self, other):
        return self._with(other, lambda a, b: a / b)

    def __rtruediv__(self, other):
        return self._with(other, lambda a, b: b / a)

    def __neg__(self):
        # A sign is folded into the neighbouring operation.
        result = Traced(-self.value)
        result.operands = [self]
        return result

    __radd__, __rmul__ = __add__, __mul__


def operations(results) -> int:
    """Operations on which ``results`` depend."""
    seen, waiting, count = set(), list(results), 0
    while waiting:
        number = waiting.pop()
        if id(number) in seen:
            continue
        seen.add(id(number))
        count += number.counts
        waiting.extend(number.operands)
    return count


def step_operations(method: str) -> int:
    """Operations of one step of one motion: right-hand sides and stage sums of the symmetric slope kernel, motion only."""
    tableau, size = RK8 if method == "rk8" else TABLEAUX[method], slope_symmetric.STATE
    # In native code each term of a sum is a multiplication and an addition.
    terms = sum(map(len, tableau.rows)) + len(tableau.weights)
    return tableau.stages * _right_hand_side() + 2 * size * terms


def _right_hand_side() -> int:
    import math

    rng = np.random.default_rng(0)
    y = [Traced(v) for v in rng.uniform(0.1, 0.9, slope_symmetric.STATE)]
    coef = [Traced(v) for v in rng.uniform(0.1, 0.9, slope_symmetric.COEFFICIENTS)]
    k = [None] * slope_symmetric.STATE

    class Roots:
        @staticmethod
        def sqrt(x):
            return Traced(math.sqrt(x.value), x)

    def inverse_root(x):
        return 1.0 / Roots.sqrt(x)

    plain = {name: found.py_func for name, found in vars(slope_symmetric).items() if hasattr(found, "py_func")}
    plain["inverse_root"] = inverse_root
    originals = {name: getattr(slope_symmetric, name) for name in plain}
    try:
        slope_symmetric.math = Roots
        for name, function in plain.items():
            setattr(slope_symmetric, name, function)
        held = [*y, *[None] * slope_symmetric.HELD]
        slope_symmetric.begin(y, held, coef, 0, 1, True)
        slope_symmetric.finish(y, held, coef, Traced(0.01), k, 0, 0, 1, True)
    finally:
        slope_symmetric.math = math
        for name, function in originals.items():
            setattr(slope_symmetric, name, function)
    return operations(k)


if __name__ == "__main__":
    for method in TABLEAUX:
        print(f"{method}: {step_operations(method)} operations a step, {_right_hand_side()} of them a right-hand side")
