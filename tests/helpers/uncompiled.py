"""Tests without compilation, in a process of its own, as Numba asks when it is imported."""

import os
import subprocess
import sys


def run_uncompiled(*arguments: str) -> None:
    """Runs the tests that pytest's ``arguments`` choose, the nightly ones among them as well."""
    command = [sys.executable, "-m", "pytest", "-q", "-n", "0", "-x", "-m", "", *arguments]
    answer = subprocess.run(command, env={**os.environ, "NUMBA_DISABLE_JIT": "1"}, capture_output=True, text=True)
    assert answer.returncode == 0, answer.stdout[-2000:]
