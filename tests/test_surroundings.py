"""What surrounds a run must not stop it: streams, encodings, filesystems, Matplotlib, places that cannot be written."""

import errno
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import matplotlib as mpl
import pandas as pd
import pytest
from click.testing import CliRunner
from places import ROOT
from small_study import GEOMETRY, write

import tolmc
from tolmc import cli
from tolmc.kernels import kept
from tolmc.pictures import plots
from tolmc.report.write import write_report
from tolmc.runs import files
from tolmc.runs.directory import NextFree
from tolmc.runs.record import RunDirectoryError
from tolmc.runs.run import run
from tolmc.terminal import failures

undrawn = pytest.mark.usefixtures("ready_pictures")


@pytest.fixture
def study(tmp_path):
    return write(tmp_path, *GEOMETRY)


def tolmc_run(study, *, shell="", **environment):
    """`python -m tolmc run` in a process of its own, with redirections of the shell."""
    command = f"{sys.executable} -m tolmc run {study.name} --samples 200 --out run {shell}"
    kept = {name: value for name, value in os.environ.items() if name not in ("MPLBACKEND", "PYTHONIOENCODING")}
    return subprocess.run(
        ["bash", "-c", command],
        cwd=study.parent,
        env={**kept, "PYTHONPATH": str(ROOT), **environment},
        capture_output=True,
    )


# Streams


@undrawn
@pytest.mark.parametrize("encoding", ["cp1252", "ascii", "latin-1", "cp437", "shift_jis", "utf-8"])
def test_any_encoding_of_the_output_will_do(study, tmp_path, encoding):
    arguments = ["run", str(study), "--samples", "200", "--out", str(tmp_path / "run")]
    result = CliRunner(charset=encoding).invoke(cli.main, arguments)
    assert (result.exit_code, result.stderr_bytes) == (0, b"")
    shown = result.stdout_bytes.decode(encoding)
    assert "Tilt angle" in shown and "?" not in shown


@pytest.mark.slow
@pytest.mark.parametrize("shell", ["2>&-", ">&-", ">&- 2>&- <&-", "2>/dev/full"])
def test_closed_streams_cost_no_run(study, shell):
    assert tolmc_run(study, shell=shell).returncode == 0
    assert len(pd.read_csv(study.parent / "run" / "summary.csv")) == 2


@pytest.mark.slow
def test_a_reader_that_ends_early_sees_no_traceback(study):
    result = tolmc_run(study, shell="| head -c 1")
    assert result.stderr == b"" and (study.parent / "run" / "summary.csv").exists()


@undrawn
@pytest.mark.parametrize("stream", ["none", "closed"])
def test_a_run_without_standard_error(study, monkeypatch, tmp_path, stream):
    closed = (tmp_path / "stderr").open("w")
    closed.close()
    monkeypatch.setattr(sys, "stderr", None if stream == "none" else closed)
    assert len(run(study, samples=100).samples) == 100


def test_signs_that_an_encoding_lacks_are_spelled():
    from tolmc.terminal import streams

    streams.prepare()
    assert "ψ ≤ 25° ± 0.1 µm − 日".encode("ascii", errors="tolmc") == b"psi <= 25deg +- 0.1 um - ?"


# Matplotlib


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    """A run with the pictures that it has where the user has set nothing."""
    folder = tmp_path_factory.mktemp("plain")
    run(write(folder, *GEOMETRY), samples=100, out=folder / "run")
    return folder / "run"


@pytest.mark.parametrize(
    "settings",
    [
        {"text.usetex": True},
        {"font.family": ["No Such Font"]},
        {"savefig.bbox": "tight", "savefig.format": "svg", "figure.dpi": 1.0},
        {"figure.constrained_layout.use": True, "axes.prop_cycle": mpl.cycler(color=["k"])},
        {"axes.formatter.use_locale": True, "axes.unicode_minus": False, "text.parse_math": False},
    ],
)
def test_pictures_are_the_same_whatever_the_user_has_set(plain, study, tmp_path, settings):
    with mpl.rc_context(settings):
        result = run(study, samples=100, out=tmp_path / "set")
    assert result.notes == ()
    for name in ("drivers.png", "distributions.png"):
        assert (tmp_path / "set" / name).read_bytes() == (plain / name).read_bytes()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("backend", "settings"),
    [
        ("module://matplotlib_inline.backend_inline", "text.usetex: True\n"),
        ("TkAgg", "axes.foo: bar\nnot a line\nfigure.dpi: abc\n"),
        ("nonsense", "font.family: Nope\n"),
    ],
)
def test_what_a_process_is_given_costs_no_run(study, backend, settings):
    """Nor is anything told of it; an encoding that lacks signs gets them spelled."""
    (study.parent / "matplotlibrc").write_text(settings)
    # A file in the place of Matplotlib's folder.
    result = tolmc_run(study, MPLBACKEND=backend, MPLCONFIGDIR=str(study), PYTHONIOENCODING="cp437")
    assert (result.returncode, result.stderr) == (0, b"")
    shown = result.stdout.decode("cp437")
    assert "Tilt angle" in shown and "?" not in shown
    assert (study.parent / "run" / "drivers.png").exists()


def test_a_picture_that_fails_costs_a_note(study, tmp_path, monkeypatch):
    def broken(*_, **__):
        raise RuntimeError("no latex\nhere")

    monkeypatch.setattr(plots, "draw_distributions", broken)
    result = CliRunner().invoke(cli.main, ["run", str(study), "--samples", "100", "--out", str(tmp_path / "run")])
    assert result.exit_code == 0
    assert "Note: distributions.png could not be drawn (RuntimeError: no latex here)" in result.stdout
    assert {"summary.csv", "drivers.png"} <= {path.name for path in (tmp_path / "run").iterdir()}
    assert write_report(tmp_path / "run").exists()


@pytest.mark.parametrize(
    "title", ["軸受のすきま", "ベアリング 轴承 베어링", "a\tb\x07", "محمل", "\U0001f6de \U00100000", "$x_{$"]
)
def test_titles_in_any_script_are_drawn_without_a_warning(title, tmp_path):
    """Warnings are errors here; what no font has becomes a square."""
    frame = pd.DataFrame({"tilt_angle": [0.1, 0.2, 0.3]})
    figure = plots.draw_distributions(frame, ["tilt_angle"], nominal={}, specification={}, title=title)
    plots.save(figure, tmp_path / "picture.png")
    assert (tmp_path / "picture.png").stat().st_size > 0


# Filesystems

UNFLUSHED = [errno.EINVAL, errno.ENOTSUP, errno.ENOSYS, errno.EBADF, errno.EPERM, errno.EACCES]


@undrawn
@pytest.mark.parametrize("number", UNFLUSHED)
def test_a_filesystem_that_cannot_flush_will_do(study, tmp_path, monkeypatch, number):
    def refuse(_):
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(os, "fsync", refuse)
    run(study, samples=100, out=tmp_path / "run")
    assert (tmp_path / "run" / "summary.csv").exists()


@undrawn
@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EIO, errno.EDQUOT])
def test_a_flush_that_fails_is_told_with_its_place(study, tmp_path, monkeypatch, number):
    def fail(_):
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(os, "fsync", fail)
    result = CliRunner().invoke(cli.main, ["run", str(study), "--samples", "100", "--out", str(tmp_path / "run")])
    assert result.exit_code == 1
    assert result.stderr.startswith(f"Error: {tmp_path / 'run' / 'study.toml'}: {os.strerror(number)}. ")


@undrawn
@pytest.mark.skipif(os.name == "nt", reason="flock")
@pytest.mark.parametrize("number", [errno.ENOLCK, errno.ENOTSUP, errno.ENOSYS, errno.EINVAL, errno.EPERM])
def test_a_filesystem_without_locks_will_do(study, tmp_path, monkeypatch, number):
    import fcntl

    def refuse(*_):
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(fcntl, "flock", refuse)
    assert len(run(study, samples=100, out=tmp_path / "run").samples) == 100


@pytest.mark.skipif(os.name == "nt", reason="flock")
@pytest.mark.parametrize("number", [errno.EAGAIN, errno.EACCES])
def test_a_lock_that_is_held_is_in_use(study, tmp_path, monkeypatch, number):
    import fcntl

    def refuse(*_):
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(fcntl, "flock", refuse)
    with pytest.raises(RunDirectoryError, match="in use by another run"):
        run(study, samples=100, out=tmp_path / "run")


def test_an_error_within_a_directory_without_locks_is_its_own(tmp_path, monkeypatch):
    def refuse(_):
        raise OSError(errno.ENOLCK, "no locks")

    monkeypatch.setattr(files, "_lock", refuse)
    with pytest.raises(KeyError, match="mine"), files.locked(tmp_path):
        raise KeyError("mine")


def test_runs_that_choose_at_once_get_directories_of_their_own(tmp_path):
    free = NextFree(tmp_path / "runs" / "shaft")
    with ThreadPoolExecutor(16) as threads:
        claimed = list(threads.map(lambda _: free.claim(), range(64)))
    names = {"shaft", *(f"shaft-{number}" for number in range(2, 65))}
    assert {path.name for path in claimed} == names == {path.name for path in (tmp_path / "runs").iterdir()}


@pytest.mark.parametrize("name", ["ENOSPC", "EACCES", "EROFS", "ENAMETOOLONG", "EMFILE", "ESTALE", "EIO"])
def test_every_refusal_has_a_place_and_a_remedy(name):
    error = OSError(getattr(errno, name), os.strerror(getattr(errno, name)), r"C:\runs\shaft")
    said, _, remedy = failures.sentence(error).partition(". ")
    assert said == rf"C:\runs\shaft: {os.strerror(error.errno)}"
    assert remedy[0].isupper() and remedy.endswith(".")


def test_an_unwritable_place_is_told_with_a_remedy(study, tmp_path):
    (tmp_path / "file").write_text("")
    result = CliRunner().invoke(cli.main, ["run", str(study), "--out", str(tmp_path / "file" / "run")])
    assert result.exit_code == 1
    assert str(tmp_path / "file") in result.stderr and "Check the path." in result.stderr


# The cache of compiled kernels


def test_places_of_the_cache_in_their_order(monkeypatch, tmp_path):
    monkeypatch.delenv("TOLMC_CACHE_DIR", raising=False)
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "numba"))
    assert kept.cache_directory().parent == tmp_path / "numba"
    monkeypatch.setenv("TOLMC_CACHE_DIR", str(tmp_path / "ours"))
    assert kept.cache_directory().parent == tmp_path / "ours"


def test_where_nothing_else_can_be_written_the_temporary_folder_is_used(monkeypatch, tmp_path):
    (tmp_path / "file").write_text("")
    for name in ("TOLMC_CACHE_DIR", "NUMBA_CACHE_DIR", "XDG_CACHE_HOME"):
        monkeypatch.setenv(name, str(tmp_path / "file" / "within"))
    monkeypatch.setattr(kept, "_INSTALLED", set(kept._HERE.parts))
    monkeypatch.setattr(kept.tempfile, "gettempdir", lambda: str(tmp_path))
    found = kept.cache_directory()
    assert found.parent.parent == tmp_path and found.parent.stat().st_mode & 0o077 == 0
    found.parent.chmod(0o777)  # anybody could put code there
    assert kept.cache_directory() is None


@pytest.mark.slow
def test_without_any_place_kernels_are_compiled_and_not_kept(study):
    script = "from tolmc.kernels import jit, kept; kept.CACHE = None; f = jit.kernel(lambda x: x + 1.0); print(f(1.0))"
    result = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, cwd=ROOT)
    assert (result.stdout, result.stderr) == ("2.0\n", "")


def test_the_module_is_the_command():
    result = subprocess.run([sys.executable, "-m", "tolmc", "--version"], capture_output=True, text=True, cwd=ROOT)
    assert result.stdout == f"tolmc, version {tolmc.__version__}\n"
