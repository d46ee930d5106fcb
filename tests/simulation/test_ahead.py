"""A kernel compiled by another process while a run does other things."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from dataclasses import asdict, replace

import pytest

from tolmc.kernels import code, engine, names
from tolmc.kernels.one_sided import engine as one_sided_engine
from tolmc.simulation import ahead
from tolmc.simulation.features import Features

FEATURES = Features(load=True, momentum=False)
TOLD = json.dumps([asdict(FEATURES), "rk8", True])


@pytest.fixture
def missing(monkeypatch):
    monkeypatch.setattr(code, "is_kept", lambda name: False)


def test_no_process_is_begun_for_a_kernel_that_is_there(monkeypatch):
    asked = []
    monkeypatch.setattr(code, "is_kept", lambda name: asked.append(name) or True)
    monkeypatch.setattr(subprocess, "Popen", None)
    with ahead.compiled_ahead(FEATURES, "rk8", True):
        pass
    assert asked == [engine.build("slope_symmetric", "rk8", load=True, forces=True).__name__]


def test_of_a_wall_that_only_pushes_it_is_the_one_sided_kernel(monkeypatch):
    asked = []
    monkeypatch.setattr(code, "is_kept", lambda name: asked.append(name) or True)
    with ahead.compiled_ahead(replace(FEATURES, one_sided=True), "rk8", True):
        pass
    kinds = dict.fromkeys(("exact", "general", "rubs", "swings", "rk4"), False)
    assert asked == [one_sided_engine.build(**kinds).__name__]


def test_the_process_is_told_what_to_compile_and_ends_with_the_context(monkeypatch, missing):
    begun, begin = [], subprocess.Popen

    def begin_another(command, **silent):
        begun.append((command, begin([sys.executable, "-c", "import time; time.sleep(60)"], **silent)))
        return begun[0][1]

    monkeypatch.setattr(subprocess, "Popen", begin_another)
    before = time.monotonic()
    with pytest.raises(KeyboardInterrupt), ahead.compiled_ahead(FEATURES, "rk8", True):
        raise KeyboardInterrupt
    assert begun[0][1].returncode not in (None, 0)
    assert time.monotonic() - before < 30
    assert begun[0][0] == [sys.executable, "-P", "-m", "tolmc.simulation.ahead", TOLD]


def test_the_process_compiles_the_kernel(tmp_path):
    """Which is done at once for one that the tests have compiled."""
    subprocess.run([sys.executable, "-m", "tolmc.simulation.ahead", TOLD], check=True, cwd=tmp_path, timeout=300)
    assert code.is_kept(names.integrate("slope_symmetric", "rk8", load=True, forces=True))


@pytest.mark.slow
def test_of_a_kernel_that_is_none_the_process_fails(tmp_path):
    wrong = TOLD.replace("rk8", "euler")
    done = subprocess.run(
        [sys.executable, "-m", "tolmc.simulation.ahead", wrong], cwd=tmp_path, capture_output=True, timeout=300
    )
    assert b"KeyError: 'euler'" in done.stderr
