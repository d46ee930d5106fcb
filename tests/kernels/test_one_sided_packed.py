"""The loops over lanes of the one-sided kernels are packed, whatever happens in the lanes."""

import platform
import re
from collections import Counter

import llvmlite.binding as llvm
import numba as nb
import pytest

from tolmc.kernels import jit
from tolmc.kernels.one_sided import approach, clock, forecast, formula, jump, stepper
from tolmc.kernels.one_sided.equations import equations_of

ROW, WHOLE = nb.float64[::1], nb.int64[::1]
LIMITS = nb.types.UniTuple(nb.float64, 4)


def instructions(routine, signature):
    """How often each kind of arithmetic instruction stands in the machine code, packed and scalar."""
    compiled = nb.njit(**jit._OPTIONS)(routine.py_func)
    compiled.compile(signature)
    (code,) = compiled.inspect_asm().values()
    counts = Counter()
    for name, form, register in re.findall(r"^\s+v(fn?m\w+?|div|sqrt|mul)(pd|sd)\s.*?%([xyz]mm)", code, re.MULTILINE):
        counts["multiply-add" if name.startswith("f") else name, form == "pd" and register != "xmm"] += 1
    return counts


@pytest.mark.slow
@pytest.mark.skipif(
    bool(nb.config.DISABLE_JIT)
    or platform.machine() not in ("x86_64", "AMD64")
    or not llvm.get_host_cpu_features().get("avx2"),
    reason="counts the vector instructions of x86-64 with AVX2 or more",
)
@pytest.mark.parametrize(
    ("name", "kind"),
    [
        *(
            (name, (False, False, False, False))
            for name in (
                "evaluate",
                "formula",
                "step",
                "look",
                "screen",
                "take",
                "approach",
                "strike",
                "aim",
                "search",
                "refine",
            )
        ),
        # A symmetric body whose drive swings, and any body whose loads do, with friction.
        pytest.param("evaluate", (False, False, True, True), marks=pytest.mark.nightly),
        pytest.param("evaluate", (False, True, True, True), marks=pytest.mark.nightly),
    ],
)
def test_the_loops_over_lanes_are_packed(name, kind):
    """Packed loops keep scalar copies, for arrays that overlap."""
    equations = equations_of(*kind)
    steps = stepper.build(equations, rk4=False)
    clocks = clock.build(equations, steps, rk4=False)
    ahead = forecast.build(equations)
    routine, signature = {
        "evaluate": (formula.evaluator(equations), (nb.boolean,) + (ROW,) * 5),
        "formula": (formula.build(equations, False).step, (nb.boolean,) + (ROW,) * 8),
        "step": (steps.step, (ROW,) * 9),
        "look": (steps.look, (ROW,) * 5 + (nb.float64,)),
        "take": (clocks.take, (ROW,) * 9 + (LIMITS, WHOLE, WHOLE)),
        "screen": (clocks.screen, (ROW,) * 5 + (nb.float64, WHOLE)),
        "approach": (approach.build(equations, steps), (ROW,) * 11 + (nb.float64, WHOLE)),
        "strike": (jump.build(equations).strike, (ROW,) * 4 + (nb.float64, WHOLE, WHOLE)),
        "aim": (ahead.aim, (ROW,) * 5 + (nb.float64, nb.float64, WHOLE)),
        "search": (ahead.search, (ROW,) * 4),
        "refine": (ahead.refine, (ROW,) * 4),
    }[name]
    counts = instructions(routine, signature)
    packed = sum(count for (_, is_packed), count in counts.items() if is_packed)
    scalar = sum(count for (_, is_packed), count in counts.items() if not is_packed)
    assert packed > 0
    assert packed >= 0.5 * scalar, counts
