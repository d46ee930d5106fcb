import math

import pint
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tolmc import quantities, units

UNITS = sorted({kind.unit for kind in quantities.KINDS.values()})


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("20 mm", "m", 0.02),
        ("-110 deg", "rad", math.radians(-110)),
        ("-110°", "rad", math.radians(-110)),
        ("1500 rpm", "rad/s", 50 * math.pi),
        ("3 rev/s", "rad/s", 6 * math.pi),
        ("1e-1kg", "kg", 0.1),
        ("120 kg mm^2", "kg m^2", 1.2e-4),
        ("120 kg*mm**2", "kg m^2", 1.2e-4),
        ("120 kg·mm²", "kg m^2", 1.2e-4),
        ("5 μm", "m", 5e-6),
        ("1 inch", "m", 0.0254),
        ("2 lbf", "N", 8.896443230521),
        ("40 %", "1", 0.4),
        (" 7 ", "1", 7.0),
    ],
)
def test_strings_carry_units(text, unit, value):
    assert units.read(text, unit) == pytest.approx(value, rel=1e-15)


@given(st.integers(-(10**6), 10**6))
def test_decimal_units_are_exact(hundredths):
    # The double nearest to the number that stands there: "0.07 mm" is 7e-5, not 0.07 * 0.001.
    assert units.read(f"{hundredths / 100:.2f} mm", "m") == float(f"{hundredths}e-5")


@pytest.mark.parametrize(
    ("text", "celsius"),
    [("80 °C", 80.0), ("-5.5 degC", -5.5), ("293.15 K", 20.0), ("176 °F", 80.0), ("-40 degF", -40.0)],
)
def test_temperatures_stand_on_their_scale(text, celsius):
    assert units.read(text, "°C") == celsius
    assert units.read(celsius, "°C") == celsius


@pytest.mark.parametrize(("text", "kelvin"), [("5 K", 5.0), ("5 °C", 5.0), ("9 °F", 5.0)])
def test_differences_of_temperatures_have_no_zero(text, kelvin):
    assert units.read(text, units.difference("°C")) == pytest.approx(kelvin, rel=1e-15)


@pytest.fixture(scope="module")
def registry():
    return pint.get_application_registry()


@pytest.mark.parametrize("unit", [unit for unit in units._COMMON if unit != "K"])
def test_units_read_without_pint_agree_with_it(registry, unit):
    for written in units._COMMON[unit]:
        expected = registry.Quantity(1.0, registry.Unit(written)).to("" if unit == "1" else unit).magnitude
        assert units.read(f"1 {written}", unit) == pytest.approx(expected, rel=1e-15)


@pytest.mark.parametrize(
    ("value", "unit", "complaint"),
    [
        ("5 kg", "m", "'kg' is not that of a length"),
        ("5", "m", "no unit"),
        ("5 foo", "m", "'foo' is unknown"),
        ("10 Hz", "rad/s", "turns or radians"),
        ("5 dB", "rad", "not that of an angle"),
        ("5 %", "rad", "not that of an angle"),
        ("20 degC", "rad", "not that of an angle"),
        ("5 mm", "°C", "'mm' is not that of a temperature"),
        ("80", "°C", "it has no unit; give a number in °C"),
        ("mm", "m", "expected a length"),
        ("9**9**9 mm", "m", "expected a length"),
        ("nan mm", "m", "expected a length"),
        ("1e9999 mm", "m", "from 1e-30 to 1e+30"),
        (math.nan, "m", "from 1e-30 to 1e+30"),
        (10**400, "m", "from 1e-30 to 1e+30"),
        ("1e-31 m", "m", "from 1e-30 to 1e+30"),
        (True, "m", "expected a length"),
        ([1], "kg", "expected a mass"),
    ],
)
def test_what_is_no_such_quantity_is_refused_with_a_remedy(value, unit, complaint):
    with pytest.raises(ValueError, match="give a number") as error:
        units.read(value, unit)
    assert complaint in str(error.value)


@given(st.text(max_size=30) | st.from_regex(r"\d{1,3} ?[a-zµ°]{1,6}([*/^ ]{1,2}[a-z0-9-]{1,4})?", fullmatch=True))
def test_any_text_is_read_or_refused(text):
    for unit in UNITS:
        try:
            assert math.isfinite(units.read(text, unit))
        except ValueError as error:
            assert str(error)
