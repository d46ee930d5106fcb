"""The registry of quantities, against what reads it."""

import math
from dataclasses import fields

import pytest

from tolmc import quantities, units
from tolmc.kernels import parameters
from tolmc.mechanism import geometry
from tolmc.quantities import KINDS, ON_REQUEST, OUTPUT_ROWS, SCALAR_ROWS
from tolmc.simulation.features import Features
from tolmc.simulation.outputs import ROWS

SETTLED = {"at start", "at loss", "grows", "falls", "at end"}


def test_names_are_unique():
    names = [row.name for row in (*SCALAR_ROWS, *OUTPUT_ROWS)]
    assert len(names) == len(set(names))


@pytest.mark.parametrize("row", [*SCALAR_ROWS, *OUTPUT_ROWS], ids=lambda row: row.name)
def test_a_row_is_complete(row):
    assert row.kind in KINDS
    assert row.label == quantities.label(row.name) != ""
    assert row.phrase[:1] == row.phrase[:1].lower()
    shown, factor = quantities.shown(row.name)
    assert units.read(f"{factor!r} {shown}".strip(), quantities.unit(row.name)) == pytest.approx(1.0, rel=1e-15)


@pytest.mark.parametrize("row", OUTPUT_ROWS, ids=lambda row: row.name)
def test_an_output_says_where_it_comes_from(row):
    assert row.when in {"", ON_REQUEST, "slope", "project_energy", *(field.name for field in fields(Features))}
    assert row.settled in SETTLED
    assert row.group in ("geometry", "statistics", "integration", "end")
    if row.group == "geometry":
        assert hasattr(parameters, row.row) or hasattr(geometry, row.name)
    else:
        assert row.name in ROWS


def test_no_row_of_the_kernels_is_given_twice():
    assert len(set(ROWS.values())) == len(ROWS)
    packed = [scalar.row for scalar in SCALAR_ROWS if scalar.row]
    assert len(set(packed)) == len(packed)
    assert {scalar.group for scalar in SCALAR_ROWS if not scalar.row} == {"operating"}


def test_every_kind_can_be_read():
    for kind in KINDS.values():
        assert units.read(kind.example, kind.unit) > 0


def test_people_see_engineering_units():
    assert quantities.shown("bearing_radius") == ("mm", 1e3)
    assert quantities.shown("tilt_angle") == ("deg", pytest.approx(math.degrees(1)))
    assert quantities.shown("contact_force_D_max") == ("N", 1.0)
    assert quantities.label("contact_force_D_max") == "Contact force N_D, max"
    assert quantities.of("contact_force_D_max").phrase == "largest contact force N_D"
    assert quantities.label("gravity_y") == "Gravity y"


def test_a_column_that_is_no_quantity_has_its_words_alone():
    assert quantities.label("any requirement") == "Any requirement"
    assert quantities.output("price").settled == "at end"


def test_the_sets_of_outputs():
    always = [name for name in quantities.GEOMETRY if name in quantities.ALWAYS]
    assert always == ["tilt_angle", "effective_radius", "approximate_radius"]
    assert set(quantities.GEOMETRY) < set(quantities.RESPONSES) < set(quantities.OUTPUTS)
    assert set(quantities.ALWAYS) < set(quantities.OUTPUTS)
    assert set(quantities.CHECKS).isdisjoint(quantities.RESPONSES)
    assert "contact_loss_time" in set(quantities.ALWAYS) - set(quantities.RESPONSES)
    assert set(quantities.END_OUTPUTS).isdisjoint(quantities.OUTPUTS)
