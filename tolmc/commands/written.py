"""The last line of a command: what it wrote."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import click


def written(path: Path, files: Iterable[str] = ()) -> None:
    """Say what was written, and with which files in it."""
    inside = ", ".join(files)
    click.echo(f"Written: {path} ({inside})" if inside else f"Written: {path}")
