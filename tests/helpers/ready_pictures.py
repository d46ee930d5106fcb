"""Pictures of a run that need no drawing, for tests that do not look at them."""

import io
from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from PIL import Image


@contextmanager
def pictures_at_hand() -> Iterator[None]:
    """Within it every picture of a run is white and a few pixels large."""
    from tolmc.runs import pictures

    buffer = io.BytesIO()
    Image.new("RGB", (8, 6), "white").save(buffer, "PNG")
    with pytest.MonkeyPatch.context() as patch:
        for what, name in (("motion", "nominal"), ("drivers", "drivers"), ("distributions", "distributions")):
            patch.setattr(
                pictures,
                f"draw_{what}",
                lambda directory, *_, name=name: directory.write_file(
                    f"{name}.png", lambda path: path.write_bytes(buffer.getvalue())
                ),
            )
        yield
