"""The house: files and functions that one can read whole, tests that lie where their module's folder says."""

import ast
import re
from pathlib import Path

import pytest
from places import ROOT

PACKAGE = ROOT / "tolmc"
FOLDERS = sorted(path.name for path in PACKAGE.iterdir() if (path / "__init__.py").exists())
LONGEST_FILE = 450
#: Outside the kernels, whose compiled loops are long where a call would cost.
LONGEST_FUNCTION = 80


def modules() -> list[Path]:
    return sorted(PACKAGE.rglob("*.py"))


def too_long_functions(path: Path) -> list[str]:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    functions = (node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef))
    return [node.name for node in functions if node.end_lineno - node.lineno + 1 > LONGEST_FUNCTION]


def test_files_can_be_read_whole():
    lines = {str(path.relative_to(ROOT)): len(path.read_text(encoding="utf-8").splitlines()) for path in modules()}
    assert not {path: count for path, count in lines.items() if count > LONGEST_FILE}


def test_functions_can_be_read_whole():
    outside = [path for path in modules() if PACKAGE / "kernels" not in path.parents]
    assert len(outside) > 50
    found = {str(path.relative_to(ROOT)): too_long_functions(path) for path in outside}
    assert not {path: names for path, names in found.items() if names}


def test_a_long_function_is_found(tmp_path):
    body = "".join(f"    x = {i}\n" for i in range(LONGEST_FUNCTION))
    (tmp_path / "long.py").write_text(f"class C:\n    pass\n\n\ndef short():\n    pass\n\n\ndef long():\n{body}")
    assert too_long_functions(tmp_path / "long.py") == ["long"]


@pytest.mark.parametrize("folder", FOLDERS)
def test_each_folder_has_its_tests(folder):
    """tests/<folder> holds the tests of tolmc/<folder>."""
    assert list((ROOT / "tests" / folder).glob("test_*.py"))


def test_each_test_has_its_folder():
    of_no_folder = {"data", "helpers"}
    folders = {path.name for path in (ROOT / "tests").iterdir() if path.is_dir() and not path.name.startswith("_")}
    assert folders - of_no_folder <= set(FOLDERS)


def test_readme_names_every_folder():
    text = (ROOT / "README.md").read_text(encoding="utf-8").split("\n## Where things are\n")[1].split("\n## ")[0]
    named = [
        name
        for line in text.splitlines()
        for name in re.findall(r"`(\w+)/`", line.split("|")[1] if "|" in line else "")
    ]
    assert sorted({*named} - {"tolmc"}) == FOLDERS
