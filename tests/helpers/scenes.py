"""Scenes for tests: the reference motions, a shaft that every load acts on, and random ensembles of plausible samples."""

import json
from dataclasses import dataclass, replace

import numpy as np
from places import DATA
from scipy.spatial.transform import Rotation

from tolmc import Body, Joint, Loads, Motion, Scene

_CASES = json.loads((DATA / "trajectories.json").read_text())

DIMENSIONS = ("bearing_radius", "journal_radius", "half_length")
FORCES = tuple(f"contact_force_{side}_{kind}" for side in "DE" for kind in ("max", "min", "mean", "rms"))


@dataclass(frozen=True)
class Reference:
    """A motion with numbers from an independent integration."""

    scene: Scene
    expected: dict

    @classmethod
    def of(cls, case: dict) -> "Reference":
        scene = Scene(
            Joint(*(case[name] for name in DIMENSIONS)),
            Body(case["mass"], case["center_of_mass"], case["inertia"]),
            Loads(case["gravity"], case["force"], case["force_point"], case["torque"]),
            Motion(**case["motion"]),
            case["duration"],
        )
        return cls(scene, case["expected"])


REFERENCES = {name: Reference.of(case) for name, case in _CASES.items()}

PAPER_JOINT = Joint(0.02, 0.01, 0.02)
CYLINDER = Body(0.5, (0, 0, 0.004), (4.08e-4, 4.08e-4, 1.2e-4))
UNBALANCED = Body(
    0.5, (0.001, -0.0007, 0.004), [[4.1e-4, 2e-5, -1.2e-5], [2e-5, 3.3e-4, 3.1e-5], [-1.2e-5, 3.1e-5, 1.3e-4]]
)
START = Motion(alpha=-1.92, beta=-0.87, alpha_rate=2.0, beta_rate=-3.0, spin=0.7, spin_rate=40.0)

SYMMETRIC = Scene(PAPER_JOINT, CYLINDER, Loads((0, -9.81, 0)), START, 0.1)
#: Every scalar of this scene has a part in the motion.
LOADED = Scene(
    PAPER_JOINT, UNBALANCED, Loads((1.0, -9.81, -2.0), (0.4, 0.3, -0.5), (0.01, -0.02, 0.03), (2e-3, -1e-3, 3e-3)), START, 0.1
)  # fmt: skip


#: Too little to change a digit, by the equations that motions under load are compiled with.
NEXT_TO_NO_LOAD = Loads((1e-300, 0, 0))


def dimensions(scene: Scene) -> dict[str, float]:
    """The three dimensions of a scene, as ``simulate_many`` takes them."""
    return {name: scene.scalars[name] for name in DIMENSIONS}


def nearly_symmetric(scene: Scene) -> Scene:
    """The same motion with a body that counts as unsymmetric, so that the equations of the general body are used."""
    _, _, z = scene.body.center_of_mass
    return replace(scene, body=replace(scene.body, center_of_mass=(1e-300, 0.0, z)))


def cylinders(count: int, seed: int) -> dict[str, np.ndarray]:
    """Random samples whose body is ``CYLINDER`` moved along the axis, resting near the bottom of joints of all shapes."""
    rng = np.random.default_rng(seed)
    journal = 0.01 * rng.uniform(0.5, 2, count)
    gravity = rng.normal(0, 5, (3, count))
    down = np.arctan2(gravity[1], gravity[0])
    return {
        "bearing_radius": journal * (1 + 10 ** rng.uniform(-1.5, 0.2, count)),
        "journal_radius": journal,
        "half_length": journal * 10 ** rng.uniform(-0.2, 0.6, count),
        "center_of_mass_z": 0.005 * rng.uniform(-1, 1, count),
        **{f"gravity_{axis}": g for axis, g in zip("xyz", gravity, strict=True)},
        "alpha": down + rng.normal(0, 0.4, count),
        "beta": down + rng.normal(0, 0.4, count),
        "alpha_rate": rng.normal(0, 2, count),
        "beta_rate": rng.normal(0, 2, count),
        "spin_rate": rng.normal(0, 40, count),
    }


def unbalanced_bodies(count: int, seed: int) -> dict[str, np.ndarray]:
    """:func:`cylinders` with random masses, principal axes and centres of mass off the journal's axis."""
    rng = np.random.default_rng([seed, 1])
    samples = cylinders(count, seed)
    mass = rng.uniform(0.2, 2, count)
    center = np.stack([*rng.normal(0, 2e-4, (2, count)), samples["center_of_mass_z"]], axis=1)
    squares = (
        mass[:, None] * (np.array([0.012, 0.012, 0.02]) * rng.uniform(0.8, 1.2, (count, 3))) ** 2
    )  # m x^2, m y^2, m z^2
    moments = squares.sum(axis=1, keepdims=True) - squares
    turn = Rotation.from_rotvec(rng.normal(0, 0.05, (count, 3))).as_matrix()
    inertia = turn @ (moments[:, :, None] * turn.transpose(0, 2, 1))
    inertia += mass[:, None, None] * (
        (center**2).sum(axis=1)[:, None, None] * np.eye(3) - center[:, :, None] * center[:, None, :]
    )
    entries = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}
    return samples | {
        "mass": mass,
        **{f"center_of_mass_{axis}": c for axis, c in zip("xyz", center.T, strict=True)},
        **{f"inertia_{name}": inertia[:, i, j] for name, (i, j) in entries.items()},
        "spin": rng.uniform(0, 2 * np.pi, count),
    }


def split(samples: dict[str, np.ndarray], rows=slice(None)) -> dict:
    """Keyword arguments of ``simulate_many`` for some rows of ``samples``."""
    chosen = {name: column[rows] for name, column in samples.items()}
    parameters = {name: column for name, column in chosen.items() if name not in DIMENSIONS}
    return {name: chosen[name] for name in DIMENSIONS} | {"parameters": parameters}


def row(scene: Scene, samples: dict[str, np.ndarray], index: int) -> Scene:
    """Sample ``index`` as a scene of its own."""
    return scene.replaced(**{name: float(column[index]) for name, column in samples.items()})
