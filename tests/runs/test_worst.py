"""The worst sample of a run: which it is, and its picture."""

import numpy as np
import pandas as pd
import pytest
import small_study

from tolmc.runs import directory as run_directory
from tolmc.runs import run as monte_carlo
from tolmc.runs import worst
from tolmc.runs.worst import draw_worst, worst_sample

pytestmark = pytest.mark.usefixtures("ready_pictures_throughout")

SPECIFICATION = {"tilt_angle": {"max": 1.0}, "contact_force_D_max": {"min": 2.0, "max": 8.0}}


def samples(**columns) -> pd.DataFrame:
    count = len(columns["tilt_angle"])
    return pd.DataFrame({"contact_force_D_max": [5.0] * count, "status": ["ok"] * count, **columns})


class TestWhich:
    def test_lies_furthest_out_in_standard_deviations(self):
        found = samples(tilt_angle=[0.9, 1.0001, 0.9, 0.9], contact_force_D_max=[8.2, 5.0, 5.0, 1.0])
        tilt, force = found["tilt_angle"], found["contact_force_D_max"]
        assert 0.0001 / tilt.std(ddof=0) < 0.2 / force.std(ddof=0) < 1.0 / force.std(ddof=0)
        assert worst_sample(found, SPECIFICATION) == (3, "contact_force_D_max", 1.0)

    def test_is_nearest_to_a_limit_where_none_is_out(self):
        assert worst_sample(samples(tilt_angle=[0.1, 0.5, 0.3]), SPECIFICATION) == (1, "tilt_angle", 0.5)

    @pytest.mark.parametrize("status", ["diverged", "contact lost"])
    def test_is_none_of_which_nothing_is_known(self, status):
        found = samples(tilt_angle=[0.1, 0.2, 0.3], contact_force_D_max=[5.0, 5.1, 7.9])
        found.loc[2, "status"] = status
        if status == "diverged":
            found.loc[2, ["tilt_angle", "contact_force_D_max"]] = np.nan
        assert worst_sample(found, SPECIFICATION).sample == {"diverged": 1, "contact lost": 2}[status]
        assert worst_sample(found, {"contact_force_D_max": {"max": 8.0}}).sample == 1
        assert worst_sample(found[2:].assign(status="diverged"), SPECIFICATION) is None


class TestPicture:
    def test_shows_the_motion_of_that_sample(self, tmp_path, monkeypatch):
        monte_carlo.run(small_study.write(tmp_path), samples=64, out=tmp_path / "run", workers=1)
        replayed = []
        monkeypatch.setattr(worst, "replay", lambda *given: replayed.append(given) or monte_carlo.replay(*given))
        opened = run_directory.read(tmp_path / "run")
        draw_worst(opened)
        expected = worst_sample(opened.read().to_pandas(), opened.study().specification)
        assert replayed == [(tmp_path / "run", expected.sample)]
        assert (tmp_path / "run" / "worst.png").read_bytes().startswith(b"\x89PNG")

    def test_is_absent_where_nothing_moves(self, tmp_path):
        monte_carlo.run(small_study.write(tmp_path, *small_study.GEOMETRY), samples=64, out=tmp_path / "run", workers=1)
        (tmp_path / "run" / "worst.png").touch()
        draw_worst(run_directory.read(tmp_path / "run"))
        assert not (tmp_path / "run" / "worst.png").exists()
