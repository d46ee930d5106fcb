"""What studies, results and trajectories have for a notebook.

How they look is drawn by :mod:`tolmc.notebook`, above all that has something to show; it is loaded when a notebook asks.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any


class Shown:
    """Has a page's worth of HTML, and pictures."""

    def _repr_html_(self) -> str:
        return import_module("tolmc.notebook").html(self)

    def plot(self, kind: str | None = None) -> Any:
        """A matplotlib figure; which kinds there are, an unknown one says.

        A trajectory draws the motion, a study the nominal one, a result its "distributions" (when no kind is given),
        "drivers" or the nominal "motion".
        """
        return import_module("tolmc.notebook").picture(self, kind)
