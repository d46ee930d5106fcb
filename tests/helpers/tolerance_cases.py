"""Dimensions and tolerances of every kind, by name."""

from dataclasses import replace

import numpy as np
import pytest

from tolmc.tolerances import unit_cube as sampling
from tolmc.tolerances.dimension import Dimension, Tolerances
from tolmc.tolerances.distributions import Beta, Measured, Normal, Scipy, Triangular, Uniform

LOWER, NOMINAL, UPPER = 9.7e-3, 10e-3, 10.1e-3
WIDTH, MIDDLE = UPPER - LOWER, (LOWER + UPPER) / 2
DATA = np.random.default_rng(1).gamma(4.0, 0.05e-3, 200) + 9.9e-3

WITHIN_LIMITS = {
    "normal": Normal(),
    "capable normal": Normal(cp=1.67, cpk=1.33),
    "normal at the nominal": Normal(mean="nominal"),
    "normal near a limit": Normal(cp=0.4, mean=UPPER),
    "uniform": Uniform(),
    "triangular": Triangular(),
    "triangular at a limit": Triangular(mode=LOWER),
    "beta": Beta(2.0, 5.0),
    "truncated scipy": Scipy("gumbel_r", {"loc": 9.9e-3, "scale": 0.1e-3}, truncated=True),
}
UNBOUNDED = {
    "process": Normal(cpk=1.0, truncated=False),
    "scipy": Scipy("weibull_min", {"c": 1.8, "loc": 9.7e-3, "scale": 0.2e-3}),
    "bootstrap": Measured(DATA),
    "kernel": Measured(DATA, method="kernel"),
}
ALL = WITHIN_LIMITS | UNBOUNDED


def dimension(distribution=None, name="journal_radius", **options):
    if distribution is not None:
        options["distribution"] = distribution
    return Dimension(name, NOMINAL, LOWER, UPPER, **options)


def joint(**options):
    """Three dimensions, the second without tolerance, the others as different as possible."""
    return Tolerances(
        (
            Dimension.symmetric("bearing_radius", 20e-3, 0.05e-3),
            Dimension("half_length", 20e-3),
            Dimension.symmetric("mass", 0.5, 0.01, distribution=Uniform()),
            dimension(Scipy("lognorm", {"s": 0.3, "loc": 9.7e-3, "scale": 0.1e-3})),
        ),
        **options,
    )


CASES = {
    "independent": joint(),
    "correlated": joint(correlation={("bearing_radius", "mass"): 0.8, ("mass", "journal_radius"): -0.5}),
    "lots": Tolerances(
        [replace(d, lot_share=0.4) for d in joint().dimensions],
        {("bearing_radius", "mass"): 0.8},
        lot_size=7,
    ),
}

cases = pytest.mark.parametrize("tolerances", CASES.values(), ids=CASES)
samplings = pytest.mark.parametrize("kind", sampling.SAMPLINGS)
distributions = pytest.mark.parametrize("distribution", ALL.values(), ids=ALL)
