"""A study of a shaft that wears: it stays at its attitude under its weight, and its drive holds the speed."""

import math

from small_study import write

from tolmc.study.file import load_study

K, SPEED, HOURS = 1e-14, 20.0, 1000.0
LIFE = f"""
[contact]
friction = 0.15
slip_speed = "0.1 mm/s"
wear_coefficient = "1e-5 mm^3/(N m)"

[life]
running_time = "{HOURS} h"
"""
#: A shaft that stays at its attitude under its weight, its centre of mass in the middle plane.
STEADY = (
    ('"0 mm", "4 mm"', '"0 mm", "0 mm"'),
    ("[loads]", '[loads]\ndrive = "constant speed"'),
    ('alpha = "-110 deg"', f"alpha = {-math.pi / 2 - math.atan(0.15)!r}"),
    ('beta = "-50 deg"', f"beta = {-math.pi / 2 - math.atan(0.15)!r}"),
    ('alpha_rate = "2 rad/s"\n', ""),
    ('beta_rate = "-3 rad/s"\n', ""),
    ('"80 rad/s"', f'"{SPEED} rad/s"'),
    ('duration = "0.1 s"', 'duration = "0.01 s"'),
    ("samples = 3000", "samples = 64"),
    ('nominal = "10 mm"', 'nominal = "19.9 mm"'),
    ('tilt_angle = { max = "24.4 deg" }\ncontact_force_D_max = { max = "4.5 N" }', 'approximate_radius = { max = "0.18 mm" }'),
    ("\n[motion]", f"{LIFE}\n[motion]"),
)  # fmt: skip


def study(folder, *changes):
    """The study, with each (old, new) text replaced."""
    return load_study(write(folder, *STEADY, *changes))
