"""The blocks on a Dask cluster of real worker processes."""

import os
import signal
import subprocess
import sys
import threading
import time

import pandas as pd
import pytest
from calls import cannot, dies, note
from frames import assert_bitwise_equal
from small_study import GEOMETRY, write

from tolmc.errors import ClusterError
from tolmc.runs import dask
from tolmc.runs import run as monte_carlo
from tolmc.runs.crew import crew
from tolmc.runs.run import resume, run
from tolmc.study.file import load_study

distributed = pytest.importorskip("dask.distributed")

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    """For all tests, those that kill its workers the last: it begins others, which takes seconds."""
    options = {"n_workers": 2, "threads_per_worker": 1, "processes": True, "dashboard_address": ":0"}
    with distributed.LocalCluster(**options, local_directory=str(tmp_path_factory.mktemp("dask"))) as running:
        yield running
        wait_until_whole(running)


def wait_until_whole(cluster, seconds=60):
    """Wait until all workers have run for a second: a cluster that is closed while it begins one fails to close."""
    since = began = time.monotonic()
    while time.monotonic() - since < 1 and time.monotonic() - began < seconds:
        time.sleep(0.05)
        if any(nanny.process is None or nanny.process.status.name != "running" for nanny in cluster.workers.values()):
            since = time.monotonic()


def test_the_numbers_are_those_of_a_local_run(tmp_path, cluster):
    """Of motions that leave the wall, which run through the kernels of those that do not before."""
    hops = ("[monte_carlo]", '[contact]\nrestitution = 0.5\n[monte_carlo]\nstep = "2 ms"')
    study = load_study(write(tmp_path, hops, ('beta = "-50 deg"', 'beta = "40 deg"'))).replaced(samples=1500)
    result = run(study, out=tmp_path / "run", cluster=cluster.scheduler_address)
    assert (result.samples["impacts_D"] + result.samples["impacts_E"] > 0).any()
    assert_bitwise_equal(result.samples, run(study).samples)
    longer = resume(tmp_path / "run", extend=500, cluster=cluster.scheduler_address)
    assert_bitwise_equal(longer.samples, run(study.replaced(samples=2000)).samples)


def test_a_sequential_run_stops_where_the_local_one_does(tmp_path, cluster):
    until = '[monte_carlo]\nuntil = { output = "contact_force_D_max", statistic = "sd", width = 2.5e-5 }'
    study = load_study(write(tmp_path, ("[monte_carlo]", until)))
    result, local = run(study, out=tmp_path / "run", cluster=cluster.scheduler_address), run(study)
    assert result.sequential.found == local.sequential.found
    assert 1024 < result.study.samples < 3000
    assert_bitwise_equal(result.samples, local.samples)


def test_an_error_in_a_call_reaches_the_caller(cluster):
    with crew(2, cluster.scheduler_address) as workers, pytest.raises(ArithmeticError, match="three"):
        list(workers.map(cannot, ((value,) for value in range(100))))


def test_what_is_not_collected_is_not_computed(cluster, tmp_path):
    folder = tmp_path / "computed"
    folder.mkdir()
    with crew(2, cluster.scheduler_address) as workers:
        results = workers.map(note, ((folder, value) for value in range(1000)))
        assert [next(results) for _ in range(10)] == list(range(10))
        results.close()
    assert 10 <= len(list(folder.iterdir())) < 20


def test_a_cluster_that_cannot_be_used_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(dask, "_CONNECT_SECONDS", 1)
    study = load_study(write(tmp_path, *GEOMETRY))
    with pytest.raises(ClusterError, match="cannot be reached"):
        run(study, out=tmp_path / "run", cluster="tcp://127.0.0.1:1")
    assert not (tmp_path / "run").exists()
    with (
        distributed.LocalCluster(n_workers=0, dashboard_address=":0") as empty,
        pytest.raises(ClusterError, match="no workers"),
        crew(2, empty.scheduler_address),
    ):
        pass


ADDRESSES = ["foo", "foo://host:1", "tcp://host:x", "tls://127.0.0.1:5", ""]
COMMANDS = """
import sys
from tolmc.cli import main
study, out, *addresses = sys.argv[1:]
for address in addresses:
    sys.argv = ["tolmc", "run", study, "--out", out, "--cluster", address]
    try:
        main()
    except SystemExit as ended:
        print(ended.code, flush=True)
"""


def test_what_is_no_address_ends_the_command_at_once(tmp_path):
    # In a process of its own, because a client that was left open shows at the very end only.
    command = [sys.executable, "-c", COMMANDS, str(write(tmp_path, *GEOMETRY)), str(tmp_path / "run"), *ADDRESSES]
    ended = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert ended.returncode == 0 and ended.stdout.split() == ["2"] * len(ADDRESSES)
    for address, line in zip(ADDRESSES, ended.stderr.splitlines(), strict=True):
        assert line.startswith(f"Error: the Dask scheduler at {address!r} cannot be reached")


def test_a_killed_worker_loses_nothing(tmp_path, cluster, monkeypatch):
    study = load_study(write(tmp_path, ('duration = "0.1 s"', 'duration = "2 s"'))).replaced(samples=10_000)
    monkeypatch.setattr(monte_carlo, "LARGEST_BLOCK", 256)
    out, killed = tmp_path / "run", []

    def kill_one():
        while len(list(out.glob("blocks/0*.parquet"))) < 5:
            time.sleep(0.01)
        killed.append(next(iter(cluster.workers.values())).pid)
        os.kill(killed[0], signal.SIGKILL)

    assassin = threading.Thread(target=kill_one)
    assassin.start()
    result = run(study, out=out, cluster=cluster.scheduler_address)
    assassin.join()
    assert killed
    assert_bitwise_equal(pd.read_parquet(out / "samples.parquet"), run(study).samples)
    assert result.statuses["count"].sum() == 10_000


def test_a_block_that_kills_its_workers_ends_the_run(cluster):
    with crew(2, cluster.scheduler_address) as workers, pytest.raises(ClusterError, match="gave a block up"):
        list(workers.map(dies, ((value,) for value in range(6))))
