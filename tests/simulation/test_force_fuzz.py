"""Force statistics of random motions against much finer steps: the short form of studies/fuzz_forces.py."""

import json
import sys
from dataclasses import replace

import numpy as np
import pytest
from places import DATA, STUDIES

sys.path.append(str(STUDIES))

from fuzz_forces import error, run, simulated
from fuzz_scenes import SYMMETRIC

RESTING = replace(SYMMETRIC, loads=replace(SYMMETRIC.loads, gravity=(0.0, 0.0, 0.0)))
LOST = json.loads((DATA / "lost_contact.json").read_text())
HIDDEN = json.loads((DATA / "between_steps.json").read_text())


def compared_once(case):
    """A motion at its given steps and at sixteen times as many, and the error of the first."""
    scene, columns = replace(RESTING, duration=case["duration"]), {k: np.array([v]) for k, v in case["columns"].items()}
    found, true = (simulated(scene, columns, times * case["steps"]) for times in (1, 16))
    return found, true, error(found, true, scene.duration)[0]


@pytest.mark.slow
def test_no_good_status_stands_on_wrong_statistics():
    """At given steps to 1e-3 of the largest force, at those of the pilot to ten times the accuracy; loss times too."""
    frame = run(300, 2, "circle")
    assert not frame.missed.any(), frame[frame.missed]
    for chosen, part in frame[frame.known].groupby("chosen"):
        assert len(part) > 30, chosen
        assert part.good.mean() > 0.5, chosen
        assert part["for nothing"].mean() < 0.05, chosen


@pytest.mark.slow
@pytest.mark.parametrize("name", LOST)
def test_nothing_is_missed_in_the_step_in_which_contact_is_lost(name):
    """Motions of the fuzz that each had a good status and a force, or the instant, up to a third wrong."""
    found, true, missed = compared_once(LOST[name])
    assert true.status[0] == "contact lost"
    if (
        found.status[0] != "contact lost"
    ):  # of one of them a spike shifts the rms by more than a given step is trusted for
        assert found.status[0] == "inaccurate"
        assert abs(found.contact_force_D_rms[0] - true.contact_force_D_rms[0]) > 1e-4 * true.contact_force_D_max[0]
    assert missed < 1e-4


@pytest.mark.slow
@pytest.mark.parametrize("name", HIDDEN)
def test_nothing_is_missed_that_steps_hide(name):
    """Motions of the fuzz that each had a good status and wrong statistics: right now, or told to be inaccurate."""
    found, _, missed = compared_once(HIDDEN[name])
    within = HIDDEN[name]["within"]
    if within is None:
        assert found.status[0] == "inaccurate"
        assert missed > 1e-3
    else:
        assert missed < within
