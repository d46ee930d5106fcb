"""Explicit Runge-Kutta formulas of fixed step, as tableaux."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class Tableau:
    """An explicit method: y1 = y0 + h sum b_i k_i, k_i = f(y0 + h sum_{j<i} a_ij k_j).

    ``samples`` are the rows at which a step is looked at for extrema, at ``positions`` in it: well apart, in order, the first
    at 0 and the last at 1. Rows up to ``stages - 1`` are the stages, whose values come for nothing; a method whose stages
    are too crude for that (an error of the size of the curvature that is sought) adds row ``stages``, the midpoint by the
    continuous extension ``midpoint``, and row ``stages + 1``, the end. A method that is looked at between its steps has none.
    """

    name: str
    order: int
    rows: tuple[dict[int, float], ...]
    weights: dict[int, float]
    samples: tuple[int, ...] = ()
    positions: tuple[float, ...] = ()
    midpoint: dict[int, float] | None = None

    @property
    def stages(self) -> int:
        return len(self.rows)

    @property
    def matrix(self) -> np.ndarray:
        """a_ij, shape (stages, stages)."""
        a = np.zeros((self.stages, self.stages))
        for i, row in enumerate(self.rows):
            for j, value in row.items():
                a[i, j] = value
        return a

    @property
    def b(self) -> np.ndarray:
        """b_i, shape (stages,)."""
        return np.array([self.weights.get(i, 0.0) for i in range(self.stages)])


CLASSICAL = Tableau(
    name="rk4",
    order=4,
    rows=({}, {0: 0.5}, {1: 0.5}, {2: 1.0}),
    weights={0: 1 / 6, 1: 1 / 3, 2: 1 / 3, 3: 1 / 6},
    samples=(0, 4, 5),
    positions=(0.0, 0.5, 1.0),
    midpoint={0: 5 / 24, 1: 1 / 6, 2: 1 / 6, 3: -1 / 24},
)

# The 12-stage formula of order 8 of Dormand and Prince's 8(5,3) pair: Hairer, Norsett & Wanner, Solving Ordinary
# Differential Equations I, 2nd ed., section II.10, coefficients of the code DOP853.
DORMAND_PRINCE = Tableau(
    name="rk8",
    order=8,
    rows=(
        {},
        {0: 0.05260015195876773},
        {0: 0.0197250569845379, 1: 0.0591751709536137},
        {0: 0.02958758547680685, 2: 0.08876275643042054},
        {0: 0.2413651341592667, 2: -0.8845494793282861, 3: 0.924834003261792},
        {0: 0.037037037037037035, 3: 0.17082860872947386, 4: 0.12546768756682242},
        {0: 0.037109375, 3: 0.17025221101954405, 4: 0.06021653898045596, 5: -0.017578125},
        {
            0: 0.03709200011850479, 3: 0.17038392571223998, 4: 0.10726203044637328, 5: -0.015319437748624402,
            6: 0.008273789163814023,
        },
        {
            0: 0.6241109587160757, 3: -3.3608926294469414, 4: -0.868219346841726, 5: 27.59209969944671,
            6: 20.154067550477894, 7: -43.48988418106996,
        },
        {
            0: 0.47766253643826434, 3: -2.4881146199716677, 4: -0.590290826836843, 5: 21.230051448181193,
            6: 15.279233632882423, 7: -33.28821096898486, 8: -0.020331201708508627,
        },
        {
            0: -0.9371424300859873, 3: 5.186372428844064, 4: 1.0914373489967295, 5: -8.149787010746927,
            6: -18.52006565999696, 7: 22.739487099350505, 8: 2.4936055526796523, 9: -3.0467644718982196,
        },
        {
            0: 2.273310147516538, 3: -10.53449546673725, 4: -2.0008720582248625, 5: -17.9589318631188,
            6: 27.94888452941996, 7: -2.8589982771350235, 8: -8.87285693353063, 9: 12.360567175794303,
            10: 0.6433927460157636,
        },
    ),
    weights={
        0: 0.054293734116568765, 5: 4.450312892752409, 6: 1.8915178993145003, 7: -5.801203960010585,
        8: 0.3111643669578199, 9: -0.1521609496625161, 10: 0.20136540080403034, 11: 0.04471061572777259,
    },
    samples=(0, 6, 9, 10, 11),
    positions=(0.0, 0.25, 0.6, 6 / 7, 1.0),
)  # fmt: skip

# The formula of order 8 for slope coordinates and the exact section: at equal error 0.76 to 0.82 of DORMAND_PRINCE's steps.
# studies/rk8_formula.py derives the coefficients from eight free numbers and measures what they gain.
RK8 = Tableau(
    name="rk8",
    order=8,
    rows=(
        {},
        {0: 0.03},
        {0: -0.08159907772130247, 1: 0.18773017953441265},
        {0: 0.039799163179916316, 2: 0.11939748953974895},
        {0: 0.36215645570057503, 2: -1.345262536256477, 3: 1.372106080555902},
        {0: 0.04878608899199532, 3: 0.23441874115261735, 4: 0.18079516985538732},
        {0: 0.06149196863157357, 3: 0.11418817498185871, 4: -0.038532402598622145, 5: 0.019604089599126923},
        {
            0: -1.386021222939274, 3: -10.243450776155766, 4: -10.38843118933145, 5: 8.295274418969479,
            6: 14.704628769457011,
        },
        {
            0: -0.42850979526375294, 3: -8.671725308666845, 4: -3.5648897438779716, 5: 3.2517230196877183,
            6: 10.248881048508409, 7: 0.0065207796124416755,
        },
        {
            0: -0.9120459845637877, 3: -14.462724081174718, 4: -7.010700623671484, 5: 5.91394355329423,
            6: 17.4239421240831, 7: 0.021989944414142308, 8: -0.08040493238148223,
        },
        {
            0: -1.3759038664801562, 3: -12.538484967457295, 4: -10.295245847406875, 5: 8.267066236465595,
            6: 16.93457419717438, 7: 0.035265045620160904, 8: 0.04786441578095319, 9: -0.10513521369676525,
        },
        {
            0: -0.4019546841389937, 3: 4.0772213212524635, 4: -3.336124474320975, 5: 2.8132096291729862,
            6: -2.408, 7: -0.5114095177745573, 8: -0.1530788080818121, 9: 0.5346626455572343,
            10: 0.3854738883336541,
        },
    ),
    weights={
        0: 0.04504997435214567, 5: 0.3455227076231393, 6: 0.24922014490524766, 7: -1.29647968697765,
        8: 0.8725605365626694, 9: -0.9819809624927769, 10: 1.6385825003100836, 11: 0.12752478571714132,
    },
)  # fmt: skip

TABLEAUX = {"rk4": CLASSICAL, "rk8": DORMAND_PRINCE}
#: Of the kernels of :mod:`tolmc.kernels.engine`.
METHODS = {"rk8": RK8, "rk4": CLASSICAL}
#: The formula that the published forms step by, in place of a method of those: for their pilot.
PUBLISHED = "published rk8"
