"""Where the tests find what is no code: their reference data and the repository's studies."""

from pathlib import Path

ROOT = Path(__file__).parents[2]

HELPERS = ROOT / "tests" / "helpers"
DATA = ROOT / "tests" / "data"
STUDIES = ROOT / "studies"
