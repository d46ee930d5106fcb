import sys
import time
from io import StringIO

import numba
import pyarrow as pa
import pytest
from numba.extending import overload

import tolmc.kernels.jit  # noqa: F401  # it passes on what Numba says
from tolmc.runs import progress


class Terminal(StringIO):
    def isatty(self):
        return True


def tables(count):
    return [pa.table({"x": list(range(10))}) for _ in range(count)]


def terminal(monkeypatch):
    # Called by the test itself: pytest puts its own stderr back after the fixtures.
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setattr(sys, "stderr", Terminal())
    return sys.stderr


def test_long_work_shows_how_far_it_is(monkeypatch):
    shown = terminal(monkeypatch)
    monkeypatch.setattr(progress, "_LONG", 0.0)
    given = tables(5)
    with progress.progress("A study", 100, done=50) as counted:
        assert list(counted(given)) == given
    assert "A study" in shown.getvalue() and "100/100" in shown.getvalue()


def test_short_work_shows_nothing(monkeypatch):
    shown = terminal(monkeypatch)
    with progress.progress("A study", 30) as counted:
        assert len(list(counted(tables(3)))) == 3
    assert "A study" not in shown.getvalue()


def test_nothing_is_shown_outside_a_terminal(monkeypatch):
    monkeypatch.setattr(progress, "_LONG", 0.0)
    monkeypatch.setattr(sys, "stderr", StringIO())
    given = tables(3)
    with progress.progress("A study", 30) as counted:
        assert list(counted(given)) == given
    assert sys.stderr.getvalue() == ""


def test_titles_may_hold_any_characters(monkeypatch):
    shown = terminal(monkeypatch)
    monkeypatch.setattr(progress, "_LONG", 0.0)
    with progress.progress("50 [bold] [/]", 30) as counted:
        list(counted(tables(3)))
    assert "50 [bold] [/]" in shown.getvalue()


def test_an_error_ends_the_bar(monkeypatch):
    terminal(monkeypatch)
    monkeypatch.setattr(progress, "_LONG", 0.0)
    with pytest.raises(ArithmeticError), progress.progress("A study", 30) as counted:
        for _ in counted(tables(3)):
            raise ArithmeticError


@pytest.mark.parametrize("on_terminal", [True, False])
def test_work_without_a_count_says_what_it_does(monkeypatch, on_terminal):
    shown = terminal(monkeypatch) if on_terminal else StringIO()
    monkeypatch.setattr(sys, "stderr", shown)
    monkeypatch.setattr(progress, "_LONG", 0.0)
    monkeypatch.setattr(progress, "_SELDOM", 0.05)
    with progress.progress("A study: choosing the step"):
        time.sleep(0.4)
    assert "A study: choosing the step" in shown.getvalue()
    if not on_terminal:  # after 0.05 s, then after 0.1 and 0.2 s more
        assert 1 <= len(shown.getvalue().splitlines()) <= 3


def test_outside_a_terminal_long_work_says_how_far_it_is(monkeypatch):
    monkeypatch.setattr(sys, "stderr", StringIO())
    monkeypatch.setattr(progress, "_SELDOM", 0.05)
    with progress.progress("A study", 30) as counted:
        for _ in counted(tables(2)):
            time.sleep(0.1)
    assert "A study, 10 of 30 samples, " in sys.stderr.getvalue()


@pytest.mark.parametrize("on_terminal", [True, False])
@pytest.mark.parametrize(("module", "said"), [("tolmc.kernels.engine", "10 s"), ("elsewhere", None),
                                              ("tolmc.kernels.one_sided.engine", "20 s")])  # fmt: skip
def test_compiling_is_said_where_the_cache_has_no_kernel(monkeypatch, on_terminal, module, said):
    shown = terminal(monkeypatch) if on_terminal else StringIO()
    monkeypatch.setattr(sys, "stderr", shown)
    monkeypatch.setattr(progress, "_LONG", 0.0)
    monkeypatch.setattr(progress, "_SELDOM", 0.01)
    function = numba.njit(takes_a_moment_to_compile())
    function.py_func.__module__ = module
    with progress.progress("A study"):
        function(1.0)
    words = f"compiling kernels, once, about {said}"
    assert (words in shown.getvalue()) if said else ("compiling" not in shown.getvalue())
    before = shown.getvalue().count("compiling")
    with progress.progress("A study"):
        function(1.0)
    assert shown.getvalue().count("compiling") == before


def takes_a_moment_to_compile():
    """A function that does so anew each time: of one that is compiled once more Numba has most."""

    def itself(x):
        raise NotImplementedError

    @overload(itself)
    def typed(x):
        time.sleep(0.3)
        return lambda x: x

    return lambda x: itself(x)


@pytest.mark.parametrize("stream", [None, "closed"])
def test_standard_error_that_is_gone_costs_nothing(monkeypatch, stream):
    gone = None if stream is None else StringIO()
    if gone is not None:
        gone.close()
    monkeypatch.setattr(sys, "stderr", gone)
    monkeypatch.setattr(progress, "_SELDOM", 0.01)
    with progress.progress("A study"):
        time.sleep(0.1)
