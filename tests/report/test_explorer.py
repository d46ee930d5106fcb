"""The explorer: its numbers are Python's, the study that it writes is the study that is set, and it refuses what jumps."""

import json
import re
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import small_study
from explorer_engine import Engine, data_of
from places import STUDIES

from tolmc import quantities, units
from tolmc.allocation import explored
from tolmc.allocation.explored import Explored, explore
from tolmc.allocation.offers import Curve, zone
from tolmc.allocation.study_table import read_plan
from tolmc.analysis.from_samples import first_order
from tolmc.analysis.surrogate import fit, training_box
from tolmc.mechanism import geometry
from tolmc.report.explorer.content import explorer_content
from tolmc.report.write import write_report
from tolmc.runs import directory as run_directory
from tolmc.runs import run as monte_carlo
from tolmc.statistics.rows import Rows
from tolmc.study.study import Study
from tolmc.tolerances.draw import from_unit, unit_points

pytestmark = pytest.mark.usefixtures("ready_pictures_throughout")

HINGE = Path(explored.__file__).parents[1] / "study" / "examples" / "hinge.toml"


def explored_run(study: Path, out: Path, **options) -> Path:
    """A run with its report, and the polynomials that `tolmc report` trains for it."""
    result = monte_carlo.run(study, out=out, workers=1, **options)
    (out / "surrogate.json").write_text(explore(result.study, result.summary).json())
    write_report(out)
    return out


@pytest.fixture(scope="module")
def directory(tmp_path_factory):
    folder = tmp_path_factory.mktemp("small")
    return explored_run(small_study.write(folder), folder / "run", samples=2048)


@pytest.fixture(scope="module")
def hinge(tmp_path_factory):
    return explored_run(HINGE, tmp_path_factory.mktemp("hinge") / "run")


@pytest.fixture(scope="module")
def engine(directory):
    return Engine(data_of(directory))


def moved(study: Study, name: str, nominal: float, width: float):
    """The study's tolerances with a dimension's zone elsewhere, by what Python has for that."""
    changed = []
    for d in study.tolerances.dimensions:
        if d.name == name:
            lower = nominal + (d.lower - d.nominal) * width / (d.upper - d.lower)
            follows = d.distribution.in_zone(d, lower, lower + width)
            ends = {"nominal": nominal, "lower": lower, "upper": lower + width, "toleranced_size": None}
            lots = {} if d.lot_sd is None else {"lot_sd": d.lot_sd * width / (d.upper - d.lower)}
            d = replace(d, **ends, **lots, distribution=follows)
        changed.append(d)
    return replace(study.tolerances, dimensions=tuple(changed))


class TestNumbers:
    CHANGES = (
        {},
        {"bearing_radius": (0.02002, 0.00015)},
        {"journal_radius": (9.98e-3, 2e-5)},
        {"half_length": (0.02004, 0.0001)},
    )

    @pytest.mark.parametrize("change", CHANGES, ids=lambda change: "".join(change) or "the study")
    def test_are_pythons(self, directory, engine, change):
        run = run_directory.read(directory)
        study = run.study()
        tolerances = study.tolerances
        for name, (nominal, width) in change.items():
            tolerances = moved(study, name, nominal, width)
        points = unit_points(tolerances, 2048, sampling="sobol", seed=study.seed)
        surrogate = Explored.of_json((directory / "surrogate.json").read_text()).surrogate
        outputs, found = engine.predicted(engine.sets(**change))
        expected = surrogate(from_unit(tolerances, points))
        assert set(outputs) == set(surrogate.outputs) >= {"tilt_angle", "contact_force_D_max"}
        for name, values in outputs.items():
            np.testing.assert_allclose(values, expected[name], rtol=1e-12, err_msg=name)

        def kept(times):
            return np.logical_and.reduce(
                [
                    expected[name] <= limits["max"] - times * surrogate.held_out[name]
                    for name, limits in study.specification.items()
                ]
            )

        def interval(events):
            size = Rows("sobol").effective_count(events)
            return wilson(events.mean() * size, size)

        assert found["value"] == kept(0).mean()
        assert found["low"] == pytest.approx(interval(kept(2))[0], rel=1e-12)
        assert found["high"] == pytest.approx(interval(kept(-2))[1], rel=1e-12)
        assert found["low"] < found["value"] < found["high"]

    def test_follow_true_motions(self, directory, engine):
        run = run_directory.read(directory)
        samples = run.read(rows=2048).to_pandas()
        outputs, found = engine.predicted(engine.sets())
        for name in ("tilt_angle", "contact_force_D_max", "contact_force_E_mean"):
            np.testing.assert_allclose(outputs[name], samples[name], rtol=1e-6)
        limits = run.study().specification
        inside = np.logical_and.reduce([samples[name] <= limit["max"] for name, limit in limits.items()])
        assert found["value"] == pytest.approx(inside.mean(), abs=2e-3)

    def test_statistics_are_numpys(self, engine):
        values = np.random.default_rng(3).normal(5.0, 0.1, 1000)
        usable = np.random.default_rng(4).integers(0, 2, 1000)
        kept = values[usable == 1]
        arrays = f"Float64Array.from({values.tolist()}), Uint8Array.from({usable.tolist()})"
        found = engine(f"arithmetic.summary({arrays})")
        assert found["n"] == len(kept)
        assert found["mean"] == pytest.approx(kept.mean(), rel=1e-14)
        assert found["sd"] == pytest.approx(kept.std(ddof=1), rel=1e-12)
        assert (found["min"], found["max"]) == (kept.min(), kept.max())
        counts = engine(f"arithmetic.histogram({arrays}, 4.8, 5.2, 16)")
        assert counts == np.histogram(kept[(kept >= 4.8) & (kept < 5.2)], bins=16, range=(4.8, 5.2))[0].tolist()

    def test_drivers_are_first_order_indices(self, directory, engine):
        samples = run_directory.read(directory).read(rows=2048).to_pandas()
        outputs, _ = engine.predicted(engine.sets())
        inputs = [d["name"] for d in engine.data["dimensions"]]
        table = samples[inputs].assign(**outputs)
        expected = first_order(table, inputs=inputs, outputs=list(outputs), sampling="sobol")
        found = engine(
            f"(({{ outputs, usable }}) => outputs.map((x) => kept.cells.map((cell) => arithmetic.firstOrder(x, cell, "
            f"kept.classes, usable))))(arithmetic.predicted(kept, {json.dumps(engine.sets())}))"
        )
        for name, shares in zip(engine.names, found, strict=True):
            np.testing.assert_allclose(shares, expected.loc[name, "first"].to_numpy(), rtol=1e-8, atol=1e-11)

    def test_geometry_is_closed(self):
        engine = Engine()
        for R, r, L in ((0.02, 0.01, 0.02), (0.0040225, 0.0039575, 0.03), (0.02, 0.02 - 1e-9, 0.5)):
            tilt = engine(f"arithmetic.tiltAngle({R}, {r}, {L})")
            assert tilt == pytest.approx(geometry.tilt_angle(R, r, L), rel=4e-16)
            radius = engine(f"arithmetic.effectiveRadius({R}, {r}, {L})")
            assert radius == pytest.approx(geometry.effective_radius(R, r, L), rel=4e-16)
            assert np.tan(tilt) == pytest.approx((R - r / np.cos(tilt)) / L, rel=1e-7)

    def test_parts_without_clearance_keep_no_limit(self, hinge):
        engine = Engine(data_of(hinge))
        sets = engine.sets(journal_radius=(0.0040225, 9e-5))
        found = engine(f"arithmetic.predicted(kept, {json.dumps(sets)})")
        bearing, journal = (np.array(found["columns"][j]) for j in (0, 1))
        assert found["usable"] == (bearing > journal).astype(int).tolist()
        assert 0 < sum(found["usable"]) < len(bearing)
        assert found["found"]["value"] <= np.mean(found["usable"])

    def test_bounds_widen_with_the_held_out_error(self, engine):
        data = {**engine.data, "outputs": [{**o, "margin": 0.2 * o["sd"]} for o in engine.data["outputs"]]}
        rough = Engine(data)
        fine, wide = (e.predicted(e.sets())[1] for e in (engine, rough))
        assert wide["value"] == fine["value"]
        assert wide["low"] < fine["low"] and fine["high"] < wide["high"]


def wilson(count, total, z=1.959963984540054):
    share = count / total
    middle, root = share + z * z / (2 * total), z * np.sqrt(share * (1 - share) / total + (z / (2 * total)) ** 2)
    return (middle - root) / (1 + z * z / total), (middle + root) / (1 + z * z / total)


class TestCost:
    def test_is_the_allocations(self):
        engine = Engine()
        curve = Curve("half_length", 1e-5, 4e-4, at=1e-4, variable=1.2, fixed=0.8, law="exponential")
        choice = {name: getattr(curve, name) for name in ("law", "fixed", "variable", "at")}
        for law in ("reciprocal", "reciprocal-square", "exponential"):
            of_law = replace(curve, law=law)
            found = engine(f"arithmetic.cost({json.dumps(choice | {'law': law})}, 2.5e-4)")
            assert found == pytest.approx(of_law.cost(2.5e-4), rel=1e-14)

    @pytest.mark.parametrize(("width", "cost"), [(9e-6, None), (1e-5, 9.0), (1.5e-5, 9.0), (2e-5, 5.5), (1.0, 5.5)])
    def test_of_a_width_between_grades_is_that_of_the_finer_one(self, width, cost):
        choice = {"widths": [1e-5, 2e-5], "costs": [9.0, 5.5]}
        assert Engine()(f"arithmetic.cost({json.dumps(choice)}, {width})") == cost

    def test_zones_on_offer_lie_where_the_allocation_puts_them(self):
        engine, study = engine_of((STUDIES / "paper_joint_allocation.toml").read_text(encoding="utf-8"))
        by_name = {d.name: d for d in study.tolerances.dimensions}
        for choice, shown in zip(read_plan(study).choices, engine.data["choices"], strict=True):
            d = by_name[choice.name]
            for option in shown["options"]:
                lower, upper = zone(d, option["width"], choice.anchor)
                nominal = d.nominal + shown["slope"] * (option["width"] - (d.upper - d.lower))
                share = (d.nominal - d.lower) / (d.upper - d.lower)
                assert nominal - share * option["width"] == pytest.approx(lower, rel=1e-12)
                assert nominal + (1 - share) * option["width"] == pytest.approx(upper, rel=1e-12)
        assert [len(shown["options"]) for shown in engine.data["choices"]] == [6, 6, 9]


BODY = """
[body]
mass = "0.5 kg"
inertia = [4.08e-4, 4.08e-4, 1.2e-4]
[motion]
alpha = 0
beta = 1
duration = 1
[monte_carlo]
samples = 320
outputs = ["tilt_angle"]
"""
DIMENSIONS = {
    "as drawn": 'bearing_diameter = "40 ±0.1 mm"  # bore\njournal_diameter = "20 +0/-0.06 mm"\nbearing_length = "40 ±0.2 mm"',
    "model": 'bearing_radius = { nominal = "20 mm", tolerance = "0.05 mm" }\n'
    'journal_radius = { lower = "9.97 mm", upper = "10 mm", distribution = "triangular", mode = "9.98 mm" }\n'
    'half_length = { nominal = "20 mm", tolerance = "0.1 mm", mean = "20.02 mm", cp = 1.2 }',
    "classes": 'bearing_diameter = "⌀40 H9"\njournal_radius = { diameter = "39.5 f7", distribution = "uniform" }\n'
    'half_length = "20 mm"',
    "a fit": 'fit = "40 H9/d9"  # both\njournal_diameter = { cp = 1.3 }\nbearing_length = "40 mm"',
    "scipy": 'bearing_radius = { nominal = "20 mm", tolerance = "0.05 mm", distribution = "norm", truncated = true, '
    'arguments = { loc = "20.01 mm", scale = "0.02 mm" } }\njournal_radius = "10 mm"\nhalf_length = "20 mm"',
    "tables": 'half_length = "20 mm"\njournal_radius = "10 mm"\n[dimensions.bearing_radius]\n'
    'nominal = "20 mm"\ntolerance = "0.05 mm"\ndistribution = "uniform"',
    "lots": 'lot_size = 4\nbearing_radius = { nominal = "20 mm", tolerance = "0.05 mm", lot_sd = "0.005 mm" }\n'
    'journal_radius = "10 mm"\nhalf_length = "20 mm"',
    "others": 'bearing_radius = "20 ±0.05 mm"\njournal_radius = "10 mm"\nhalf_length = "20 mm"\n'
    'mass = { tolerance = "5 g", distribution = "uniform" }',
}  # fmt: skip


REQUIREMENTS = {
    "lines": '[specification]\ntarget = "99 %"  # of a lot\ntilt_angle = { max = "26 deg" }  # seen',
    "a table": '[specification]\ntarget = 0.99\n[specification.tilt_angle]\nmax = "26 deg"',
    "a dotted key": '[specification]\ntarget = 0.99\ntilt_angle.max = "26 deg"',
}


def engine_of(text: str) -> tuple[Engine, Study]:
    """The explorer of a study of which no motion is computed: the tilt is the sum of its dimensions."""
    study = load(text)
    study = replace(study, source=text)

    def model(inputs):
        return pd.DataFrame({"tilt_angle": inputs.sum(axis=1)})

    surrogate = fit(model, training_box(study.tolerances), ["tilt_angle"], motions=64)
    samples = from_unit(study.tolerances, unit_points(study.tolerances, 64, sampling="sobol", seed=1))
    summary = pd.DataFrame({"sd": [1e-3]}, index=["tilt_angle"])
    content = explorer_content(study, Explored(surrogate, {}), samples, summary, 0.99)
    return Engine(json.loads(content["data"])), study


def study_with(dimensions: str) -> str:
    return f"title = '</script>'\n[dimensions]\n{dimensions}\n{BODY}"


def load(text: str) -> Study:
    return Study.from_dict(tomllib.loads(text))


class TestStudyText:
    @pytest.mark.parametrize("kind", DIMENSIONS)
    def test_says_what_is_set(self, kind):
        engine, study = engine_of(study_with(DIMENSIONS[kind]))
        assert load(engine.study(engine.sets())).tolerances == study.tolerances
        for d in study.tolerances.varied:
            width = d.upper - d.lower
            for nominal, wide in ((d.nominal, 0.7 * width), (d.nominal + 0.3 * width, 1.4 * width)):
                found = load(engine.study(engine.sets(**{d.name: (nominal, wide)}))).tolerances
                expected = moved(study, d.name, nominal, wide)
                points = unit_points(expected, 64, sampling="sobol", seed=1)
                np.testing.assert_allclose(from_unit(found, points), from_unit(expected, points), rtol=1e-9)
                assert found.lot_size == expected.lot_size
                np.testing.assert_allclose(*([o.between_lots for o in t.varied] for t in (found, expected)), rtol=1e-9)

    def test_keeps_comments_and_all_other_lines(self):
        engine, study = engine_of(study_with(DIMENSIONS["as drawn"]))
        assert engine.study(engine.sets()) == study.source
        found = engine.study(engine.sets(bearing_radius=(0.02001, 0.0002)))
        assert 'bearing_diameter = "40.02 ±0.2 mm"  # bore\n' in found
        lines = study.source.split("\n")
        assert [a for a, b in zip(found.split("\n"), lines, strict=True) if a != b] == [
            'bearing_diameter = "40.02 ±0.2 mm"  # bore'
        ]

    def test_keeps_the_fit_while_both_have_a_class(self):
        engine, _ = engine_of(study_with(DIMENSIONS["a fit"]))
        found = engine.study(engine.sets(journal_radius="40 c11"))
        assert 'fit = "40 H9/c11"  # both' in found
        assert "journal_diameter = { cp = 1.3 }" in found
        apart = engine.study(engine.sets(journal_radius=(0.0199, 3e-5)))
        assert "fit" not in apart and 'bearing_diameter = "40 H9"' in apart
        assert 'journal_diameter = { size = "39.8 ±0.03 mm", cp = 1.3 }' in apart

    def test_of_a_balance_grade(self):
        rotor = 'bearing_radius = "20 mm"\njournal_radius = "10 mm"\nhalf_length = "20 mm"\nunbalance = "G6.3"'
        engine, _ = engine_of(study_with(rotor).replace("beta = 1", 'beta = 1\nspin_rate = "300 rad/s"'))
        d = engine.data["dimensions"][0]
        found = engine.study(engine.sets(center_of_mass_x=(0.0, 2 * d["upper"])))
        assert 'unbalance = "G12.6"' in found
        off = load(engine.study(engine.sets(center_of_mass_x=(1e-5, d["upper"])))).tolerances.varied[0]
        assert (off.lower, off.upper) == pytest.approx((1e-5, 1e-5 + d["upper"]))

    @pytest.mark.parametrize("written", REQUIREMENTS)
    def test_says_which_limits_are_set(self, written):
        engine, study = engine_of(study_with(DIMENSIONS["as drawn"]) + REQUIREMENTS[written])
        own = study.specification["tilt_angle"]["max"]
        for low, high in ((None, 0.45), (0.1, own), (0.2, None), (None, None)):
            asked = {"target": 0.97, "ends": [{"min": low, "max": high}]}
            found = load(engine.study(engine.sets(bearing_radius=(0.02001, 0.0002)), asked))
            given = {side: limit for side, limit in (("min", low), ("max", high)) if limit is not None}
            assert found.target == 0.97
            assert found.specification == ({"tilt_angle": pytest.approx(given)} if given else {})
            assert found.tolerances.dimensions[0].upper == pytest.approx(0.02011)

    def test_keeps_the_limits_lines_and_comments(self):
        engine, study = engine_of(study_with(DIMENSIONS["as drawn"]) + REQUIREMENTS["lines"])
        own = {"target": 0.99, "ends": [{"min": None, "max": study.specification["tilt_angle"]["max"]}]}
        assert engine.study(engine.sets(), own) == study.source
        found = engine.study(engine.sets(), {"target": 0.985, "ends": [{"min": None, "max": np.radians(25.5)}]})
        assert found.endswith('target = "98.5 %"  # of a lot\ntilt_angle = { max = "25.5 deg" }  # seen')

    def test_gives_limits_to_a_study_without(self):
        engine, _ = engine_of(study_with(DIMENSIONS["as drawn"]))
        found = load(engine.study(engine.sets(), {"target": 0.97, "ends": [{"min": None, "max": np.radians(25)}]}))
        assert found.target == 0.97 and found.specification == {"tilt_angle": {"max": pytest.approx(np.radians(25))}}

    @pytest.mark.parametrize("kind", [kind for kind in quantities.KINDS if not kind.startswith("temperature")])
    def test_units_of_limits_are_read(self, kind):
        name = next((row.name for row in quantities.OUTPUT_ROWS if row.kind == kind), None)
        if name is None:
            return
        output = {"name": name, "unit": quantities.shown(name)[0], "factor": quantities.shown(name)[1]}
        data = {"source": "", "slots": [], "target": 0.9, "requirements": {"lines": {}, "after": None}}
        data["outputs"] = [output | {"min": None, "max": None}]
        asked = {"target": 0.9, "ends": [{"min": 0.1234, "max": None}]}
        text = Engine()(f"studyText.study({json.dumps(data)}, {{}}, {{}}, {json.dumps(asked)})")
        written = tomllib.loads(text)["specification"][name]["min"]
        assert units.read(written, quantities.unit(name)) == pytest.approx(0.1234, rel=1e-11)

    @pytest.mark.parametrize(
        ("value", "text"),
        [(0.1 + 0.2, "0.3"), (1e-7, "0.0000001"), (-2.5e-8, "-0.000000025"), (1.5e20, "150000000000000000000")],
    )
    def test_numbers_have_no_power_of_ten(self, value, text):
        assert Engine()(f"studyText.decimal({value})") == text


class TestPage:
    def test_is_small_and_closed(self, directory):
        page = (directory / "report.html").read_text(encoding="utf-8")
        assert len(page.encode()) <= 1_500_000
        assert page.count("<script") == page.count("</script>") == 6
        assert re.search('<section id="explorer" hidden>', page)
        scripts = "".join(re.findall("<script>(.*?)</script>", page, re.DOTALL))
        scripts = scripts.replace("http://www.w3.org/2000/svg", "")  # a name, never fetched
        assert not re.search(r"https?:|import\(|fetch\(|XMLHttpRequest", scripts)

    def test_of_a_title_that_would_end_a_script(self, tmp_path):
        title = ('title = "A small study"', "title = '</script><script>alert(1)</script>'")
        study = small_study.write(tmp_path, *small_study.GEOMETRY, title)
        page = (explored_run(study, tmp_path / "run") / "report.html").read_text(encoding="utf-8")
        assert page.count("<script") == page.count("</script>") == 6
        assert data_of(tmp_path / "run")["source"] == study.read_text(encoding="utf-8")

    def test_gives_no_verdict_where_the_section_turns_it(self, directory):
        study = run_directory.read(directory).study()
        surrogate = Explored.of_json((directory / "surrogate.json").read_text()).surrogate
        samples = run_directory.read(directory).read(rows=64).to_pandas()
        summary = pd.read_csv(directory / "summary.csv").set_index("output")
        given = study, Explored(surrogate, {}), samples, summary, 0.99
        words = "not decided: the section matters (circle 3.21 %, exact 100 %)"
        turned, same = (explorer_content(*given, of_section=text) for text in (words, ""))
        assert turned["section"] == "circle 3.21 %, exact 100 %" and same["section"] == ""
        assert [json.loads(content["data"])["undecided"] for content in (turned, same)] == [True, False]

    def test_is_absent_without_polynomials(self, directory, tmp_path):
        monte_carlo.run(small_study.write(tmp_path, *small_study.GEOMETRY), out=tmp_path / "run", workers=1)
        write_report(tmp_path / "run")
        assert "<script" not in (tmp_path / "run" / "report.html").read_text(encoding="utf-8")

    def test_of_damaged_polynomials_is_refused(self, tmp_path):
        monte_carlo.run(small_study.write(tmp_path, *small_study.GEOMETRY), out=tmp_path / "run", workers=1)
        (tmp_path / "run" / "surrogate.json").write_text("{}")
        with pytest.raises(ValueError, match=r"surrogate\.json is damaged"):
            write_report(tmp_path / "run")


class TestRefusals:
    """By a model in place of the motions."""

    OUTPUTS = ("tilt_angle", "contact_force_D_max")

    def explored(self, tmp_path, monkeypatch, answers, *changes) -> Explored:
        study = monte_carlo.load_study(small_study.write(tmp_path, *changes))

        def study_model(study, outputs, *, box=None):
            def model(inputs):
                x = (inputs["half_length"].to_numpy() - 0.02) / 1e-4
                found = pd.DataFrame({"tilt_angle": 0.4 + 0.1 * x, "contact_force_D_max": 5.0 + x, "status": "ok"})
                return answers(found, x)[[*outputs, "status"]]

            return model

        monkeypatch.setattr(explored, "study_model", study_model)
        summary = pd.DataFrame(
            {"sd": [0.03, 0.6], "min": [0.3, 4.0], "max": [0.5, 6.0]}, index=pd.Index(self.OUTPUTS, name="output")
        )
        return explore(study, summary)

    def test_of_a_smooth_study_there_are_none(self, tmp_path, monkeypatch):
        found = self.explored(tmp_path, monkeypatch, lambda table, x: table)
        assert found.refused == {} and found.surrogate.outputs == self.OUTPUTS
        own = training_box(monte_carlo.load_study(tmp_path / "small.toml").tolerances)
        for name, (low, high) in own.items():
            reach = found.surrogate.box[name]
            assert reach[0] < low and high < reach[1]

    @pytest.mark.parametrize(
        ("status", "words"),
        [("contact lost", "contact is lost and what follows is cut off"), ("diverged", "not be computed")],
    )
    def test_of_motions_that_end(self, tmp_path, monkeypatch, status, words):
        def answers(table, x):
            table.loc[x > 0.9, "status"] = status
            return table

        found = self.explored(tmp_path, monkeypatch, answers)
        assert found.surrogate.outputs == ("tilt_angle",)
        assert set(found.refused) == {"contact_force_D_max"} and words in found.refused["contact_force_D_max"]

    def test_of_an_output_that_jumps(self, tmp_path, monkeypatch):
        def answers(table, x):
            return table.assign(contact_force_D_max=5.0 + np.sin(400 * x))

        found = self.explored(tmp_path, monkeypatch, answers)
        assert found.surrogate.outputs == ("tilt_angle",)
        assert "as where an output jumps" in found.refused["contact_force_D_max"]

    def test_of_a_wider_box_leave_the_narrower_one(self, tmp_path, monkeypatch):
        def answers(table, x):
            table.loc[np.abs(x) > 1.2, "status"] = "contact lost"
            return table

        found = self.explored(tmp_path, monkeypatch, answers)
        assert found.refused == {} and set(found.surrogate.outputs) == set(self.OUTPUTS)
        low, high = found.surrogate.box["half_length"]
        assert high - low == pytest.approx(2e-4, rel=1e-3)

    def test_are_sentences_of_the_report(self, tmp_path):
        monte_carlo.run(small_study.write(tmp_path, *small_study.GEOMETRY), out=tmp_path / "run", workers=1)
        text = Explored(None, {"tilt_angle": "it jumps", "effective_radius": "it jumps"}).json()
        (tmp_path / "run" / "surrogate.json").write_text(text)
        write_report(tmp_path / "run")
        page = (tmp_path / "run" / "report.html").read_text(encoding="utf-8")
        assert "Not explored: tilt angle ψ and effective radius r, because it jumps." in page
        assert "<script" not in page


def test_boxes_leave_a_clearance(hinge):
    study = run_directory.read(hinge).study()
    box = Explored.of_json((hinge / "surrogate.json").read_text()).surrogate.box
    own = training_box(study.tolerances)
    assert box["bearing_radius"][0] > box["journal_radius"][1] > own["journal_radius"][1]
    assert box["journal_radius"][0] < 3.9e-3  # reaches to other letters than d
