"""Random samples and scenes, from sane to absurd, for ``fuzz.py``."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from tolmc.mechanism.geometry import effective_radius
from tolmc.mechanism.scene import Body, Joint, Loads, Motion, Scene
from tolmc.quantities import JOINT

SYMMETRIC = Scene(
    Joint(0.02, 0.01, 0.02),
    Body(0.5, (0, 0, 0.004), (4.08e-4, 4.08e-4, 1.2e-4)),
    Loads((0, -9.81, 0)),
    Motion(-1.92, -0.87, 2.0, -3.0, 0.0, 80.0),
    0.1,
)
_UNSYMMETRIC = ("mass", "inertia", "center_of_mass_x", "center_of_mass_y", "force_point_x", "force_point_y", "torque")
#: Kinds of ensembles, and the scalars that do not vary in them.
KINDS = {
    "symmetric body": _UNSYMMETRIC,
    "symmetric body, axial load": (*_UNSYMMETRIC, "gravity_x", "gravity_y", "force"),
    "any body": ("force", "torque"),
    "any body, all loads": (),
}
#: Decades of clearance ratio, of L/r* and of everything that has a scale.
LEVELS = {
    "sane": ((-1.5, 0.2), (-0.2, 0.6), 0.3),
    "far": ((-9.0, 1.0), (-1.7, 4.0), 2.0),
    "absurd": ((-15.0, 3.0), (-8.0, 8.0), 12.0),
}
_POISON = np.array([np.nan, np.inf, -np.inf, 0.0, -1.0, 1e30, -1e30, 5e-324])
_ENTRIES = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}


def samples(
    rng: np.random.Generator, count: int, kind: str, level: str, poisoned: float = 0.02
) -> dict[str, np.ndarray]:
    """Columns of the scalars that vary; a share ``poisoned`` of the samples has one value that is no number or impossible."""
    clearance, slenderness, decades = LEVELS[level]

    def scaled(size, shape=count):
        return size * 10 ** rng.uniform(-decades, decades, shape)

    journal = scaled(0.01)
    length = journal * 10 ** rng.uniform(*slenderness, count)
    columns = {
        "bearing_radius": journal * (1 + 10 ** rng.uniform(*clearance, count)),
        "journal_radius": journal,
        "half_length": length,
        **_body(rng, scaled(0.5), journal, length, decades),
        **_vector("gravity", scaled(9.81, (3, count)) * rng.normal(0, 0.6, (3, count))),
        **_vector("force", scaled(1.0, (3, count)) * rng.normal(size=(3, count))),
        **_vector("force_point", length * rng.normal(0, 0.5, (3, count))),
        **_vector("torque", scaled(1e-3, (3, count)) * rng.normal(size=(3, count))),
        "spin": rng.uniform(0, 2 * np.pi, count),
        "spin_rate": scaled(40.0) * rng.normal(size=count),
        "alpha_rate": scaled(2.0) * rng.normal(size=count),
        "beta_rate": scaled(2.0) * rng.normal(size=count),
    }
    if kind.startswith("symmetric"):
        columns["center_of_mass_z"] = rng.uniform(-0.02, 0.02, count)
    columns = {name: column for name, column in columns.items() if not name.startswith(KINDS[kind] or ("none",))}
    everything = SYMMETRIC.scalars | {"gravity_y": 0.0} | columns
    pull = [everything["mass"] * everything[f"gravity_{axis}"] + everything[f"force_{axis}"] for axis in "xy"]
    for name in ("alpha", "beta"):
        columns[name] = np.arctan2(pull[1], pull[0]) + rng.normal(0, 0.3 * (1 + decades), count)
    _poison(rng, columns, count, poisoned)
    return columns


def flights(rng: np.random.Generator, count: int, kind: str) -> dict[str, np.ndarray]:
    """The same of sane motions that start within the clearance, with restitutions from 0 to 1."""
    columns = samples(rng, count, kind, "sane", poisoned=0.0)
    for name in ("alpha", "beta", "alpha_rate", "beta_rate"):
        columns.pop(name, None)
    length = columns["half_length"]
    radius = effective_radius(columns["bearing_radius"], columns["journal_radius"], length)
    size, angle = np.sqrt(rng.uniform(0, 0.25, (2, count))), rng.uniform(0, 2 * np.pi, (2, count))
    speed = np.sqrt(9.81 * radius) * 10 ** rng.uniform(-0.5, 0.5, count)
    for name, scale, place in (("origin", 1.0, 0), ("slope", 1.0 / length, 1)):
        for axis, direction in (("x", np.cos), ("y", np.sin)):
            columns[f"{name}_{axis}"] = scale * radius * size[place] * direction(angle[place])
            columns[f"{name}_rate_{axis}"] = scale * speed * rng.normal(size=count)
    columns["restitution"] = np.where(
        rng.random(count) < 0.05, rng.integers(0, 2, count), rng.uniform(0, 1, count)
    )  # fmt: skip
    return columns


def scene(rng: np.random.Generator) -> Scene:
    """One scene whose motion lasts a few of its own periods, so that many of the far ones can be integrated."""
    kind, level = rng.choice(list(KINDS)), rng.choice(list(LEVELS), p=(0.4, 0.4, 0.2))
    values = {name: float(column[0]) for name, column in samples(rng, 1, kind, level, poisoned=0.0).items()}
    values = SYMMETRIC.scalars | {"gravity_y": 0.0} | values
    joint = Joint(*(values[name] for name in JOINT), str(rng.choice(["circle", "exact"])))

    def vector(name):
        return tuple(values[f"{name}_{axis}"] for axis in "xyz")

    inertia = np.empty((3, 3))
    for name, (i, j) in _ENTRIES.items():
        inertia[i, j] = inertia[j, i] = values[f"inertia_{name}"]
    body = Body(values["mass"], vector("center_of_mass"), inertia)
    loads = Loads(
        vector("gravity"),
        vector("force") if any(vector("force")) else None,
        vector("force_point") if any(vector("force")) else None,
        vector("torque") if any(vector("torque")) else None,
    )
    motion = Motion(*(values[name] for name in ("alpha", "beta", "alpha_rate", "beta_rate", "spin", "spin_rate")))
    pull = np.linalg.norm(np.add(loads.gravity, np.divide(loads.force or (0, 0, 0), body.mass)))
    rate = max(np.sqrt(pull / joint.effective_radius), *np.abs([motion.alpha_rate, motion.beta_rate, motion.spin_rate]))
    return Scene(joint, body, loads, motion, rng.uniform(0.3, 10) / rate)


def _vector(name, values):
    return {f"{name}_{axis}": column for axis, column in zip("xyz", values, strict=True)}


def _body(rng, mass, journal, length, decades):
    """Mass, centre of mass and inertia about O of bodies about as large as the journal, or of any shape and pose."""
    count = len(mass)
    center = np.stack([*rng.normal(0, 0.03, (2, count)) * journal, rng.uniform(-0.5, 0.5, count) * length])
    shape = rng.uniform(0.5, 1.5, (3, count)) * 10 ** rng.uniform(-decades / 6, decades / 6, (3, count))
    squares = mass * (shape * np.stack([journal, journal, length])) ** 2
    moments = squares.sum(axis=0) - squares
    turn = Rotation.from_rotvec(rng.normal(0, 0.1 * (1 + decades), (count, 3))).as_matrix()
    inertia = turn @ (moments.T[:, :, None] * turn.transpose(0, 2, 1))
    outer = center.T[:, :, None] * center.T[:, None, :]
    inertia += mass[:, None, None] * (np.sum(center**2, axis=0)[:, None, None] * np.eye(3) - outer)
    entries = {f"inertia_{name}": inertia[:, i, j] for name, (i, j) in _ENTRIES.items()}
    return {"mass": mass, **_vector("center_of_mass", center), **entries}


def _poison(rng, columns, count, share):
    names = list(columns)
    for row in np.flatnonzero(rng.random(count) < share):
        columns[names[rng.integers(len(names))]][row] = rng.choice(_POISON)
