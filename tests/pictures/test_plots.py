import dataclasses

import numpy as np
import pandas as pd
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from small_study import write

from tolmc.errors import InputError
from tolmc.pictures import DISTRIBUTIONS, plots
from tolmc.quantities import SCALARS
from tolmc.runs.nominal import study_motion
from tolmc.runs.run import run
from tolmc.statistics.drivers import drivers_of, rank_correlations
from tolmc.study.file import load_study


def words(figure: Figure) -> list[str]:
    """Every text of a figure that is drawn."""
    FigureCanvasAgg(figure)
    figure.draw_without_rendering()
    return [
        text.get_text() for text in figure.findobj(lambda artist: hasattr(artist, "get_text")) if text.get_visible()
    ]


def assert_nothing_is_cut_off(figure: Figure):
    canvas = FigureCanvasAgg(figure)
    figure.draw_without_rendering()
    drawn = figure.get_tightbbox(canvas.get_renderer())  # inches
    assert drawn.x0 >= 0 and drawn.y0 >= 0
    assert drawn.x1 <= figure.get_figwidth() and drawn.y1 <= figure.get_figheight()


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    return run(write(tmp_path_factory.mktemp("plots")), samples=1000)


def distributions(samples, **options):
    options = {"nominal": {}, "specification": {}, "title": "A study"} | options
    return plots.draw_distributions(samples, list(samples)[:4], **options)


def test_distributions_show_samples_nominal_and_limits(result):
    shown = result.samples[[name for name in DISTRIBUTIONS if name in result.samples]]
    limits = {"tilt_angle": {"max": np.radians(24.4)}, "contact_force_D_max": {"min": 0.0, "max": 400.0}}
    figure = distributions(shown, nominal=result.nominal, specification=limits)
    texts = words(figure)
    assert "A study: 1,000 samples" in texts
    assert "Tilt angle ψ (deg)" in texts and "Effective radius r (mm)" in texts
    assert "nominal 24.295 deg" in texts and "limit 24.4 deg" in texts
    assert "limit 400 N →" in texts and "← limit 0 N" in texts
    assert_nothing_is_cut_off(figure)
    counts = figure.axes[0].patches[0].get_data().values
    assert counts.sum() == pytest.approx(100)


def test_a_million_samples_become_few_bars():
    values = np.random.default_rng(1).normal(1.0, 0.1, 1_000_000)
    figure = distributions(pd.DataFrame({"tilt_angle": values}))
    axis = figure.axes[0]
    assert len(axis.patches[0].get_data().values) <= 80
    assert not axis.collections and all(len(line.get_xdata()) < 10 for line in axis.lines)


def test_a_far_tail_is_counted_not_shown():
    values = np.random.default_rng(1).normal(1.0, 0.01, 100_000)
    values[::5000] = 500.0
    figure = distributions(pd.DataFrame({"tilt_max": values}))
    assert "20 samples off the scale" in words(figure)
    assert figure.axes[0].get_xlim()[1] < 100


@pytest.mark.parametrize(
    "values",
    [
        [],
        [np.nan, np.nan],
        [0.0],
        [0.3] * 50,
        [0.0] * 50,
        [1.0, 1.0 + 1e-15],
        [-1e30, 1e30],
        [np.nan, 2.0, 3.0],
        [1e-30] * 3,
    ],
)
def test_any_values_can_be_drawn(values):
    frame = pd.DataFrame({"tilt_angle": np.array(values, float)})
    words(distributions(frame, nominal={"tilt_angle": 0.3}, specification={"tilt_angle": {"max": 0.4}}))
    frame["bearing_radius"] = np.arange(len(values), dtype=float)
    words(plots.draw_drivers(drivers_of(frame, ["bearing_radius"]), title="$_{"))


def test_drivers_name_the_strongest_input(result):
    drivers = drivers_of(result.samples, ["bearing_radius", "journal_radius", "half_length"])
    figure = plots.draw_drivers(drivers, title="A study")
    texts = words(figure)
    assert_nothing_is_cut_off(figure)
    correlations = rank_correlations(
        result.samples, ["bearing_radius", "half_length"], ["tilt_angle", "effective_radius"]
    )
    assert (
        correlations.loc["effective_radius", "bearing_radius"] > 0.8 > 0 > correlations.loc["tilt_angle", "half_length"]
    )
    assert f"{correlations.loc['tilt_angle', 'half_length']:+.2f}".replace("-", "−") in texts
    assert any(text.startswith("strongest driver: ") for text in texts)


@pytest.mark.parametrize("count", [1, 4, 5, 12])
def test_drivers_of_few_or_many_inputs_fit(result, count):
    names = [name for name in SCALARS if name not in result.samples][:count]
    noise = np.random.default_rng(3).normal(size=(len(result.samples), count))
    samples = pd.concat([result.samples, pd.DataFrame(noise, columns=names)], axis=1)
    assert_nothing_is_cut_off(plots.draw_drivers(drivers_of(samples, names), title="A study"))


def test_rank_correlation_is_that_of_spearman():
    x = np.random.default_rng(2).normal(size=(500, 2))
    frame = pd.DataFrame({"a": x[:, 0], "b": np.exp(x[:, 0]), "c": x[:, 0] + x[:, 1], "d": np.ones(500)})
    found = rank_correlations(frame, ["a"], ["b", "c", "d"])["a"]
    assert found["b"] == pytest.approx(1)
    assert found["c"] == pytest.approx(6 / np.pi * np.arcsin(np.sqrt(0.5) / 2), abs=0.06)
    assert np.isnan(found["d"])


def test_drivers_without_any(result):
    assert any(
        "no dimension" in text for text in words(plots.draw_drivers(drivers_of(result.samples, []), title="A study"))
    )


def test_trajectory_shows_traces_forces_and_angles(tmp_path):
    study = load_study(write(tmp_path))
    trajectory = study_motion(study)
    figure = plots.draw_trajectory(trajectory, study.scene, title="A motion")
    assert_nothing_is_cut_off(figure)
    small = dataclasses.replace(trajectory, origin=1e-4 * trajectory.origin)
    assert_nothing_is_cut_off(plots.draw_trajectory(small, study.scene.replaced(half_length=2e-6), title="A motion"))
    traces, forces, angles = figure.axes
    circle, *lines = traces.lines
    assert np.hypot(circle.get_xdata(), circle.get_ydata()) == pytest.approx(1e3 * study.scene.joint.effective_radius)
    for line in lines:  # D and E stay on the circle
        assert np.hypot(line.get_xdata(), line.get_ydata()) == pytest.approx(1e3 * study.scene.joint.effective_radius)
    assert [line.get_ydata()[0] for line in angles.lines] == pytest.approx([-110, -50])
    np.testing.assert_array_equal(forces.lines[1].get_ydata(), trajectory.contact_force[:, 0])
    assert "contact lost" not in words(figure)


def test_lost_contact_is_marked(tmp_path):
    study = load_study(write(tmp_path, ('alpha_rate = "2 rad/s"', 'alpha_rate = "40 rad/s"')))
    trajectory = study_motion(study)
    assert (trajectory.contact_force < 0).any()
    assert "contact lost" in words(plots.draw_trajectory(trajectory, study.scene, title="A motion"))


@pytest.mark.parametrize(("suffix", "magic"), [("png", b"\x89PNG"), ("svg", b"<?xml"), ("pdf", b"%PDF")])
def test_pictures_are_saved_in_the_format_of_their_name(tmp_path, suffix, magic):
    plots.save(distributions(pd.DataFrame({"tilt_angle": [0.1, 0.2]})), tmp_path / f"picture.{suffix}")
    assert (tmp_path / f"picture.{suffix}").read_bytes().startswith(magic)


@pytest.mark.parametrize("name", ["picture", "picture.foo", "picture."])
def test_a_picture_needs_a_known_ending(tmp_path, name):
    with pytest.raises(InputError, match="png"):
        plots.save(distributions(pd.DataFrame({"tilt_angle": [0.1, 0.2]})), tmp_path / name)


def test_drawing_leaves_no_state_behind():
    import matplotlib

    before = dict(matplotlib.rcParams)
    distributions(pd.DataFrame({"tilt_angle": [0.1, 0.2]}))
    assert dict(matplotlib.rcParams) == before


@pytest.mark.parametrize(("is_met", "word"), [(True, "chosen"), (False, "not shown to suffice")])
def test_cost_against_yield_marks_the_winner(is_met, word):
    trade_off = pd.DataFrame(
        {"required_yield": [0.9, 0.99, 0.9999], "cost": [1.0, 2.0, 4.0], "out_ppm": [9e4, 8e3, 0.0]}
    )
    figure = plots.draw_cost_against_yield(
        trade_off, winner=(2.5, 5e3, 9e3), target_ppm=1e4, is_met=is_met, title="A study"
    )
    lines = {line.get_label(): line.get_xydata().tolist() for line in figure.axes[0].get_lines()}
    assert lines["cheapest, predicted"] == [[0.0, 4.0], [8e3, 2.0], [9e4, 1.0]]
    assert lines[word] == [[5e3, 2.5]]
    assert lines["its confidence limit"] == [[5e3, 2.5], [9e3, 2.5]]
    assert "allowed 10,000 ppm" in [text.get_text() for text in figure.axes[0].texts]
