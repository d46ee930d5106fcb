"""Settings of the property tests, what the markers mean, and what tests of many folders share.

Compilation makes first examples of a property slow, and a run in CI must be repeatable.
"""

import gc
import os

# Before NumPy is imported: threads of its linear algebra spin while they wait, and two processes on two cores would have
# each other wait ten times as long as the work takes.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("MKL_NUM_THREADS", "1")

import pytest
from hypothesis import settings
from ready_pictures import pictures_at_hand

# Numba holds millions of objects while it compiles: looking for garbage among them as often as usual takes a fifth of it.
gc.set_threshold(100_000, 50, 50)

if os.environ.get("NUMBA_DISABLE_JIT") == "1":
    # Before kernels are made of it: without compilation every lane takes its time, and most of 32 repeat another's motion.
    from tolmc.kernels import lanes

    lanes.WIDTH = 4

settings.register_profile("repeatable", deadline=None, derandomize=True)
settings.load_profile("repeatable")


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    for item in items:
        if item.get_closest_marker("nightly"):
            item.add_marker("slow")  # so that -m "not slow", which takes the place of the default, leaves it out too


@pytest.hookimpl(optionalhook=True)  # of pytest-xdist
def pytest_xdist_make_scheduler(config, log):
    """Each worker begins with a half of its own, and takes of the other's when it is done: both end at once."""
    from xdist.scheduler import WorkStealingScheduling

    return WorkStealingScheduling(config, log) if config.getvalue("dist") == "load" else None


def pytest_collection_finish():
    gc.freeze()  # a million objects of what has been imported stay to the end: nobody need look at them for garbage


@pytest.fixture
def ready_pictures():
    """The pictures of a test's runs are ready: drawing them takes longer than a small run."""
    with pictures_at_hand():
        yield


@pytest.fixture(scope="module")
def ready_pictures_throughout():
    """The pictures of all runs of a file of tests are ready, also of those that its tests share."""
    with pictures_at_hand():
        yield
