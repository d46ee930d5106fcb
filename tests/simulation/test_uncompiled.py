"""Kernels that the suite does not compile run without compilation, as far as their motions' first steps."""

from pathlib import Path

import pytest
from uncompiled import run_uncompiled

HERE = Path(__file__).parent


@pytest.mark.slow
def test_one_sided_kernels_of_the_nightly_run():
    """Friction, and loads and a drive that swing, on any body in the exact section; impacts by rk4."""
    files = (str(HERE / f"test_{name}.py") for name in ("friction", "swinging", "one_sided"))
    exact = "order_is_eight and (exact-general or (drive and loads and exact))"
    run_uncompiled(*files, "-k", f"({exact}) or both_methods")
