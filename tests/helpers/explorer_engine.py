"""The explorer's scripts without a page, in an embedded JavaScript engine."""

import json
import re
from importlib import resources
from pathlib import Path

import numpy as np
import pytest

py_mini_racer = pytest.importorskip("py_mini_racer", reason="the JavaScript engine mini-racer is not installed")


def data_of(directory: Path) -> dict:
    """What the explorer of a report reads."""
    page = (directory / "report.html").read_text(encoding="utf-8")
    return json.loads(
        re.search('<script type="application/json" id="explorer-data">(.*?)</script>', page, re.DOTALL)[1]
    )


class Engine:
    """The arithmetic and the study text, with the data of a report."""

    def __init__(self, data: dict | None = None) -> None:
        self._engine = py_mini_racer.MiniRacer()
        for name in ("arithmetic.js", "study_text.js"):
            self._engine.eval((resources.files("tolmc.report.explorer") / name).read_text(encoding="utf-8"))
        if data is not None:
            self._engine.eval(f"var data = {json.dumps(data)}; var kept = arithmetic.prepared(data);")
            self.data = data
            self.names = [output["name"] for output in data["outputs"]]

    def __call__(self, expression: str):
        """The value of an expression, typed arrays as lists."""
        plain = "(key, value) => (ArrayBuffer.isView(value) ? Array.from(value) : value)"
        return json.loads(self._engine.eval(f"JSON.stringify({expression}, {plain})"))

    def sets(self, **changes) -> dict:
        """The study's own nominal values and widths, with those of ``changes``: name=(nominal, width) or a class's size."""
        found = {}
        for d in self.data["dimensions"]:
            found[d["name"]] = {"nominal": d["nominal"], "width": d["upper"] - d["lower"], "size": d["size"]}
            change = changes.get(d["name"])
            if isinstance(change, str):
                known = next(c for c in d["classes"] if c["size"] == change)
                found[d["name"]] = {key: known[key] for key in ("nominal", "width", "size")}
            elif change is not None:
                found[d["name"]] = {"nominal": change[0], "width": change[1], "size": None}
        return found

    def predicted(self, sets: dict) -> tuple[dict[str, np.ndarray], dict[str, float]]:
        """Outputs of all parts, and the yield with its bounds."""
        found = self(f"arithmetic.predicted(kept, {json.dumps(sets)})")
        return dict(zip(self.names, map(np.array, found["outputs"]), strict=True)), found["found"]

    def study(self, sets: dict, asked: dict | None = None) -> str:
        """The study file of what is set; asked: the ``target`` and the ``ends`` {min, max} of every output."""
        by_name = json.dumps({d["name"]: d for d in self.data["dimensions"]})
        return self(f"studyText.study(data, {by_name}, {json.dumps(sets)}, {json.dumps(asked)})")
