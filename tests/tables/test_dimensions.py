"""Dimensions as a drawing and as the model has them."""

import math
from dataclasses import replace

import pytest
from places import STUDIES

from tolmc.mechanism.operating import Operating
from tolmc.study.file import load_study
from tolmc.tables.dimensions import constants_table, dimensions_table
from tolmc.text import typeset
from tolmc.tolerances.dimension import Dimension, Tolerances

JOINT = STUDIES / "paper_joint.toml"


@pytest.mark.parametrize(
    "fit", ["40 D9/d9", "40D9/d9", "⌀ 40 D9/d9", "40mm D9/d9", "40 mm D9 / d9", "Ø40mmD9/ d9", "40.0 D9/d9"]
)
def test_fits_read_alike_however_they_are_spaced(fit):
    dimensions = (*Dimension.from_fit(fit), Dimension.from_tolerance_class("half_length", "30mm js7"))
    rows = dimensions_table(replace(load_study(JOINT), tolerances=Tolerances(dimensions))).rows
    assert [row[1].content for row in rows] == ["⌀40 D9", "⌀40 d9", "30 js7"]
    assert [row[0].content for row in rows] == ["Bearing diameter 2 R*", "Journal diameter 2 r*", "Bearing length 2 L"]


def test_conditions_are_constants_where_the_study_sets_them():
    study = load_study(JOINT)
    hot = replace(study, scene=replace(study.scene, operating=Operating(80.0, bearing_expansion="steel")))

    def named(study):
        return [row[0].text for row in constants_table(study).written(typeset).rows]

    assert [name for name in named(hot) if name not in named(study)] == [
        "Bearing temperature", "Journal temperature", "Bearing expansion",
    ]  # fmt: skip


def test_angular_velocities_are_told_in_the_rpm_of_the_study():
    study = load_study(JOINT.with_name("horizontal_shaft.toml"))
    cells = {cells[0].text: cells[1].line for cells in constants_table(study).written(typeset).rows}
    assert cells["Spin rate Ω"] == "75.3982 rad/s (720 rpm)"
    dimensions = (*study.tolerances.dimensions, Dimension.symmetric("spin_rate", 24 * math.pi, math.pi))
    varied = replace(study, tolerances=replace(study.tolerances, dimensions=dimensions))
    assert dimensions_table(varied).rows[-1][3].detail == "690 to 750 rpm"
    assert dimensions_table(replace(varied, source=study.source.replace("rpm", ""))).rows[-1][3].detail == ""
