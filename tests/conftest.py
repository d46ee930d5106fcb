"""Settings of the property tests, and what the markers mean.

Compilation makes first examples of a property slow, and a run in CI must be repeatable.
"""

import os

# Before NumPy is imported: threads of its linear algebra spin while they wait, and two processes on two cores would have
# each other wait ten times as long as the work takes.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("MKL_NUM_THREADS", "1")

import pytest
from hypothesis import settings

settings.register_profile("repeatable", deadline=None, derandomize=True)
settings.load_profile("repeatable")


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    for item in items:
        if item.get_closest_marker("nightly"):
            item.add_marker("slow")  # so that -m "not slow", which takes the place of the default, leaves it out too
