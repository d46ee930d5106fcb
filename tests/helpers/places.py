"""Where the tests find what is no code: their reference data and the repository's studies."""

from pathlib import Path

_ROOT = Path(__file__).parents[2]

HELPERS = _ROOT / "tests" / "helpers"
DATA = _ROOT / "tests" / "data"
STUDIES = _ROOT / "studies"
