"""Studies that are wrong, each in one way: the message names field and value, says what is allowed and what to do."""

import re

import pytest
from small_study import TEXT

from tolmc.study.file import load_study
from tolmc.study.study import StudyError

BORE = 'bearing_radius = { nominal = "20 mm", tolerance = "0.05 mm" }'
INERTIA = "inertia = [4.08e-4, 4.08e-4, 1.2e-4]"
ANGLE = 'tilt_angle = { max = "24.4 deg" }'

#: (text of the study, what stands there instead, field, value, what is allowed or to be done)
WRONG = [
    (BORE, 'bearing_radius = { nominal = "20" }', "bearing_radius.nominal", "'20'", "a string with a unit such as '20 mm'"),
    (BORE, 'bearing_radius = { nominal = "20 kg" }', "bearing_radius.nominal", "20 kg", "give a number in m or"),
    (BORE, 'bearing_radius = { nominal = "5 mm" }', "journal_radius", "0.005 m", "must be smaller than bearing_radius"),
    (BORE, 'bearing_radius = { nominal = true }', "bearing_radius.nominal", "true", "expected a length; give"),
    (BORE, 'bearing_radius = { nominal = nan }', "bearing_radius.nominal", "nan", "expected a number of a size from"),
    (BORE, BORE.replace("0.05", "-0.05"), "bearing_radius.tolerance", "-0.05 mm", "expected a tolerance >= 0; give two"),
    (BORE, BORE.replace("radius", "raduis"), "bearing_raduis", "bearing_raduis", "did you mean 'bearing_radius'? Allowed:"),
    (BORE, BORE.replace("tolerance", "tol"), "bearing_radius.tol", "0.05 mm", "did you mean 'tolerance'? Allowed:"),
    (BORE, BORE.replace(" }", ', distribution = "gauss" }'), "bearing_radius.distribution", "gauss", "mean 'normal'? Allowed"),
    (BORE, BORE.replace(" }", ', distribution = "xyz" }'), "radius.distribution", "xyz", "; allowed: truncated_normal"),
    (BORE, BORE.replace(" }", ', distribution = "beta" }'), "radius.alpha", "is missing", "such as alpha = 2, beta = 3"),
    (BORE, BORE.replace(" }", ", cp = -1 }"), "bearing_radius", "cp = -1", "allowed: a finite number > 0"),
    (BORE, BORE.replace(" }", ', mode = "20 mm" }'), "bearing_radius.mode", "truncated_normal", "allowed with it: cp, cpk"),
    (BORE, BORE.replace(" }", ', lot_sd = "1 mm" }'), "bearing_radius", "1 mm", "Reduce it, or widen the tolerance"),
    (BORE, 'bearing_radius = { nominal = "20 mm", lower = "19 mm" }', "bearing_radius", "one limit", "give lower and upper"),
    (BORE, 'bearing_radius = { lower = "21 mm", upper = "20 mm" }', "bearing_radius", "21 mm", "exchange the limits"),
    (BORE, 'bearing_radius = { data = "x.csv", column = "d", unit = "mm" }', "bearing_radius", "x.csv", "check its path"),
    (BORE, 'bearing_diameter = "40 H77"', "bearing_diameter", "'77'", "allowed: 01, 0, 1"),
    (BORE, 'bearing_diameter = "40 h7"', "bearing_diameter", "40 h7", "Write '40 H7'"),
    (BORE, 'bearing_diameter = "40 +0.1 mm"', "bearing_diameter", "40 +0.1 mm", "write both, such as '40 +0.1/0 mm'"),
    (BORE, 'bearing_diameter = "40 -0.1 mm"', "bearing_diameter", "40 -0.1 mm", "write both, such as '40 0/-0.1 mm'"),
    (BORE, 'fit = "40 H7-d9"', "fit", "40 H7-d9", "did you mean '40 H7/d9'? Allowed: diameter in mm"),
    (BORE, f'fit = "40 H7/d9"\n{BORE}', "bearing_radius", "tolerance and fit", "leave one out"),
    (BORE, "", "bearing_radius", "is missing", 'add bearing_diameter = "40 ±0.05 mm"'),
    (BORE, f'{BORE}\nbearing_diameter = "40 mm"', "bearing_diameter", "the same dimension", "leave one out"),
    (BORE, f'{BORE}\nmass = "0.5 kg"', "mass.nominal", "0.5 kg", "Leave it out"),
    (BORE, f'{BORE}\nunbalance = "6.3"', "unbalance", "6.3", 'such as "G6.3"'),
    (BORE, f"{BORE}\nlot_size = 0", "lot_size", "0", "expected a whole number from 1"),
    ('mass = "0.5 kg"', 'mass = "-0.5 kg"', "[body] mass", "-0.5 kg", 'expected a mass > 0, such as "0.5 kg"'),
    ('mass = "0.5 kg"', 'mass = "0.5 N"', "[body] mass", "0.5 N", "give a number in kg or"),
    ('mass = "0.5 kg"', "", "[body] mass", "is missing", "give a number in kg or"),
    (INERTIA, "inertia = [4e-4, 4e-4]", "[body] inertia", "0.0004", "three moments of inertia or a 3x3 matrix"),
    (INERTIA, "inertia = [4e-4, 1e-4, 9e-4]", "[body]", "0.0009", "none larger than the sum of the other two"),
    (INERTIA, "", "[body]", "no inertia", "give one of inertia, centroidal_inertia, solid_cylinder"),
    ("gravity = [0, -9.81, 0]", "gravity = -9.81", "[loads] gravity", "-9.81", "expected three values [x, y, z]"),
    ("gravity = [0, -9.81, 0]", "gravty = [0, -9.81, 0]", "[loads] gravty", "-9.81", "did you mean 'gravity'? Allowed"),
    ('alpha = "-110 deg"', "", "[motion] alpha", "is missing", "give a number in rad or"),
    ('alpha = "-110 deg"', 'alpha = "-110 mm"', "[motion] alpha", "-110 mm", "give a number in rad or"),
    ('duration = "0.1 s"', 'duration = "0 s"', "[motion] duration", "0 s", 'expected a time > 0, such as "1 s"'),
    ("samples = 3000", "samples = 0.5", "[monte_carlo] samples", "0.5", "expected a whole number from 1 to"),
    ("samples = 3000", 'samples = "many"', "[monte_carlo] samples", "many", "write it without quotes"),
    ('sampling = "sobol"', 'sampling = "sobbol"', "[monte_carlo] sampling", "sobbol", "did you mean 'sobol'? Allowed"),
    ("workers = 2", 'method = "euler"', "[monte_carlo] method", "euler", "; allowed: 'rk4'"),
    ("workers = 2", 'outputs = ["tilt"]', "[monte_carlo] outputs", "'tilt'", "did you mean 'tilt_max'? Allowed"),
    ("workers = 2", 'outputs = ["effective_radius"]', "[specification] tilt_angle", "[monte_carlo] outputs", "add it there"),
    ("workers = 2", 'until = { output = "tilt_max" }', "until.statistic", "is missing", 'give "mean", "sd", "yield"'),
    ("workers = 2", 'on_contact_loss = "follow"', "[monte_carlo] on_contact_loss", "follow", "needs [contact] restitution"),
    ("workers = 2", "accuracy = 2", "[monte_carlo] accuracy", "2",
     "a plain number of at least 1e-14 and at most 0.1, such as 1e-6"),
    ("workers = 2", 'accuracy = "50 %"', "[monte_carlo] accuracy", "50 %", "of at least 1e-14 and at most 0.1"),
    ("workers = 2", 'step = "1 s"', "[monte_carlo] step", "'1 s'", "at most [motion] duration = '0.1 s'; shorten it"),
    ("[specification]", '[operating]\nbearing_temperature = "80 K"\n[specification]',
     "[operating] bearing_temperature", "80 K", "at least 200 K, or a temperature in °C, such as '80 °C'"),
    ("[specification]", '[operating]\njournal_temperature = "5000 °C"\n[specification]',
     "[operating] journal_temperature", "5000 °C", "at most 3500 °C, such as"),
    ("[specification]", "[operating]\njournal_expansion = 12\n[specification]",
     "journal_expansion", "12", "allowed: up to 0.001 1/K either way. Steel has 12e-6"),
    (ANGLE, 'tilt_angle = { max = "24.4 mm" }', "tilt_angle.max", "24.4 mm", "give a number in rad or"),
    (ANGLE, 'tilt_angle = { maximum = "24.4 deg" }', "tilt_angle.maximum", "24.4 deg", "did you mean 'max'? Allowed"),
    (ANGLE, 'tilt_angle = { min = "25 deg", max = "24 deg" }', "tilt_angle", "25 deg", "exchange them"),
    (ANGLE, "tilt_angle = {}", "[specification] tilt_angle", "no limit", "give min, max or both"),
    (ANGLE, f"{ANGLE}\ntarget = 99.7", "[specification] target", "99.7", "a share between 0 and 1, such as 0.9973"),
    ("[specification]", '[outputs]\nsag = "tilt_maxx"\n[specification]', "[outputs] sag", "tilt_maxx", "mean 'tilt_max'?"),
    ("[specification]", '[outputs]\nsag = "1 mm + tilt_max"\n[specification]', "[outputs] sag", "1 mm +", "by a factor with"),
    ("[specification]", '[outputs]\nsag = "open(1)"\n[specification]', "[outputs] sag", "open", "; allowed: sin, cos"),
    ("[specification]", "[contact]\nrestitution = 1.5\n[specification]", "restitution", "1.5", "allowed: 0 (no rebound) to 1"),
    ("[specification]", "[contact]\nfriction = -1\n[specification]", "[contact] friction", "-1",
     ">= 0 and at most 10, such as 0.1"),
    ("[specification]", '[model]\nsection = "oval"\n[specification]', "[model] section", "oval", "; allowed: 'circle' or"),
    ("[specification]", "[modle]\n[specification]", "modle", "modle", "did you mean 'model'? Allowed"),
    ("[specification]", "[correlation]\nbearing_radius.half_length = 1.5\n[specification]",
     "[correlation] bearing_radius.half_length", "1.5", "expected a correlation from -1 to 1"),
    (ANGLE, 'tilt_max = { max = "-5 deg" }', "[specification] tilt_max.max", "-5 deg",
     "always above 0 and at most 90 deg; give"),
    (ANGLE, 'tilt_angle = { min = "95 deg" }', "tilt_angle.min", "95 deg", "always above 0 and at most 90 deg; give"),
    (ANGLE, 'effective_radius = { max = "0 mm" }', "effective_radius.max", "0 mm", "above 0 mm; give a limit there"),
    (ANGLE, "closed_share_D = { min = 3 }", "closed_share_D.min", "3", "at least 0 and at most 100 %; give"),
    (ANGLE, 'play = { max = "3 mm" }', "[specification] play", "max = '3 mm'", 'give it under [outputs], such as play ='),
    (ANGLE, 'tilt_angle = "24.4 deg"', "[specification] tilt_angle", "24.4 deg",
     'expected a table, such as { max = "25 deg" }'),
    ("[specification]", "[contact]\nfriction = 50\n[specification]", "[contact] friction", "50", "at most 10, such as 0.1"),
    ("[specification]", '[contact]\nfriction = "0.1 N"\n[specification]', "friction", "0.1 N", "a plain number; give a number"),
    ("[specification]", "[contact]\nwear_coefficient = 1\n[specification]", "wear_coefficient", "1", "at most 1e-09 m^2/N"),
    ("[specification]", '[operating]\nbush_wall = "-1 mm"\n[specification]', "[operating] bush_wall", "-1 mm",
     "a length >= 0, such as"),
    ("[specification]", '[operating]\njournal_temperature = "-300 °C"\n[specification]',
     "journal_temperature", "-300 °C", "of at least -273.15 °C and at most 3500 °C, such as"),
    ("[specification]", '[operating]\nbearing_expansion = "steal"\n[specification]', "bearing_expansion", "steal",
     "mean 'steel'?"),
    ("[specification]", "[operating]\nconductivity = 1000\n[specification]", "conductivity", "1000", "; allowed: bearing_temp"),
    ("[specification]", '[life]\nrunning_time = "2000"\n[specification]', "[life] running_time", "2000", "string with a unit"),
    ("[specification]", '[life]\nrunning_time = "9 h"\nbroken_share = 5\n[specification]', "broken_share", "5",
     "0.05 or '5 %'"),
    ("[specification]", "[outputs]\nsag = 5\n[specification]", "[outputs] sag", "5", "expected a text in quotes"),
    ("[specification]", '[outputs]\nsag = "800 * sin(tilt_angle"\n[specification]', "sag", "800 *", "write one such as"),
    ("[specification]", '[outputs]\nmass = "2 mm"\n[specification]', "[outputs] mass", "called so", "Choose another"),
    ("[specification]", '[outputs]\nsag = { value = "2 mm", unit = "N" }\n[specification]', "sag", "2 mm",
     "change unit, or leave"),
    (BORE, f'{BORE}\nfriction = {{ tolerance = "0.1" }}', "friction", "0.1", "allowed: >= 0. Check the units and the signs"),
    (BORE, f'{BORE}\nunbalance = "G100000"', "unbalance", "G100000", '"G0.4" to "G4000", such as "G6.3"'),
    (BORE, 'bearing_radius = "20 ±25 mm"', "bearing_radius", "20 ±25 mm", "limits -0.005 to 0.045; allowed: > 0"),
    (BORE, 'bearing_radius = "20,5 ±0.1 mm"', "bearing_radius", "20,5 ±0.1 mm", "write a point, such as"),
    (BORE, BORE.replace("0.05 mm", "5 %"), "bearing_radius.tolerance", "5 %", "give a number in m or a string"),
    (BORE, BORE.replace(" }", ', mean = "30 mm" }'), "bearing_radius", "30 mm",
     "0.02005, with cpk strictly between. Give a mean"),
    (BORE, 'bearing_diameter = "40 Q7"', "bearing_diameter", "'Q7'", "a letter of a b c cd"),
    (BORE, 'bearing_diameter = "4000 H7"', "bearing_diameter", "4000", "Give the limits instead"),
    (BORE, f'{BORE}\ntilt_angle = {{ tolerance = "1 deg" }}', "[dimensions] tilt_angle", "is unknown",
     "; allowed: bearing_dia"),
    (BORE, f'{BORE}\nrestitution = {{ tolerance = 0.1 }}', "restitution", "varies, but the joint has none",
     "in a study [contact] restitution"),
    ("gravity = [0, -9.81, 0]", 'drive = { amplitude = "30 deg" }', "drive.frequency", "is missing", "such as '25 Hz'"),
    ("gravity = [0, -9.81, 0]", 'drive = { amplitude = "9 deg", frequency = "-1 Hz" }', "drive.frequency", "-1 Hz",
     "a frequency >= 0, such as"),
    ("gravity = [0, -9.81, 0]", 'drive = "steady"', "[loads] drive", "steady", 'expected "free", "constant speed" or a table'),
    ("gravity = [0, -9.81, 0]", 'gravity = [0, "-9.81 m/s", 0]', "[loads] gravity", "-9.81 m/s", "give a number in m/s^2 or"),
    ('spin_rate = "80 rad/s"', 'spin_rate = "80 Hz"', "[motion] spin_rate", "80 Hz", "such as '1500 rpm'"),
    ("workers = 2", "accuracy = 1e-30", "accuracy", "1e-30", "of at least 1e-14"),
    ("workers = 2", 'until = { output = "tilt_max", statistic = "mean", width = "1 N" }', "until.width", "1 N",
     "give a number in rad"),
    ("[body]", "[bodies]", "[body] is missing", "bodies", "did you mean 'body'? Allowed"),
    ("[specification]", "[correlation]\nbearing_radius.mass = 0.5\n[specification]",
     "[correlation] bearing_radius.mass", "0.5", "; allowed: bearing_radius, journal_radius, half_length."),
    ("[specification]", "[correlation]\nbearing_radius = 0.5\n[specification]",
     "[correlation] bearing_radius", "0.5", "expected bearing_radius.other_dimension = number"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "field", "value", "remedy"), WRONG, ids=range(len(WRONG)))
def test_says_field_value_allowed_and_remedy(tmp_path, old, new, field, value, remedy):
    assert TEXT.count(old) == 1
    path = tmp_path / "wrong.toml"
    path.write_text(TEXT.replace(old, new), encoding="utf-8")
    with pytest.raises(StudyError) as found:
        load_study(path)
    message = str(found.value)
    for part in (field, value, remedy):
        assert part in message
    assert all(line.startswith(f"{path}: ") and line.endswith(".") for line in message.splitlines())
    assert not re.search(r"__|Traceback|object at|positional|NoneType|; Allowed|\?;|\?\.", message)
