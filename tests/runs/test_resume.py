"""Real processes of the command, really killed at random times."""

import json
import os
import random
import resource
import signal
import subprocess
import sys
import time

import pandas as pd
import pytest
from frames import assert_bitwise_equal
from small_study import write

import tolmc

RESULTS = ("samples.parquet", "summary.csv", "requirements.csv")

# A second or two of work in many blocks, so that most kills fall into it.
SAMPLES = 20_000
MOST_KILLS = 10  # of one run
LONGER = ('duration = "0.1 s"', 'duration = "2 s"')


def start(*arguments, **options):
    command = [sys.executable, "-c", "from tolmc.cli import main; main()", "run", *map(str, arguments)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **options)


@pytest.fixture(scope="module")
def reference(tmp_path_factory):
    """The study, its run without a stop, and how long the command took for it."""
    folder = tmp_path_factory.mktemp("reference")
    study = write(folder, LONGER)
    tolmc.run(study, samples=10, out=folder / "compiled")
    began = time.monotonic()
    process = start(study, "--samples", SAMPLES, "--out", folder / "run")
    _, errors = process.communicate()
    assert process.returncode == 0, errors
    return study, folder / "run", time.monotonic() - began


def assert_equal_to(reference, out):
    for name in RESULTS:
        assert (out / name).read_bytes() == (reference / name).read_bytes(), name
    assert_bitwise_equal(pd.read_parquet(out / "samples.parquet"), pd.read_parquet(reference / "samples.parquet"))
    assert json.loads((out / "run.json").read_text())["state"] == "complete"
    assert not (out / "blocks").exists()


def run_under_kills(study, out, duration, chance, most):
    """Start, kill and go on until a process gets through: the number of kills, and how long the last one took.

    After ``most`` kills the next process is left alone, so that a machine that has become slower ends too.
    """
    kills = 0
    while True:
        begun = (out / "run.json").exists()
        process = start("--resume", out) if begun else start(study, "--samples", SAMPLES, "--out", out)
        began = time.monotonic()
        try:
            # Later starts have less to do and must be allowed to come as far as the last writes.
            patience = chance.uniform(0.3, 1.05) * duration if kills < most else None
            _, errors = process.communicate(timeout=patience)
        except subprocess.TimeoutExpired:
            process.kill()
            _, errors = process.communicate()
            if process.returncode == -signal.SIGKILL:  # otherwise it ended by itself just before
                kills += 1
                continue
        assert process.returncode == 0, errors
        return kills, time.monotonic() - began


def survive(reference, folder, wanted, seed):
    study, expected, duration = reference
    chance, kills, runs = random.Random(seed), 0, 0
    while kills < wanted:
        out = folder / f"run{runs}"
        killed, lasted = run_under_kills(study, out, duration, chance, min(wanted - kills, MOST_KILLS))
        if killed == 0:
            duration = min(duration, lasted)  # the machine is faster than when the reference ran
        kills, runs = kills + killed, runs + 1
        assert_equal_to(expected, out)
    return kills


@pytest.mark.slow
def test_a_run_survives_kills(reference, tmp_path):
    assert survive(reference, tmp_path, 3, seed=1) >= 3


@pytest.mark.nightly
def test_a_run_survives_fifty_kills(reference, tmp_path):
    assert survive(reference, tmp_path, 50, seed=2) >= 50


@pytest.mark.slow
def test_ctrl_c_keeps_what_is_finished(reference, tmp_path):
    study, expected, _ = reference
    out = tmp_path / "run"
    # Whoever runs the tests in the background has made them deaf to Ctrl-C, and their children with them.
    hearing = {"preexec_fn": lambda: signal.signal(signal.SIGINT, signal.SIG_DFL)}
    process = start(study, "--samples", SAMPLES, "--out", out, **hearing)
    while process.poll() is None and not list(out.glob("blocks/0*.parquet")):
        time.sleep(0.005)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate()
    assert process.returncode == 130
    assert "Traceback" not in errors
    assert f"tolmc run --resume {out}" in errors
    kept = list(out.glob("blocks/0*.parquet"))
    assert kept
    tolmc.resume(out)
    assert_equal_to(expected, out)


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="POSIX limits the size of files")
def test_a_full_disk_keeps_what_is_finished(reference, tmp_path):
    study, expected, _ = reference
    out = tmp_path / "run"
    # The disk takes the blocks, but not all samples in one file.
    limit = (expected / "samples.parquet").stat().st_size // 2
    process = start(
        study, "--samples", SAMPLES, "--out", out,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)),
    )  # fmt: skip
    _, errors = process.communicate()
    assert process.returncode == 1
    assert "Traceback" not in errors and "File too large" in errors
    assert f"tolmc run --resume {out}" in errors
    assert not (out / "samples.parquet").exists()
    tolmc.resume(out)
    assert_equal_to(expected, out)


@pytest.mark.slow
def test_two_processes_cannot_share_a_directory(reference, tmp_path):
    study, expected, _ = reference
    out = tmp_path / "run"
    first = start(study, "--samples", SAMPLES, "--out", out)
    while first.poll() is None and not (out / "run.json").exists():
        time.sleep(0.005)
    first.send_signal(signal.SIGSTOP)  # so that it is still there when the second comes
    second = start("--resume", out)
    _, errors = second.communicate()
    first.send_signal(signal.SIGCONT)
    assert second.returncode == 2 and "in use by another run" in errors
    assert first.communicate()[1] == "" and first.returncode == 0
    assert_equal_to(expected, out)
