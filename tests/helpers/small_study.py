"""A study for tests: the paper's joint over a short time, and the means to change it."""

from pathlib import Path

TEXT = """
title = "A small study"

[dimensions]
bearing_radius = { nominal = "20 mm", tolerance = "0.05 mm" }
journal_radius = { nominal = "10 mm", tolerance = ["-0.03 mm", "0 mm"] }
half_length    = { nominal = "20 mm", tolerance = "0.1 mm", distribution = "uniform" }

[body]
mass = "0.5 kg"
center_of_mass = ["0 mm", "0 mm", "4 mm"]
inertia = [4.08e-4, 4.08e-4, 1.2e-4]

[loads]
gravity = [0, -9.81, 0]

[motion]
alpha = "-110 deg"
beta = "-50 deg"
alpha_rate = "2 rad/s"
beta_rate = "-3 rad/s"
spin_rate = "80 rad/s"
duration = "0.1 s"

[monte_carlo]
samples = 3000
sampling = "sobol"
seed = 7
workers = 2

[specification]
tilt_angle = { max = "24.4 deg" }
contact_force_D_max = { max = "4.5 N" }
"""


def write(folder: Path, *changes: tuple[str, str], name: str = "small.toml") -> Path:
    """The study as a file, with each (old, new) text replaced."""
    text = TEXT
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new)
    path = Path(folder) / name
    path.write_text(text, encoding="utf-8")
    return path


#: Geometry alone: no motion is integrated, so that thousands of samples take milliseconds.
GEOMETRY = (
    ("[monte_carlo]", '[monte_carlo]\noutputs = ["tilt_angle", "effective_radius"]'),
    ('contact_force_D_max = { max = "4.5 N" }\n', ""),
)
