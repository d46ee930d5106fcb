"""Settings of the property tests, what the markers mean, and what tests of many folders share.

Compilation makes first examples of a property slow, and a run in CI must be repeatable.
"""

import gc
import io
import os

# Before NumPy is imported: threads of its linear algebra spin while they wait, and two processes on two cores would have
# each other wait ten times as long as the work takes.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("MKL_NUM_THREADS", "1")

import pytest
from hypothesis import settings
from PIL import Image

# Numba holds millions of objects while it compiles: looking for garbage among them as often as usual takes a fifth of it.
gc.set_threshold(100_000, 50, 50)

settings.register_profile("repeatable", deadline=None, derandomize=True)
settings.load_profile("repeatable")


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    for item in items:
        if item.get_closest_marker("nightly"):
            item.add_marker("slow")  # so that -m "not slow", which takes the place of the default, leaves it out too


@pytest.fixture
def ready_pictures(monkeypatch):
    """The pictures of a run are ready, a few pixels each: drawing them takes longer than a small run."""
    from tolmc.runs import pictures

    buffer = io.BytesIO()
    Image.new("RGB", (8, 6), "white").save(buffer, "PNG")
    for what, name in (("motion", "nominal"), ("drivers", "drivers"), ("distributions", "distributions")):
        monkeypatch.setattr(
            pictures,
            f"draw_{what}",
            lambda directory, *_, name=name: directory.write_file(
                f"{name}.png", lambda path: path.write_bytes(buffer.getvalue())
            ),
        )
