"""Damaged studies, CSV files in any dialect, odd surroundings: one clear error or the right result (studies/fuzz.py)."""

import sys
from contextlib import nullcontext

import numpy as np
import pytest
from places import STUDIES
from ready_pictures import pictures_at_hand

sys.path.append(str(STUDIES))
from fuzz_files import csv_case, study_case, surroundings_case

TEXTS = [path.read_text(encoding="utf-8") for path in sorted(STUDIES.glob("*.toml"))]


@pytest.mark.parametrize(("kind", "count"), [("study", 16), ("csv", 12), ("surroundings", 4)])
def test_everything_from_outside_runs_rightly_or_is_refused_in_words(tmp_path, kind, count):
    rng = np.random.default_rng(20)
    # Files decide what a picture shows, surroundings whether it can be drawn.
    with nullcontext() if kind == "surroundings" else pictures_at_hand():
        for number in range(count):
            if kind == "study":
                case = study_case(rng, tmp_path, number, TEXTS)
            else:
                case = (csv_case if kind == "csv" else surroundings_case)(rng, tmp_path, number)
            assert case.broken == (), case.shown
