import json
import os
import subprocess
import sys

import pandas as pd
import pytest
from click.testing import CliRunner
from complaints import complaints
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from places import STUDIES
from small_study import GEOMETRY, TEXT, write

import tolmc
from tolmc.cli import main
from tolmc.errors import InputError

undrawn = pytest.mark.usefixtures("ready_pictures")


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path, monkeypatch):
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")


def invoke(*arguments):
    result = CliRunner().invoke(main, [str(argument) for argument in arguments])
    assert result.exception is None or isinstance(result.exception, SystemExit), result.exception
    return result


@undrawn
def test_run_from_another_folder(tmp_path):
    result = invoke("run", write(tmp_path), "--samples", 200)
    assert result.exit_code == 0 and not complaints(result.stderr)
    assert "A small study: 200 samples, sobol, seed 7" in result.stdout
    for words in ("Tilt angle ψ", "Contact force N_D, max", "≤ 24.4 deg", "ok", "Written: runs/small"):
        assert words in result.stdout
    assert len(pd.read_parquet("runs/small/samples.parquet")) == 200
    again = invoke("run", write(tmp_path), "--samples", 200, "--seed", 8)
    assert "Written: runs/small-2" in again.stdout


@undrawn
def test_options_of_run(tmp_path):
    study = write(tmp_path, *GEOMETRY)
    invoke("run", study, "--samples", 500, "--seed", 11, "--workers", 1, "--out", "here")
    expected = tolmc.run(study, samples=500, seed=11)
    pd.testing.assert_frame_equal(pd.read_parquet("here/samples.parquet"), expected.samples)
    assert invoke("run", "--resume", "here", "--extend", 20).exit_code == 0
    longer = tolmc.run(study, samples=520, seed=11).samples
    pd.testing.assert_frame_equal(pd.read_parquet("here/samples.parquet"), longer, check_categorical=False)
    assert invoke("run", study, "--resume", "here").exit_code == 0


@undrawn
def test_tolerances_without_clearance_are_noted_before_the_run(tmp_path, monkeypatch):
    wide = ('nominal = "20 mm", tolerance = "0.05 mm"', 'nominal = "20 mm", tolerance = "11 mm"')
    path = write(tmp_path, wide, *GEOMETRY)
    result = invoke("run", path, "--samples", 100)
    assert result.exit_code == 0
    for words in ("bearing_radius (from 9 mm)", "journal_radius (to 10 mm)", "R* − r* is -1 mm", "geometry invalid"):
        assert words in result.stderr

    def stop(*arguments, **options):
        raise InputError("no work was begun")

    monkeypatch.setattr("tolmc.runs.run.run", stop)
    stopped = invoke("run", path)
    assert stopped.stderr.startswith("Note: ") and stopped.stderr.endswith("Error: no work was begun\n")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["run"], "STUDY"),
        (["run", "absent.toml"], "absent.toml cannot be read"),
        (["run", "STUDY", "--samples", "0"], "--samples"),
        (["run", "STUDY", "--samples", "9999999999"], "samples = 9999999999"),
        (["run", "STUDY", "--seed", "x"], "--seed"),
        (["run", "STUDY", "--extend", "5"], "--resume"),
        (["run", "STUDY", "--out", "STUDY"], "is a file"),
        (["run", "--resume", "absent"], "absent is no run directory"),
        (["run", "--resume", "absent", "--samples", "5"], "leave them out"),
        (["run", "STUDY", "--sample", "5"], "--samples"),
        (["run", "STUDY", "--cluster", "nowhere"], "nowhere"),
        (["rnu", "STUDY"], "rnu"),
        (["simulate", "absent.toml"], "absent.toml cannot be read"),
        (["replay", "absent", "--sample", "1"], "absent is no run directory"),
        (["replay", "absent"], "--sample"),
    ],
)
def test_typing_errors_end_with_a_message(tmp_path, arguments, words):
    study = str(write(tmp_path, *GEOMETRY))
    result = invoke(*(study if argument == "STUDY" else argument for argument in arguments))
    assert result.exit_code == 2
    assert words in result.stderr
    assert "Traceback" not in result.output
    assert not os.listdir()


def test_simulate_shows_the_nominal_motion(tmp_path):
    result = invoke("simulate", write(tmp_path))
    assert result.exit_code == 0 and not complaints(result.stderr)
    assert "24.29519 deg" in result.stdout and "Status: ok" in result.stdout
    with open("small.png", "rb") as picture:
        assert picture.read(8) == b"\x89PNG\r\n\x1a\n"
    assert "Written: small.png" in result.stdout


@undrawn
def test_replay_shows_one_sample(tmp_path):
    invoke("run", write(tmp_path), "--samples", 30, "--out", "here")
    result = invoke("replay", "here", "--sample", 29)
    assert result.exit_code == 0 and not complaints(result.stderr)
    row = pd.read_parquet("here/samples.parquet").iloc[29]
    assert f"{1e3 * row['bearing_radius']:.5g}" in result.stdout
    assert os.path.exists("here/sample_29.png")
    assert invoke("replay", "here", "--sample", 30).exit_code == 2


@undrawn
@pytest.mark.slow
def test_answers_and_report_of_more_dimensions_than_have_corners(tmp_path):
    names = ("mass", "alpha", "beta", "spin", "alpha_rate", "beta_rate", "spin_rate", *(f"gravity_{c}" for c in "xyz"))
    names += tuple(f"center_of_mass_{c}" for c in "xyz")
    varied = "\n".join(f"{name} = {{ tolerance = 1e-4 }}" for name in names)
    kept = ('max = "24.4 deg"', 'max = "26 deg"')  # where no limit is broken there is nothing to change
    study = write(tmp_path, ("[body]", f"{varied}\n[body]"), kept, *GEOMETRY)
    invoke("run", study, "--samples", 200, "--out", "here")
    result = invoke("answers", "here")
    assert result.exit_code == 0 and "RSS" in result.stdout and "…" not in result.stdout
    assert "corners by the signs of the sensitivities" in pd.read_csv("here/stackup.csv")["verdict"].iloc[-1]
    assert invoke("report", "here").exit_code == 0 and os.path.exists("here/report.html")


@undrawn
def test_titles_and_folders_may_hold_any_characters(tmp_path):
    path = write(tmp_path, ("A small study", "50 [bold] $x_{$ ψ \\\\n [/]"), *GEOMETRY)
    result = invoke("run", path, "--samples", 100, "--out", "[red] $y")
    assert result.exit_code == 0
    assert "50 [bold] $x_{$ ψ" in result.stdout and "Written: [red] $y" in result.stdout
    assert os.path.exists("[red] $y/drivers.png")


@settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(at=st.integers(0, len(TEXT) - 1), length=st.integers(0, 12), inserted=st.binary(max_size=3))
def test_no_damaged_study_ends_in_a_traceback(tmp_path, at, length, inserted):
    file = tmp_path / "damaged.toml"
    content = TEXT.replace("[monte_carlo]", '[monte_carlo]\noutputs = ["tilt_angle", "contact_force_D_max"]').encode()
    file.write_bytes(content[:at] + inserted + content[at + length :])
    result = invoke("simulate", file, "--out", tmp_path / "picture.png")
    assert result.exit_code in (0, 2)
    if result.exit_code == 2:
        assert result.stderr.startswith("Error: ") and str(file) in result.stderr


def run_process(*arguments):
    command = [sys.executable, "-c", "from tolmc.cli import main; main()", *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=60)


def test_help_names_every_command():
    result = run_process("--help")
    assert result.returncode == 0
    for command in ("run", "simulate", "replay", "report", "allocate"):
        assert command in result.stdout
        assert invoke(command, "--help").exit_code == 0
    assert tolmc.__version__ in invoke("--version").stdout


def test_help_loads_nothing_heavy():
    code = "import sys; from tolmc.cli import main; main(['--help'], standalone_mode=False); print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert not {"numpy", "numba", "pandas", "scipy", "matplotlib", "pydantic", "pint", "rich", "joblib"} & set(loaded)


def test_a_process_ends_with_a_message_and_code():
    result = run_process("check", "absent.toml")
    assert result.returncode == 2 and result.stdout == ""
    assert result.stderr.startswith("Error: absent.toml cannot be read") and "Traceback" not in result.stderr


@pytest.mark.slow
@pytest.mark.parametrize("path", sorted(STUDIES.glob("*.toml")), ids=lambda path: path.stem)
def test_the_studies_of_the_repository_run(path):
    result = invoke("run", path, "--samples", 1000)
    said = [line for line in complaints(result.stderr) if not line.startswith("Note: ")]
    assert result.exit_code == 0 and not said
    samples = pd.read_parquet(f"runs/{path.stem}/samples.parquet")
    assert (samples["status"] == "ok").mean() > 0.9


@undrawn
def test_run_as_json_and_in_brief(tmp_path):
    path = write(tmp_path, *GEOMETRY)
    shown = invoke("run", path, "--samples", 200, "--json")
    assert shown.exit_code == 0
    found = json.loads(shown.stdout)
    expected = tolmc.run(path, samples=200)
    assert (
        found["samples"] == 200 and found["summary"]["tilt_angle"]["mean"] == expected.summary.at["tilt_angle", "mean"]
    )
    assert found["requirements"]["tilt_angle"]["out"] == expected.requirements.at["tilt_angle", "out"]
    brief = invoke("run", path, "--samples", 200, "--brief").stdout
    assert "Tilt angle ψ" in brief and "Effective radius" not in brief and "Status" not in brief
    whole = invoke("run", path, "--samples", 200).stdout
    assert "Effective radius" in whole and "Status" in whole
    assert invoke("run", path, "--json", "--brief").exit_code == 2
