"""When parts break a limit, from outputs known at a few times."""

import numpy as np
import pandas as pd

from tolmc.statistics.life import part_lives

TIMES = np.array([0.0, 10.0, 20.0, 30.0])
LIMITS = {"approximate_radius": {"max": 1.0}, "tilt_max": {"min": 0.2, "max": 5.0}}


def frames(clearance, tilt=None, statuses=None):
    """A frame a time, of the columns (times, parts)."""
    clearance = np.asarray(clearance, float).T
    tilt = np.ones_like(clearance) if tilt is None else np.asarray(tilt, float).T
    statuses = np.full(clearance.shape, "ok") if statuses is None else np.asarray(statuses).T
    return [
        pd.DataFrame({"approximate_radius": c, "tilt_max": t, "status": s})
        for c, t, s in zip(clearance, tilt, statuses, strict=True)
    ]


def test_a_life_ends_where_the_line_between_two_times_meets_the_limit():
    clearance = [[0.5, 0.8, 1.2, 1.6], [2.0, 2.1, 2.2, 2.3], [0.1, 0.2, 0.3, 0.4], [0.5, 1.5, 0.5, 0.5]]
    for found in part_lives(frames(clearance), TIMES, specification=LIMITS):
        np.testing.assert_allclose(found, [15.0, 0.0, 30.0, 5.0])


def test_the_first_limit_of_several_counts_upper_or_lower():
    clearance = np.tile([0.5, 0.8, 1.2, 1.6], (2, 1))
    tilt = [[1.0, 0.6, 0.0, 0.0], [1.0, 9.0, 1.0, 1.0]]
    for found in part_lives(frames(clearance, tilt), TIMES, specification=LIMITS):
        np.testing.assert_allclose(found, [15.0, 5.0])
    (found, _) = part_lives(frames(clearance[:1], [[1.0, 0.4, 0.1, 0.0]]), TIMES, specification=LIMITS)
    np.testing.assert_allclose(found, [15.0])


def test_a_part_without_numbers_may_have_failed_since_the_time_before_or_not_at_all():
    clearance = [[0.5, 0.8, np.nan, np.nan], [0.5, np.nan, 1.2, 1.2], [np.nan] * 4]
    statuses = [["ok", "ok", "inaccurate", "inaccurate"], ["ok", "inaccurate", "ok", "ok"], ["geometry invalid"] * 4]
    earliest, latest = part_lives(frames(clearance, statuses=statuses), TIMES, specification=LIMITS)
    np.testing.assert_allclose(earliest, [10.0, 0.0, 0.0])
    np.testing.assert_allclose(latest, [30.0, 20.0, 30.0])
