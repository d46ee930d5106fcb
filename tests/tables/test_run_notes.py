"""What a run says beside its tables."""

import pytest
from small_study import write

from tolmc.report.content import report_content
from tolmc.runs.directory import read
from tolmc.runs.pictures import RunPictures
from tolmc.runs.run import run
from tolmc.tables.run import run_blocks
from tolmc.tables.table import Note

#: A journal that starts on top and hops till the end.
HOPS = (
    ("[monte_carlo]", '[contact]\nrestitution = 0.9\n[monte_carlo]\nstep = "2 ms"'),
    ('alpha = "-110 deg"', 'alpha = "70 deg"'), ('duration = "0.1 s"', 'duration = "1 s"'),
)  # fmt: skip


@pytest.mark.parametrize("changes", [HOPS, ()], ids=["hops", "keeps contact"])
def test_a_run_and_its_report_say_which_outputs_jump(tmp_path, monkeypatch, changes):
    monkeypatch.setattr(RunPictures, "_begin", lambda *_: None)
    result = run(write(tmp_path, *changes), samples=64, out=tmp_path / "run")
    blocks = [block.text for block in run_blocks(result) if isinstance(block, Note) and block.strong == "Jumps"]
    trust = [said for said in report_content(read(tmp_path / "run"))["trust"] if said.startswith("Jumps")]
    assert blocks == trust
    assert len(blocks) == bool(changes)
    assert all("of true motions by" in said and "Sobol' points gain little" in said for said in blocks)
