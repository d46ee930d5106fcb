"""Force statistics of random motions against much finer steps: the short form of studies/fuzz_forces.py."""

import sys

import pytest
from places import STUDIES

sys.path.append(str(STUDIES))

from fuzz_forces import run


@pytest.mark.slow
def test_no_good_status_stands_on_wrong_statistics():
    """At given steps to 1e-3 of the largest force, at those of the pilot to ten times the accuracy; loss times too."""
    frame = run(300, 2, "circle")
    assert not frame.missed.any(), frame[frame.missed]
    for chosen, part in frame[frame.known].groupby("chosen"):
        assert len(part) > 30, chosen
        assert part.good.mean() > 0.5, chosen
        assert part["for nothing"].mean() < 0.05, chosen
