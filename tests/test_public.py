"""The package as its users meet it: public names, their types, the version."""

import ast
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from places import ROOT

import tolmc

USERS_SCRIPT = """
import tolmc

joint = tolmc.Joint(bearing_radius=0.020, journal_radius=0.010, half_length=0.020)
body = tolmc.Body(0.5, [0, 0, 0.004], [4.08e-4, 4.08e-4, 1.2e-4])
scene = tolmc.Scene(joint, body, tolmc.Loads(gravity=(0, -9.81, 0)), tolmc.Motion(-1.92, -0.87), duration=1.0)
bores = tolmc.Dimension("bearing_radius", 0.02, 0.0199, 0.0201)
reveal_type(joint.tilt_angle)
reveal_type(body.inertia)
reveal_type(tolmc.tilt_angle(0.02, 0.01, 0.02))
reveal_type(tolmc.effective_radius([0.02, 0.021], 0.01, 0.02))
reveal_type(tolmc.simulate(scene))
reveal_type(bores.lower)
reveal_type(tolmc.Tolerances([bores]).dimensions)
reveal_type(tolmc.load_study("joint.toml"))
reveal_type(tolmc.run("joint.toml").plan.steps)
reveal_type(tolmc.resume("runs/joint").directory)
reveal_type(tolmc.replay("runs/joint", 3)[2])
reveal_type(tolmc.allocate("joint.toml").is_met)
reveal_type(tolmc.write_report("runs/joint"))
"""
REVEALED = [
    "float",
    "numpy.ndarray[tuple[Any, ...], numpy.dtype[Any]]",
    "float",
    "numpy.ndarray[tuple[Any, ...], numpy.dtype[numpy.float64]]",
    "tolmc.simulation.trajectory.Trajectory",
    "float",
    "tuple[tolmc.tolerances.dimension.Dimension, ...]",
    "tolmc.study.study.Study",
    "int",
    "pathlib.Path | None",
    "tolmc.simulation.trajectory.Trajectory",
    "bool",
    "pathlib.Path",
]
MISTAKES = {
    'tolmc.Joint("20 mm", 0.010, 0.020)': 'Argument 1 to "Joint" has incompatible type "str"',
    "tolmc.run(7)": 'Argument 1 to "run" has incompatible type "int"',
    "tolmc.simulate(tolmc.Motion(0, 0))": 'Argument 1 to "simulate" has incompatible type "Motion"',
    "tolmc.Tolerances(1.0)": 'Argument 1 to "Tolerances" has incompatible type "float"',
    "tolmc.Scenery": 'Module has no attribute "Scenery"',
}


def checked(folder: Path, **scripts: str) -> list[list[str]]:
    """Lines of the type checker about each of a user's scripts."""
    for name, script in scripts.items():
        (folder / f"{name}.py").write_text(script)
    command = [sys.executable, "-m", "mypy", "--config-file", str(ROOT / "pyproject.toml")]
    command += [str(folder / f"{name}.py") for name in scripts]
    ended = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=300)
    assert ended.stderr == ""
    lines = ended.stdout.splitlines()
    return [[line.split(": ", 1)[1] for line in lines if f"{name}.py:" in line] for name in scripts]


@pytest.mark.slow
def test_a_users_checker_sees_the_types(tmp_path):
    right, wrong = checked(tmp_path, script=USERS_SCRIPT, mistakes="\n".join(["import tolmc", *MISTAKES]))
    assert right == [f'note: Revealed type is "{name}"' for name in REVEALED]
    for found, expected in zip(wrong, MISTAKES.values(), strict=True):
        assert found.startswith(f"error: {expected}")


def test_checkers_are_told_what_is_loaded():
    """The imports for type checkers and the table from which names are loaded on first use say the same."""
    tree = ast.parse(Path(tolmc.__file__).read_text(encoding="utf-8"))
    block = next(node for node in tree.body if isinstance(node, ast.If))
    told = {name.asname: node.module for node in block.body for name in node.names}
    assert sorted(told) == tolmc.__all__
    for name, module in told.items():
        assert getattr(tolmc, name) is getattr(sys.modules[module], name)


def test_all_public_names_are_listed():
    assert set(tolmc.__all__) <= set(dir(tolmc))
    with pytest.raises(AttributeError, match="no attribute 'Scenery'"):
        _ = tolmc.Scenery


def test_the_version_stands_in_one_place():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    assert "version" in project["project"]["dynamic"]
    assert project["tool"]["setuptools"]["dynamic"]["version"] == {"attr": "tolmc.__version__"}
    assert (ROOT / "CHANGELOG.md").read_text(encoding="utf-8").count(f"\n## {tolmc.__version__} (2") == 1


def test_checkers_find_the_types_in_an_installed_package():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    assert project["tool"]["setuptools"]["package-data"]["tolmc"] == ["py.typed"]
    assert (ROOT / "tolmc" / "py.typed").is_file()


def test_a_script_finds_dimensions_and_what_they_follow():
    from tolmc.distributions import Scipy
    from tolmc.tolerances import Dimension, Tolerances, sample

    bores = Dimension(
        "bearing_radius", 20e-3, 19.9e-3, 20.1e-3, Scipy("norm", {"loc": 20e-3, "scale": 1e-5}, truncated=True)
    )
    drawn = sample(Tolerances([bores]), 100, sampling="random", seed=1)
    assert drawn["bearing_radius"].between(19.9e-3, 20.1e-3).all()
