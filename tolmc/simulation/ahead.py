"""A kernel that a run needs after its first, compiled by another process meanwhile.

A kernel takes 10 s to compile, on one core: the process that needs it later waits for the other, or finds it on disk
(:mod:`tolmc.kernels.kept`).
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict

import numpy as np

from tolmc.kernels import code, names
from tolmc.kernels import parameters as P
from tolmc.simulation import one_sided
from tolmc.simulation.features import Features
from tolmc.simulation.integration import integrate
from tolmc.simulation.plan import Plan


@contextmanager
def compiled_ahead(features: Features, method: str, forces: bool) -> Iterator[None]:
    """Within the context another process compiles a kernel for scenes of these features, where it isn't on disk.

    That is the one-sided kernel where they may need one, the two-sided one elsewhere.
    """
    name = (
        names.one_sided(**one_sided.kind(features, method))
        if features.one_sided or features.alone
        else names.integrate(features.formulation, method, load=features.load, forces=forces)
    )
    # Where files have no locks for processes to wait by, the kernel would be compiled twice.
    if not sys.executable or sys.platform == "win32" or code.is_kept(name):
        yield
        return
    told = json.dumps([asdict(features), method, forces])
    # -P: the working folder of the user may hold files named as modules are.
    command, null = [sys.executable, "-P", "-m", __spec__.name, told], subprocess.DEVNULL
    with subprocess.Popen(command, stdin=null, stdout=null, stderr=null) as other:
        try:
            yield
        finally:
            other.terminate()


def _compile(features: Features, method: str, forces: bool) -> None:
    """The kernel, by integrating no motion at all."""
    plan, nothing = Plan("slope", method, 1, 1.0, features=features), np.empty((P.COUNT, 0))
    if features.one_sided or features.alone:
        one_sided.integrate(nothing, plan, 1.0)
    else:
        integrate(nothing, plan, forces, 1.0, "end", False)


if __name__ == "__main__":
    told_features, told_method, told_forces = json.loads(sys.argv[1])
    _compile(Features(**told_features), told_method, told_forces)
