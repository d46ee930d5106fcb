import sys
from io import StringIO

import pyarrow as pa
import pytest

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
