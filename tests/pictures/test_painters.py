"""Pictures by other processes are those of this one, and whatever becomes of them costs none."""

import subprocess
import sys
from pathlib import Path

import pytest
from small_study import write

# In a process that has no Matplotlib yet, as the command's.
DRAW = """
import subprocess
import sys
from pathlib import Path
import numpy as np
import psutil
from tolmc.pictures.painters import paint, painters
out, fate = Path(sys.argv[1]), sys.argv[2]
def none(*_, **__):
    raise BlockingIOError("no more processes")
if fate == "none":
    subprocess.Popen = none
samples = {"tilt_max": np.linspace(0.1, 0.2, 1000)}
words = {"nominal": {"tilt_max": 0.15}, "specification": {}, "title": "A study"}
with painters() as process:
    if fate == "killed":
        process.kill()
    for number in range(4):
        shown = ["nothing"] if fate == "refused" and number == 0 else ["tilt_max"]
        try:
            paint(out / f"{number}.png", "draw_distributions", samples, shown, **words)
        except KeyError as error:
            print("KeyError", error)
    print("drawn here" if "matplotlib" in sys.modules else "drawn there")
    others = psutil.Process().children(recursive=True)
print(len(psutil.wait_procs(others, timeout=10)[1]), "left")
"""


def drawn(folder: Path, fate: str) -> list[str]:
    call = [sys.executable, "-c", DRAW, str(folder), fate]
    return subprocess.run(call, stdout=subprocess.PIPE, text=True, check=True, timeout=60).stdout.splitlines()


@pytest.mark.slow
def test_other_processes_draw_the_same(tmp_path):
    assert drawn(tmp_path, "alive") == ["drawn there", "0 left"]
    pictures = [path.read_bytes() for path in tmp_path.iterdir()]
    for fate in ("killed", "none"):
        assert drawn(tmp_path, fate) == ["drawn here", "0 left"]
        pictures += [path.read_bytes() for path in tmp_path.iterdir()]
    assert len(pictures) == 12 and len(set(pictures)) == 1


@pytest.mark.slow
def test_what_they_cannot_draw_fails_here(tmp_path):
    assert drawn(tmp_path, "refused") == ["KeyError 'nothing'", "drawn here", "0 left"]
    assert {path.name for path in tmp_path.iterdir()} == {"1.png", "2.png", "3.png"}


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
