"""Pictures by another process are those of this one, and whatever becomes of it costs none."""

import subprocess
import sys
from pathlib import Path

import pytest
from small_study import write

# In a process that has no Matplotlib yet, as the command's.
DRAW = """
import sys
from pathlib import Path
import numpy as np
from tolmc.pictures import painter
out, fate = Path(sys.argv[1]), sys.argv[2]
samples = {"tilt_max": np.linspace(0.1, 0.2, 1000)}
words = {"nominal": {"tilt_max": 0.15}, "specification": {}, "title": "A study"}
with painter.painter():
    other = painter._painter
    if fate == "killed":
        other.kill()
    for number in range(2):
        shown = ["tilt_max"] if fate != "refuses" or number else ["nothing"]
        try:
            painter.paint(out / f"{number}.png", "draw_distributions", samples, shown, **words)
        except KeyError as error:
            print("KeyError", error)
    print("matplotlib" in sys.modules)
print(other.poll() is not None, painter._painter is None)
"""


def drawn(folder: Path, fate: str) -> list[str]:
    call = [sys.executable, "-c", DRAW, str(folder), fate]
    return subprocess.run(call, stdout=subprocess.PIPE, text=True, check=True, timeout=60).stdout.splitlines()


@pytest.mark.slow
def test_the_other_process_draws_the_same(tmp_path, monkeypatch):
    assert drawn(tmp_path, "lives") == ["False", "True True"]
    pictures = [(tmp_path / f"{number}.png").read_bytes() for number in range(2)]
    assert pictures[0] == pictures[1]
    assert drawn(tmp_path, "killed") == ["True", "True True"]
    assert [(tmp_path / f"{number}.png").read_bytes() for number in range(2)] == pictures


@pytest.mark.slow
def test_what_it_cannot_draw_fails_here(tmp_path):
    assert drawn(tmp_path, "refuses") == ["KeyError 'nothing'", "True", "True True"]
    assert (tmp_path / "1.png").exists()


RUN = """
import sys
from tolmc.cli import main
main(["run", sys.argv[1], "--samples", "100", "--out", sys.argv[2]], standalone_mode=False)
print(sorted({"matplotlib", "scipy.stats", "scipy.optimize", "joblib", "jinja2", "pint"} & sys.modules.keys()))
"""


@pytest.mark.slow
def test_a_small_run_loads_what_it_needs_alone(tmp_path):
    study, out = write(tmp_path), tmp_path / "run"
    said = subprocess.run([sys.executable, "-c", RUN, study, out], stdout=subprocess.PIPE, text=True, check=True).stdout
    assert said.splitlines()[-1] == "[]"
    assert {"nominal.png", "drivers.png", "distributions.png"} <= {path.name for path in out.iterdir()}
