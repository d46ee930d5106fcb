"""The pictures of a run within its report, with as few bytes as they need."""

from __future__ import annotations

import io
from base64 import b64encode
from pathlib import Path

from PIL import Image

from tolmc.runs.record import RunDirectoryError

#: Captions of the pictures that have a place of their own.
PICTURES = {
    "distributions.png": "How the outputs are distributed over the samples, with the value at the nominal dimensions and the "
    "limits of the specification.",
    "drivers.png": "Which dimension drives which output: rank correlations, and outputs over the dimension that moves them "
    "most.",
    "nominal.png": "The motion at the nominal dimensions: traces of the axis points D and E on their circles, contact forces "
    "and polar angles.",
    "worst.png": "The motion of the sample that lies furthest out of its limits, or nearest to one where none is out; tolmc "
    "replay gives its dimensions.",
    "life.png": "Outputs against running time: median and the band from 5 % to 95 % of the parts, limits, and the share of the "
    "parts inside every limit. Dotted: the life.",
}  # fmt: skip

# Drawings have few colours: with so many to choose from, a third of the bytes shows the same.
_COLOURS = 256


def embedded(directory: Path) -> dict[str, tuple[str, str]]:
    """{file name: (caption, the picture as a data URI)}, those of every run first.

    Raises
    ------
    RunDirectoryError
        When a picture is damaged.
    """
    paths = [path for path in directory.glob("*.png") if not path.name.startswith(".")]
    return {
        path.name: (
            PICTURES.get(path.name, f"{path.stem.replace('_', ' ').capitalize()}."),
            f"data:image/png;base64,{b64encode(_small(path)).decode()}",
        )
        for path in sorted(paths, key=lambda path: (path.name not in PICTURES, path.name))
    }


def _small(path: Path) -> bytes:
    buffer = io.BytesIO()
    try:
        with Image.open(path) as picture:
            opaque = Image.alpha_composite(Image.new("RGBA", picture.size, "white"), picture.convert("RGBA")).convert(
                "RGB"
            )
    except (OSError, SyntaxError) as error:  # Pillow's word for a broken PNG
        raise RunDirectoryError(
            f"{path} is damaged: {error}. Delete it to leave it out of the report, or run the study into a new directory."
        ) from None
    small = opaque.quantize(_COLOURS, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
    small.save(buffer, "PNG", optimize=True)
    return buffer.getvalue()
