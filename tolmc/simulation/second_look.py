"""Motions at given steps whose errors may have grown: integrated once more, with an eighth more steps.

By how much a motion multiplies the error of its roughest step nothing in it tells; a pilot measures it on its motions, and at
given steps there is none. Most random motions multiply it less than ten times, one in 500,000 did so 5,000 times.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from tolmc.kernels import results as R
from tolmc.kernels.tableaux import TABLEAUX
from tolmc.simulation.judge import difference_of_statistics
from tolmc.simulation.plan import Plan

# A smoother roughest step would have to be multiplied 10,000 times to make statistics err by 1e-3 of the largest force.
_MAY_GROW = 1e-7
# With these more steps a motion errs 0.4 times as much by a formula of order 8. As many fewer would cost less, but where
# errors fall faster than the order says such motions are ten times as far off, and good ones were refused.
_MORE = 1 / 8


def look_again(
    out: np.ndarray, raw: np.ndarray, plan: Plan, duration: float, integrate: Callable[[np.ndarray, Plan], np.ndarray]
) -> None:
    """Raises step errors in ``out`` (R.RESULTS, n) to what the statistics change by with more steps, and what these leave.

    Those of the motions alone that no other sign has refused and that their roughest step leaves in doubt; where one of the
    two integrations alone loses contact, the error is infinite.

    Parameters
    ----------
    raw : the motions, a column each
    integrate : results of other columns by another plan
    """
    doubtful = (out[R.ROUGHEST] > _MAY_GROW) & (out[R.STEP_ERROR] <= plan.accuracy) & (out[R.STATUS] <= R.CONTACT_LOST)
    if not doubtful.any():
        return
    steps = plan.steps + math.ceil(_MORE * plan.steps)
    first, second = out[:, doubtful], integrate(raw[:, doubtful], replace(plan, steps=steps))
    changed = difference_of_statistics(first, second)
    later = np.abs(first[R.LOSS_TIME] - second[R.LOSS_TIME]) / duration  # NaN without a loss
    changed = np.where(np.isfinite(changed), np.fmax(changed, later), np.inf)
    changed[first[R.STATUS] != second[R.STATUS]] = np.inf
    left = (plan.steps / steps) ** TABLEAUX[plan.method].order
    out[R.STEP_ERROR, doubtful] = np.maximum(first[R.STEP_ERROR], changed / (1.0 - left))
