"""Scenes of the reference motions with one-sided contact, and all outputs of a motion."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
from scenes import dimensions

import tolmc
from tolmc.quantities import END_OUTPUTS

CASES = json.loads((Path(__file__).parents[1] / "data" / "one_sided.json").read_text())


def scene_of(case):
    joint = tolmc.Joint(*(case[name] for name in ("bearing_radius", "journal_radius", "half_length", "section")))
    motion = case["motion"]
    contact = {name: case[name] for name in ("restitution", "friction", "slip_speed") if case[name] is not None}
    return tolmc.Scene(
        replace(joint, **contact),
        tolmc.Body(case["mass"], case["center_of_mass"], case["inertia"]),
        tolmc.Loads(case["gravity"], case["force"], case["force_point"]),
        tolmc.Motion.free(**motion) if "origin" in motion else tolmc.Motion(**motion),
        case["duration"],
    )


def row_of(scene, **options):
    """All outputs of one motion, the state at its end included."""
    statistics = tolmc.simulate_many(scene, **dimensions(scene), **options).iloc[0]
    end = tolmc.simulate_many(scene, **dimensions(scene), outputs=END_OUTPUTS, **options).iloc[0]
    return pd.concat([statistics, end[list(END_OUTPUTS)]])


def some_of(scene, outputs, **options):
    """These outputs of one motion, integrated once."""
    return tolmc.simulate_many(scene, **dimensions(scene), outputs=list(outputs), **options).iloc[0]


def bore(scene, n, seed=0):
    """Bearing radii of ``n`` samples that differ by a twentieth of the clearance."""
    joint = scene.joint
    spread = 0.05 * (joint.bearing_radius - joint.journal_radius)
    return joint.bearing_radius + spread * np.random.default_rng(seed).uniform(-1, 1, n)
