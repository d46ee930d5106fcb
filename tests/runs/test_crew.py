import threading
import time

import pytest

from tolmc.runs.crew import crew


def slow_square(value):
    time.sleep(0.02 * (value % 3))
    return value * value, threading.current_thread()


@pytest.mark.parametrize("workers", [1, 2, 5])
def test_results_come_in_the_order_of_the_calls(workers):
    with crew(workers) as threads:
        results = list(threads.map(slow_square, ((value,) for value in range(20))))
    assert [square for square, _ in results] == [value * value for value in range(20)]
    assert len({thread for _, thread in results}) <= workers


def test_workers_work_at_the_same_time():
    meeting = threading.Barrier(2, timeout=10)  # no call gets past it alone
    with crew(2) as threads:
        assert len(list(threads.map(lambda _: meeting.wait(), ((value,) for value in range(2))))) == 2


@pytest.mark.parametrize("workers", [1, 2])
def test_an_error_in_a_call_reaches_the_caller(workers):
    def fail(value):
        if value == 3:
            raise ArithmeticError("three")
        return value

    with crew(workers) as threads, pytest.raises(ArithmeticError, match="three"):
        list(threads.map(fail, ((value,) for value in range(100))))


@pytest.mark.parametrize("workers", [1, 2])
def test_what_is_not_collected_is_not_computed(workers):
    begun = []

    def work(value):
        begun.append(value)
        time.sleep(0.01)

    with crew(workers) as threads:
        results = threads.map(work, ((value,) for value in range(1000)))
        next(results)
        results.close()
    time.sleep(0.05)
    assert len(begun) < 100


def test_nothing_to_do():
    with crew(2) as threads:
        assert list(threads.map(slow_square, iter(()))) == []


def test_a_single_call_is_done_by_the_caller():
    with crew(2) as threads:
        assert list(threads.map(slow_square, [(3,)])) == [(9, threading.current_thread())]
