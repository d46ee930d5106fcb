"""When contact is lost: the curve and its sentence say what the samples do."""

import math

import pandas as pd

from tolmc.report.curves import HEIGHT, WIDTH
from tolmc.report.losses import losses


def samples(*times) -> pd.DataFrame:
    return pd.DataFrame(
        {"contact_loss_time": times, "status": ["ok" if math.isnan(t) else "contact lost" for t in times]}
    )


def test_curve_and_sentence():
    found = losses(samples(0.1, math.nan, 0.2, 0.4, math.nan), duration=0.5)
    assert (
        found.sentence
        == "Contact is lost in 3 of 5 samples: in the first at 0.1 s, in half of these by 0.2 s, in the last at 0.4 s."
    )
    assert (found.right, found.top) == ("0.5 s", "60 %")
    points = [tuple(map(float, point.split(","))) for point in found.points.split()]
    assert points[0] == (0.0, HEIGHT) and points[-1] == (WIDTH, 0.0)
    middle = [y for x, y in points if WIDTH * 0.21 / 0.5 < x < WIDTH * 0.39 / 0.5]
    assert set(middle) == {round(HEIGHT / 3, 1)}


def test_of_one_sample():
    assert losses(samples(math.nan, 0.25), duration=1.0).sentence == "Contact is lost in 1 of 2 samples, at 0.25 s."


def test_of_none_there_is_nothing_to_show():
    assert losses(samples(math.nan, math.nan), duration=1.0) is None
    assert losses(pd.DataFrame({"status": ["ok"]}), duration=1.0) is None
