import json
import math

import numpy as np
import pandas as pd
import pytest
from frames import assert_bitwise_equal
from scenes import DIMENSIONS
from small_study import GEOMETRY, write

import tolmc
from tolmc import quantities
from tolmc.errors import InputError
from tolmc.quantities import ALWAYS
from tolmc.runs import run as monte_carlo
from tolmc.runs.record import RunDirectoryError
from tolmc.runs.run import default_directory, replay, run
from tolmc.simulation.ensemble import simulate_many
from tolmc.statistics import summary as statistics
from tolmc.study.file import load_study
from tolmc.study.study import StudyError
from tolmc.tolerances.draw import sample

undrawn = pytest.mark.usefixtures("ready_pictures")

SAMPLINGS = ("random", "latin_hypercube", "sobol")


def test_samples_are_drawn_and_integrated_as_the_study_says(tmp_path):
    study = load_study(write(tmp_path))
    result = run(study, samples=40)
    dimensions = sample(study.tolerances, 40, sampling="sobol", seed=7)
    plan = result.plan
    expected = simulate_many(study.scene, **{name: dimensions[name] for name in dimensions}, plan=plan)
    assert set(ALWAYS) <= set(result.samples)
    assert_bitwise_equal(result.samples, expected)
    assert result.study.samples == 40


def test_summary_is_that_of_the_samples(tmp_path):
    result = run(write(tmp_path), samples=300)
    samples, summary = result.samples, result.summary
    assert list(summary.index) == [name for name in quantities.OUTPUTS if name in samples]
    assert summary.loc["tilt_angle", "unit"] == "rad"
    assert summary.loc["contact_force_D_max", "mean"] == pytest.approx(samples["contact_force_D_max"].mean())
    expected = statistics.summarise(
        samples,
        outputs=["tilt_angle"],
        sampling="sobol",
        specification={"tilt_angle": result.study.specification["tilt_angle"]},
    )
    pd.testing.assert_frame_equal(summary.loc[["tilt_angle"], expected.columns], expected)
    out = (samples["tilt_angle"] > math.radians(24.4)).mean()
    assert 0 < out < 1
    assert result.requirements.loc["tilt_angle", "share_least"] == pytest.approx(out)
    assert result.statuses["count"].sum() == 300
    assert result.nominal["tilt_angle"] == pytest.approx(math.radians(24.2951889), rel=1e-8)


@pytest.mark.parametrize("sampling", SAMPLINGS)
def test_numbers_do_not_depend_on_workers_or_blocks(tmp_path, monkeypatch, sampling):
    study = load_study(write(tmp_path, ('"sobol"', f'"{sampling}"')))
    expected = run(study, samples=700, workers=1).samples
    for workers, step, largest in ((2, 256, 16384), (3, 1, 101), (1, 7, 7 * 16), (2, 64, 64)):
        monkeypatch.setattr(monte_carlo, "_BLOCK_STEP", step)
        monkeypatch.setattr(monte_carlo, "LARGEST_BLOCK", largest)
        assert_bitwise_equal(run(study, samples=700, workers=workers).samples, expected)


@pytest.mark.parametrize("sampling", ["random", "sobol"])
def test_a_longer_run_begins_with_the_shorter_one(tmp_path, sampling):
    study = load_study(write(tmp_path, ('"sobol"', f'"{sampling}"'), *GEOMETRY))
    short, long = run(study, samples=1000).samples, run(study, samples=2500).samples
    assert_bitwise_equal(short, long.iloc[:1000])


def test_seed_decides(tmp_path):
    study = load_study(write(tmp_path, *GEOMETRY))
    assert_bitwise_equal(run(study, seed=3).samples, run(study, seed=3).samples)
    assert not np.array_equal(run(study, seed=3).samples["tilt_angle"], run(study, seed=4).samples["tilt_angle"])


def test_without_tolerances_every_sample_is_the_nominal_one(tmp_path):
    path = write(tmp_path, (', tolerance = "0.05 mm"', ""), (', tolerance = ["-0.03 mm", "0 mm"]', ""),
                 (', tolerance = "0.1 mm", distribution = "uniform"', ""))  # fmt: skip
    result = run(path, samples=20)
    for name in ALWAYS:
        values = result.samples[name].to_numpy()
        assert np.array_equal(values, np.full(20, result.nominal[name]), equal_nan=True), name


def test_other_scalars_vary_too(tmp_path):
    result = run(
        write(tmp_path, ("[body]", 'mass = { tolerance = "50 g" }\nalpha = { tolerance = "2 deg" }\n[body]')),
        samples=64,
    )
    assert result.samples["mass"].between(0.45, 0.55).all() and result.samples["mass"].nunique() == 64
    assert np.corrcoef(result.samples["mass"], result.samples["contact_force_D_mean"])[0, 1] > 0.9


INERTIA_ABOUT_O = "inertia = [4.08e-4, 4.08e-4, 1.2e-4]"
MASS = (
    'distribution = "uniform" }',
    'distribution = "uniform" }\nmass = { tolerance = "0.05 kg" }',
)


@pytest.mark.parametrize(
    ("body", "grows"),
    [
        ('solid_cylinder = { radius = "20 mm", length = "60 mm" }', True),
        ("centroidal_inertia = [4e-4, 4e-4, 1.2e-4]", False),
    ],
)
def test_the_inertia_follows_mass_and_centre_unless_given_about_o(tmp_path, body, grows):
    center = ("[body]", 'center_of_mass_z = { tolerance = "1 mm" }\n\n[body]')
    result = run(write(tmp_path, MASS, center, (INERTIA_ABOUT_O, body)), samples=40)
    samples, nominal = result.samples, result.study.scene.body
    assert samples["mass"].std() > 0.01
    about_center = nominal.centroidal_inertia[0, 0] * (samples["mass"] / 0.5 if grows else 1.0)
    inertia = {
        "inertia_xx": about_center + samples["mass"] * samples["center_of_mass_z"] ** 2,
        "inertia_zz": nominal.inertia[2, 2] * (samples["mass"] / 0.5 if grows else 1.0),
    }
    inertia["inertia_yy"] = inertia["inertia_xx"]
    columns = {name: samples[name] for name in ("mass", "center_of_mass_z")}
    expected = simulate_many(
        result.study.scene,
        **{name: samples[name] for name in DIMENSIONS},
        parameters=columns | inertia,
        plan=result.plan,
    )
    for name in ("contact_force_D_max", "contact_force_E_min", "tilt_max"):
        np.testing.assert_allclose(samples[name], expected[name], rtol=1e-9)
    assert not any(name.startswith("inertia") for name in samples)


@undrawn
def test_replay_of_a_sample_with_its_own_mass(tmp_path):
    cylinder = (INERTIA_ABOUT_O, 'solid_cylinder = { radius = "20 mm", length = "60 mm" }')
    run(write(tmp_path, MASS, cylinder), samples=40, out=tmp_path / "run")
    _, scene, motion, row = replay(tmp_path / "run", 7)
    assert scene.body == tolmc.Body.solid_cylinder(row["mass"], 0.02, 0.06, (0, 0, 0.004))
    assert motion.contact_force[:, 0].max() == pytest.approx(row["contact_force_D_max"], rel=1e-3)


def test_an_inertia_cannot_vary_in_two_ways(tmp_path):
    cylinder = (INERTIA_ABOUT_O, 'solid_cylinder = { radius = "20 mm", length = "60 mm" }')
    both = (MASS[0], MASS[1] + '\ninertia_zz = { tolerance = "1e-6 kg m^2" }')
    with pytest.raises(StudyError, match=r"inertia_zz.*about O"):
        load_study(write(tmp_path, both, cylinder))


def test_geometry_alone_integrates_nothing(tmp_path):
    result = run(write(tmp_path, *GEOMETRY), samples=500)
    assert list(result.summary.index) == ["tilt_angle", "effective_radius"]
    assert (result.samples["status"] == "ok").all()
    dimensions = [result.samples[name] for name in ("bearing_radius", "journal_radius", "half_length")]
    np.testing.assert_array_equal(result.samples["tilt_angle"], tolmc.tilt_angle(*dimensions))


def test_samples_without_clearance_are_counted_not_dropped(tmp_path):
    wide = (
        'nominal = "10 mm", tolerance = ["-0.03 mm", "0 mm"]',
        'nominal = "19.95 mm", tolerance = "0.1 mm", distribution = "uniform"',
    )
    result = run(write(tmp_path, wide, *GEOMETRY), samples=2000)
    share = (result.samples["status"] == "geometry invalid").mean()
    assert 0.1 < share < 0.5
    assert result.statuses.loc["geometry invalid", "share"] == pytest.approx(share)
    assert result.requirements.loc["tilt_angle", "share_most"] >= share


def test_a_run_writes_what_people_need(tmp_path):
    study = write(tmp_path)
    out = tmp_path / "deep" / "run"
    result = run(study, samples=300, out=out)
    assert {path.name for path in out.iterdir()} == {
        ".lock", "study.toml", "run.json", "samples.parquet", "exact_section.parquet", "summary.csv", "requirements.csv",
        "distributions.png", "drivers.png", "nominal.png",
    }  # fmt: skip
    assert (out / "study.toml").read_bytes() == study.read_bytes()
    record = json.loads((out / "run.json").read_text())
    assert (record["state"], record["samples"], record["seed"], record["sampling"]) == ("complete", 300, 7, "sobol")
    assert {"python", "numpy", "numba", "tolmc"} <= set(record["versions"])
    assert record["study_sha256"] == result.study.sha256
    samples = pd.read_parquet(out / "samples.parquet")
    assert_bitwise_equal(samples, run(study, samples=300).samples)
    assert_bitwise_equal(samples, result.samples)
    summary = pd.read_csv(out / "summary.csv", index_col="output").assign(section="")
    assert (result.summary["section"] == "").all()
    pd.testing.assert_frame_equal(summary, result.summary, check_dtype=False)
    assert result.directory == out


def test_nothing_is_written_when_the_study_cannot_be_used(tmp_path):
    out = tmp_path / "run"
    with pytest.raises(StudyError):
        run(write(tmp_path, ('mass = "0.5 kg"', 'mass = "0.5 m"')), out=out)
    with pytest.raises(StudyError, match="samples = 0"):
        run(write(tmp_path), samples=0, out=out)
    assert not out.exists()


@undrawn
def test_a_run_never_overwrites(tmp_path):
    study, out = write(tmp_path, *GEOMETRY), tmp_path / "run"
    run(study, out=out)
    before = {path.name: path.read_bytes() for path in out.iterdir()}
    with pytest.raises(RunDirectoryError, match="already holds a run"):
        run(study, seed=99, out=out)
    assert {path.name: path.read_bytes() for path in out.iterdir()} == before
    for name in ("samples.parquet", "study.toml", "blocks"):
        other = tmp_path / f"other-{name}"
        other.mkdir()
        (other / name).write_text("mine")
        with pytest.raises(RunDirectoryError, match=name):
            run(study, out=other)
        assert [(path.name, path.read_text()) for path in other.iterdir()] == [(name, "mine")]
    with pytest.raises(RunDirectoryError, match="is a file"):
        run(study, out=study)


def test_default_directory_is_a_new_one(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert str(default_directory("studies/paper.toml").claim()) == "runs/paper"
    (tmp_path / "runs" / "paper-2").mkdir()
    assert str(default_directory("paper.toml").claim()) == "runs/paper-3"


@undrawn
def test_replay_repeats_a_sample(tmp_path):
    out = tmp_path / "run"
    result = run(write(tmp_path), samples=600, out=out)
    for index in (0, 599):
        study, scene, trajectory, row = replay(out, index)
        assert study.sha256 == result.study.sha256
        assert row["status"] == result.samples["status"].iloc[index]
        assert scene.joint.bearing_radius == result.samples["bearing_radius"].iloc[index]
        assert trajectory.contact_force[:, 0].max() == pytest.approx(row["contact_force_D_max"], rel=1e-4)
        assert trajectory.time[-1] == study.scene.duration
    with pytest.raises(RunDirectoryError, match="no sample 600; allowed: 0 to 599"):
        replay(out, 600)


@undrawn
def test_replay_of_a_sample_without_a_motion(tmp_path):
    wide = ('nominal = "10 mm", tolerance = ["-0.03 mm", "0 mm"]', 'nominal = "19.95 mm", tolerance = "0.1 mm"')
    out = tmp_path / "run"
    result = run(write(tmp_path, wide, *GEOMETRY), samples=500, out=out)
    index = int(np.argmax(result.samples["status"] == "geometry invalid"))
    with pytest.raises(InputError, match=f"sample {index}"):
        replay(out, index)


def test_integration_stays_below_what_sampling_leaves(tmp_path):
    """The default accuracy follows the sampling, not the number of samples; an accuracy or a step of the study's own wins."""
    sobol = load_study(write(tmp_path))
    random = load_study(write(tmp_path, ('sampling = "sobol"', 'sampling = "random"')))
    own = load_study(write(tmp_path, ("seed = 7", "seed = 7\naccuracy = 1e-6")))
    step = load_study(write(tmp_path, ("seed = 7", 'seed = 7\nstep = "1 ms"')))
    assert [study.integration_accuracy for study in (sobol, random, own, step)] == [1e-8, None, 1e-6, None]
    result = run(sobol)
    assert result.plan.accuracy == 1e-8
    budget = statistics.error_budget(result.summary)
    forces = budget.loc[[name for name in budget.index if name.startswith("contact_force")]]
    assert (forces["integration"] < 0.1 * forces[["mean", "sd", "q50"]].min(axis=1)).all()


@undrawn
def test_a_run_of_geometry_with_a_body_of_any_shape_is_written(tmp_path):
    products = "inertia = [[4.08e-4, 0, 1e-6], [0, 4.08e-4, 0], [1e-6, 0, 1.2e-4]]"
    study = load_study(write(tmp_path, *GEOMETRY, ("inertia = [4.08e-4, 4.08e-4, 1.2e-4]", products)))
    run(study.replaced(samples=10), out=tmp_path / "run")
    assert json.loads((tmp_path / "run" / "run.json").read_text())["plan"]["features"]["spin"] is False


def test_the_statistics_are_told_before_the_pictures_are_drawn(tmp_path, monkeypatch):
    order, finish = [], monte_carlo.RunPictures.finish

    def finish_pictures(self):
        order.append("pictures")
        return finish(self)

    monkeypatch.setattr(monte_carlo.RunPictures, "finish", finish_pictures)
    result = run(write(tmp_path), samples=8, out=tmp_path / "run", on_summary=order.append)
    told = order[0]
    assert order[1:] == ["pictures"]
    pd.testing.assert_frame_equal(told.summary, result.summary)
    in_memory = []
    run(write(tmp_path), samples=8, on_summary=in_memory.append)
    assert [told.directory for told in in_memory] == [None]
