import math
import tomllib

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from places import STUDIES
from small_study import TEXT, write

from tolmc.mechanism.scene import Body
from tolmc.study.file import load_study
from tolmc.study.study import Study, StudyError, Until
from tolmc.tolerances.distributions import Beta, Measured, Normal, Scipy, Triangular, Uniform

BODY = "inertia = [4.08e-4, 4.08e-4, 1.2e-4]"
HALF_LENGTH = 'half_length    = { nominal = "20 mm", tolerance = "0.1 mm", distribution = "uniform" }'


def dimension(study, name):
    return next(d for d in study.tolerances.dimensions if d.name == name)


def half_length(folder, table):
    return dimension(load_study(write(folder, (HALF_LENGTH, f"half_length = {table}"))), "half_length")


def complaint(folder, *changes):
    with pytest.raises(StudyError) as error:
        load_study(write(folder, *changes))
    return str(error.value)


def test_everything_in_a_file_arrives(tmp_path):
    study = load_study(write(tmp_path))
    joint = study.scene.joint
    assert (study.name, study.title) == ("small", "A small study")
    assert (joint.bearing_radius, joint.journal_radius, joint.half_length) == (0.02, 0.01, 0.02)
    assert joint.section == "circle"
    assert study.scene.body == Body(0.5, (0, 0, 0.004), (4.08e-4, 4.08e-4, 1.2e-4))
    assert study.scene.loads.gravity == (0, -9.81, 0)
    assert study.scene.loads.force is None
    motion = study.scene.motion
    assert motion.alpha == pytest.approx(math.radians(-110), rel=1e-15)
    assert (motion.alpha_rate, motion.beta_rate, motion.spin_rate) == (2, -3, 80)
    assert study.scene.duration == 0.1
    assert (study.samples, study.sampling, study.seed, study.workers) == (3000, "sobol", 7, 2)
    assert (study.step, study.accuracy, study.method, study.formulation) == (None, None, "rk8", "slope")
    assert (study.on_contact_loss, study.project_energy, study.outputs) == ("stop", False, None)
    assert study.specification["tilt_angle"] == {"max": pytest.approx(math.radians(24.4))}
    assert study.source == TEXT


def test_dimensions_of_the_example(tmp_path):
    study = load_study(write(tmp_path))
    bearing, journal, half = study.tolerances.dimensions
    assert (bearing.lower, bearing.upper) == pytest.approx((0.01995, 0.02005))
    assert (journal.lower, journal.upper, journal.nominal) == pytest.approx((0.00997, 0.01, 0.01))
    assert bearing.distribution == Normal(truncated=True)
    assert half.distribution == Uniform()


@pytest.mark.parametrize(
    ("table", "limits", "distribution"),
    [
        ('"20 mm"', (0.02, 0.02), Normal()),
        ("0.02", (0.02, 0.02), Normal()),
        ('{ lower = "19 mm", upper = "21 mm" }', (0.019, 0.021), Normal()),
        ('{ nominal = "20 mm", tolerance = 1e-3, distribution = "normal" }', (0.019, 0.021), Normal(truncated=False)),
        (
            '{ nominal = "20 mm", tolerance = 1e-3, cp = 1.33, cpk = 1, shift = "lower" }',
            (0.019, 0.021),
            Normal(1.33, 1, shift="lower"),
        ),
        (
            '{ nominal = "20 mm", tolerance = 1e-3, mean = "nominal", cpk = 1.1 }',
            (0.019, 0.021),
            Normal(cpk=1.1, mean="nominal"),
        ),
        (
            '{ nominal = "20 mm", tolerance = 1e-3, distribution = "triangular", mode = "19.5 mm" }',
            (0.019, 0.021),
            Triangular(0.0195),
        ),
        (
            '{ nominal = "20 mm", tolerance = 1e-3, distribution = "beta", alpha = 2, beta = 3 }',
            (0.019, 0.021),
            Beta(2, 3),
        ),
        (
            '{ nominal = "20 mm", tolerance = 1e-3, distribution = "norm", truncated = true,'
            ' arguments = { loc = "20 mm", scale = "0.5 mm" } }',
            (0.019, 0.021),
            Scipy("norm", {"loc": 0.02, "scale": 5e-4}, truncated=True),
        ),
    ],
)
def test_dimensions_as_engineers_write_them(tmp_path, table, limits, distribution):
    found = half_length(tmp_path, table)
    assert (found.nominal, found.lower, found.upper) == pytest.approx((0.02, *limits))
    assert found.distribution == distribution


def test_fit_gives_both_radii_their_limits(tmp_path):
    first, second = (line for line in TEXT.splitlines() if "_radius " in line)
    study = load_study(write(tmp_path, (first, 'fit = "40 H7/d9"'), (second, "journal_radius = { cp = 1.33 }")))
    bearing, journal = dimension(study, "bearing_radius"), dimension(study, "journal_radius")
    assert (bearing.lower, bearing.upper) == pytest.approx((20e-3, 20.0125e-3))
    assert (journal.lower, journal.upper) == pytest.approx((19.929e-3, 19.96e-3))
    assert study.scene.joint.bearing_radius == pytest.approx(20.00625e-3)
    assert journal.distribution == Normal(1.33)
    assert (bearing.toleranced_size, journal.toleranced_size) == ("40 H7", "40 d9")


def test_a_class_of_the_diameter_gives_a_radius_its_limits(tmp_path):
    study = load_study(write(tmp_path, ('nominal = "20 mm", tolerance = "0.05 mm"', 'diameter = "40 H7"')))
    bearing = dimension(study, "bearing_radius")
    assert (bearing.upper, bearing.toleranced_size) == (pytest.approx(20.0125e-3), "40 H7")


def test_any_other_scalar_may_vary_around_its_own_nominal(tmp_path):
    study = load_study(
        write(
            tmp_path, ("[body]", 'mass = { tolerance = "5 g" }\nspin_rate = { lower = 70, upper = "900 rpm" }\n[body]')
        )
    )
    mass, spin = dimension(study, "mass"), dimension(study, "spin_rate")
    assert (mass.nominal, mass.lower, mass.upper) == pytest.approx((0.5, 0.495, 0.505))
    assert (spin.nominal, spin.lower, spin.upper) == pytest.approx((80, 70, 30 * math.pi))


def test_measured_values_belong_to_the_study(tmp_path):
    (tmp_path / "measured").mkdir()
    data = tmp_path / "measured" / "rings.csv"
    data.write_text("part, diameter\n1, 39.98\n2, 40.01\n3, 40.02\n")
    table = '{ data = "measured/rings.csv", column = "diameter", unit = "0.5 mm" }'
    change = ('{ nominal = "20 mm", tolerance = "0.05 mm" }', table)
    study = load_study(write(tmp_path, change))
    bearing = dimension(study, "bearing_radius")
    assert isinstance(bearing.distribution, Measured)
    np.testing.assert_allclose(bearing.distribution.values, [0.01999, 0.020005, 0.02001])
    assert study.scene.joint.bearing_radius == pytest.approx(np.mean([0.01999, 0.020005, 0.02001]))
    assert study.data_files == {"measured/rings.csv": data.read_bytes()}
    data.write_text("part, diameter\n1, 39.98\n2, 40.01\n3, 40.03\n")
    assert load_study(write(tmp_path, change)).sha256 != study.sha256


def test_correlation_and_lots(tmp_path):
    study = load_study(
        write(
            tmp_path,
            ('tolerance = "0.05 mm"', 'tolerance = "0.05 mm", lot_share = 0.4'),
            ("[body]", "lot_size = 200\n[correlation]\nbearing_radius.journal_radius = 0.5\n[body]"),
        )
    )
    assert np.array(study.tolerances.correlation)[0, 1] == 0.5
    assert study.tolerances.lot_size == 200
    assert dimension(study, "bearing_radius").lot_share == 0.4


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (
            'solid_cylinder = { radius = "10 mm", length = "60 mm" }',
            Body.solid_cylinder(0.5, 0.01, 0.06, (0, 0, 0.004)),
        ),
        (
            'centroidal_inertia = ["400 kg mm^2", 4e-4, 1.2e-4]',
            Body.from_centroidal(0.5, (0, 0, 0.004), (4e-4, 4e-4, 1.2e-4)),
        ),
        (
            "inertia = [[4.08e-4, 0, 1e-6], [0, 4.08e-4, 0], [1e-6, 0, 1.2e-4]]",
            Body(0.5, (0, 0, 0.004), [[4.08e-4, 0, 1e-6], [0, 4.08e-4, 0], [1e-6, 0, 1.2e-4]]),
        ),
    ],
)
def test_ways_to_give_the_inertia(tmp_path, text, expected):
    assert load_study(write(tmp_path, (BODY, text))).scene.body == expected


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (
            ('mass = "0.5 kg"', 'mas = "0.5 kg"'),
            ["[body] mass is missing", "mas = '0.5 kg' is unknown; did you mean 'mass'"],
        ),
        (('mass = "0.5 kg"', 'mass = "0.5 m"'), ["[body] mass = '0.5 m'", "a mass", "kg"]),
        (('mass = "0.5 kg"', "mass = -1"), ["[body] mass = -1", "> 0"]),
        (('"0.05 mm"', '"-0.05 mm"'), ["bearing_radius.tolerance = '-0.05 mm'", "[lower, upper]"]),
        (("tolerance", "tolerence"), ["bearing_radius.tolerence", "did you mean 'tolerance'"]),
        (('nominal = "20 mm", tolerance = "0.05 mm"', 'nominal = "9 mm"'), ["journal_radius = 0.01 m", "0.009"]),
        (('"sobol"', '"sobl"'), ["sampling = 'sobl'", "did you mean 'sobol'", "latin_hypercube"]),
        (("samples = 3000", "samples = 0"), ["samples = 0", "1 to 1000000000"]),
        (("samples = 3000", "samples = 1.5"), ["samples = 1.5", "whole number"]),
        (("samples = 3000", "samples = inf"), ["samples = inf", "whole number"]),
        (("samples = 3000", 'samples = "3000"'), ["samples = '3000'", "whole number", "without quotes"]),
        (("seed = 7", "seed = true"), ["seed = true", "whole number"]),
        (("samples = 3000", "sample = 3000"), ["[monte_carlo] sample = 3000 is unknown", "did you mean 'samples'"]),
        (("[body]", 'masss = "5 g"\n[body]'), ["[dimensions] masss = '5 g' is unknown", "did you mean 'mass'"]),
        (("workers = 2", 'workers = 2\nstep = "-1 ms"'), ["step = '-1 ms'", "> 0"]),
        (("workers = 2", 'workers = 2\nproject_energy = "yes"'), ["project_energy = 'yes'", "true or false"]),
        (("workers = 2", 'workers = 2\noutputs = ["tilt"]'), ["outputs.0 = 'tilt'", "tilt_angle"]),
        (("workers = 2", 'workers = 2\noutputs = ["tilt_angle"]'), ["contact_force_D_max", "outputs"]),
        (("[loads]", "[load]"), ["load is unknown", "did you mean 'loads'"]),
        (("[loads]", '[model]\nsection = "exakt"\n[loads]'), ["[model] section = 'exakt'", "did you mean 'exact'"]),
        (("[0, -9.81, 0]", "[0, -9.81]"), ["[loads] gravity", "[x, y, z]"]),
        (('duration = "0.1 s"', ""), ["[motion] duration is missing", "1 s"]),
        (("tilt_angle =", "tilt_angl ="), ["tilt_angl", "did you mean 'tilt_angle'"]),
        (('{ max = "24.4 deg" }', "{ }"), ["tilt_angle", "min, max or both"]),
        (('{ max = "24.4 deg" }', "{ min = 2, max = 1 }"), ["min = 2 is above max = 1"]),
        (('{ max = "24.4 deg" }', "25"), ["tilt_angle = 25", "a table"]),
        (('"uniform"', '"unifrm"'), ["distribution = 'unifrm'", "did you mean 'uniform'"]),
        (('"uniform"', '"norm"'), ["half_length", "arguments"]),
        (('"uniform"', '"uniform", cp = 1'), ["half_length.cp", "'uniform'"]),
        (('"uniform"', '"beta"'), ["half_length", "alpha"]),
        (('tolerance = "0.1 mm", distribution', "distribution"), ["half_length has no tolerance", "tolerance"]),
        (('"uniform"', '"uniform", lower = 1'), ["only one limit"]),
        (('"uniform"', '"uniform", lower = 1, upper = 2'), ["lower and tolerance both set"]),
        (('"uniform"', '"data", data = "../x.csv", column = "d", unit = "mm"'), ["'../x.csv'", "study's folder"]),
        (('"uniform"', '"data", data = "x.csv", column = "d", unit = "mm"'), ["x.csv", "cannot be read"]),
        (("[body]", 'mass = "5 g"\n[body]'), ["mass.nominal = '5 g'", "Leave it out"]),
        (("[body]", 'fit = "40 H7/d9"\n[body]'), ["tolerance and fit both set"]),
        (("[body]", 'fit = "40 H7"\n[body]'), ["'40 H7'", "40 H7/d9"]),
        (("[body]", "[correlation]\nbearing_radius.mass = 0.1\n[body]"), ["bearing_radius.mass"]),
        (("[body]", "[correlation]\nbearing_radius.half_length = 1.5\n[body]"), ["1.5", "-1 to 1"]),
        ((BODY, ""), ["no inertia", "solid_cylinder"]),
        ((BODY, "inertia = [1, 1, 3]"), ["[body]", "sum of the other two"]),
        ((BODY, "solid_cylinder = { radius = 1, lenght = 2 }"), ["solid_cylinder.lenght", "'length'"]),
        (("[body]", "[body"), ["no valid TOML", "line"]),
        (('title = "A small study"', "title = 3"), ["title = 3", "text in quotes"]),
    ],
)
def test_a_bad_field_is_named_with_value_and_remedy(tmp_path, change, words):
    message = complaint(tmp_path, change)
    assert str(tmp_path / "small.toml") in message
    for word in words:
        assert word in message


UNTIL = '[monte_carlo]\nuntil = { output = "contact_force_D_max", statistic = "q99.865", width = "10 mN" }'
YIELD = '[monte_carlo]\nuntil = { statistic = "yield", width = 0.01 }'


@pytest.mark.parametrize(
    ("text", "until"),
    [
        (UNTIL, Until("q99.865", 0.01, "contact_force_D_max")),
        (UNTIL.replace("q99.865", "q5"), Until("q5", 0.01, "contact_force_D_max")),
        (UNTIL.replace("q99.865", "mean"), Until("mean", 0.01, "contact_force_D_max")),
        (YIELD.replace("0.01", '"1 %"'), Until("yield", 0.01)),
    ],
)
def test_sampling_may_end_with_an_interval(tmp_path, text, until):
    study = load_study(write(tmp_path, ("[monte_carlo]", text)))
    assert study.until == until
    assert study.replaced(seed=8, workers=1).until == until
    assert study.replaced(samples=50).until is None
    assert load_study(write(tmp_path)).until is None


def test_the_level_of_a_quantile_is_that_of_its_name():
    assert Until("q99.865", 1.0, "tilt_max").level == pytest.approx(0.99865, rel=1e-15)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ((UNTIL, "[monte_carlo]\nuntil = 5"), ["until = 5", "a table"]),
        ((UNTIL, "[monte_carlo]\nuntil = { }"), ["until.statistic is missing", "q99.865", "until.width is missing"]),
        (("q99.865", "median"), ["until.statistic = 'median'", "quantile in percent"]),
        (("q99.865", "q0.0"), ["until.statistic = 'q0.0'", "quantile in percent"]),
        (("q99.865", "q100"), ["until.statistic = 'q100'", "quantile in percent"]),
        (("q99.865", "yield"), ["until.output = 'contact_force_D_max'", "leave output out"]),
        (("10 mN", "10 mm"), ["until.width = '10 mm'", "not that of a force"]),
        (("10 mN", "-1 N"), ["until.width = '-1 N'", "> 0"]),
        (('"contact_force_D_max", s', '"contact_force", s'), ["until.output = 'contact_force'", "did you mean"]),
        (("until = { output", "until = { outptu"), ["until.outptu = 'contact_force_D_max'", "did you mean 'output'"]),
        (('output = "contact_force_D_max", s', "s"), ["until.output is missing", "'q99.865'"]),
        (('"sobol"', '"latin_hypercube"'), ["until", "Latin hypercube", 'use sampling = "sobol"']),
        (("samples = 3000", "samples = 1"), ["samples = 1", "largest number"]),
    ],
)
def test_a_bad_until_is_named_with_value_and_remedy(tmp_path, change, words):
    message = complaint(tmp_path, ("[monte_carlo]", UNTIL), change)
    for word in words:
        assert word in message


def test_until_agrees_with_the_rest_of_the_study(tmp_path):
    limits = ('tilt_angle = { max = "24.4 deg" }\n', ""), ('contact_force_D_max = { max = "4.5 N" }\n', "")
    assert "add limits under [specification]" in complaint(tmp_path, *limits, ("[monte_carlo]", YIELD))
    outputs = 'outputs = ["tilt_angle"]'
    message = complaint(tmp_path, limits[1], ("[monte_carlo]", f"{UNTIL}\n{outputs}"))
    assert "until.output = 'contact_force_D_max' is not among" in message


def test_files_that_are_no_studies(tmp_path):
    missing = tmp_path / "missing.toml"
    with pytest.raises(StudyError, match="cannot be read"):
        load_study(missing)
    with pytest.raises(StudyError, match="cannot be read"):
        load_study(tmp_path)
    binary = tmp_path / "binary.toml"
    binary.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(StudyError, match="UTF-8"):
        load_study(binary)
    for text in ("a = " + "[" * 5000, "a = " + "9" * 5000, "a = 1\x00"):
        binary.write_text(text)
        with pytest.raises(StudyError, match="no valid TOML"):
            load_study(binary)


def test_replaced_checks_what_it_is_given(tmp_path):
    study = load_study(write(tmp_path))
    changed = study.replaced(samples=5, seed=0, workers=1)
    assert (changed.samples, changed.seed, changed.workers) == (5, 0, 1)
    assert study.replaced().samples == study.samples
    assert changed.sha256 == study.sha256
    with pytest.raises(StudyError, match="samples = -5"):
        study.replaced(samples=-5)


@pytest.mark.parametrize("path", sorted(STUDIES.glob("*.toml")), ids=lambda path: path.stem)
def test_the_studies_of_the_repository_load(path):
    study = load_study(path)
    assert study.specification and study.tolerances.varied


LEAVES = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.floats(),
    st.text(max_size=8),
    st.sampled_from(["20 mm", "1e300 m", "-5 deg", "5 kg", "uniform", "nan", "1e-300 m", "9 rpm"]),
    st.lists(st.floats(), max_size=4),
    st.just({}),
)


def toml_text(value):
    """A value in TOML syntax; None stands for a table header's remains."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{toml_key(k)} = {toml_text(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml_text, value)) + "]"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        escaped = "".join(c if c.isprintable() and c not in '"\\' else f"\\U{ord(c):08x}" for c in value)
        return f'"{escaped}"'
    return "1979-05-27" if value is None else repr(value)


def toml_key(key):
    return toml_text(str(key))


def paths(table, prefix=()):
    for key, value in table.items() if isinstance(table, dict) else enumerate(table):
        yield (*prefix, key)
        if isinstance(value, (dict, list)):
            yield from paths(value, (*prefix, key))


@settings(max_examples=150, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(data=st.data())
def test_any_mutation_loads_or_is_refused_in_words(tmp_path, data):
    content = tomllib.loads(TEXT)
    for _ in range(data.draw(st.integers(1, 3))):
        path = data.draw(st.sampled_from(list(paths(content))))
        owner = content
        for part in path[:-1]:
            owner = owner[part]
        action = data.draw(st.sampled_from(["replace", "remove", "rename"]))
        if action == "replace" or isinstance(owner, list):
            owner[path[-1]] = data.draw(LEAVES)
        else:
            value = owner.pop(path[-1])
            if action == "rename":
                owner[data.draw(st.text(max_size=6) | st.sampled_from(["fit", "mass", "lower", "data"]))] = value
    file = tmp_path / "mutated.toml"
    file.write_text("\n".join(f"{toml_key(k)} = {toml_text(v)}" for k, v in content.items()), encoding="utf-8")
    tomllib.loads(file.read_text(encoding="utf-8"))  # the mutation is of the content, not of the syntax
    try:
        assert isinstance(load_study(file), Study)
    except StudyError as error:
        assert str(error).startswith(str(file)) and len(str(error)) < 20_000


@settings(max_examples=100, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(at=st.integers(0, len(TEXT) - 1), length=st.integers(0, 30), inserted=st.binary(max_size=6))
def test_any_damage_to_the_bytes_loads_or_is_refused_in_words(tmp_path, at, length, inserted):
    file = tmp_path / "damaged.toml"
    file.write_bytes(TEXT.encode()[:at] + inserted + TEXT.encode()[at + length :])
    try:
        assert isinstance(load_study(file), Study)
    except StudyError as error:
        assert str(file) in str(error)
