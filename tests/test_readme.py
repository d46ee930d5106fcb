"""README carries a newcomer: it is short, and what it names is there."""

import re
import tomllib

import pytest
from places import ROOT

import tolmc
from tolmc.cli import main
from tolmc.commands.explain import explain

README = (ROOT / "README.md").read_text(encoding="utf-8")
PAGES = ["README.md", "MODEL.md", "CONTRIBUTING.md", "studies/measured.md"]


def test_it_is_short():
    assert len(README.splitlines()) <= 120


def test_its_commands_and_options_are_there():
    named = set(re.findall(r"`?\btolmc ([a-z]+)\b", README)) - {"chooses", "draws"}
    assert {"init", "check", "run", "fits", "compare", "report", "explain"} <= named <= set(main.commands)
    options = {
        option for command in main.commands.values() for parameter in command.params for option in parameter.opts
    }
    commands = "\n".join(re.findall(r"`([^`]*)`", README))
    assert set(re.findall(r"(?<![\w-])(--[a-z-]+)", commands)) - {"--quiet", "--check"} <= options


@pytest.mark.parametrize("page", PAGES)
def test_links_and_pictures_are_there(page):
    text = (ROOT / page).read_text(encoding="utf-8")
    targets = [target for target in re.findall(r"\]\(([^)\s]+)\)", text) if not target.startswith("http")]
    assert [target for target in targets if not ((ROOT / page).parent / target).exists()] == []


def test_its_fields_are_there():
    for field in ("bearing_diameter", "journal_diameter", "fit", "outputs", "specification.target", "unbalance"):
        assert explain(field)


def test_the_citation_is_of_this_version():
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"\nversion: {tolmc.__version__}\n" in citation
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert f"name: {project['authors'][0]['name']}" in citation
