"""Tables and notes as HTML: within a notebook, or a page of their own."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape

from tolmc.tables.table import Note, Table, WrittenCell, typeset

_DOCUMENT = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width">
<title>{title}</title>
<style>
:root {{ color-scheme: light dark; }}
body {{ font: 15px/1.45 system-ui, sans-serif; max-width: 70rem; margin: 2rem auto; padding: 0 1rem; }}
table {{ border-collapse: collapse; display: block; overflow-x: auto; }}
th, td {{ padding: .25rem .75rem; border-bottom: 1px solid color-mix(in srgb, currentColor 20%, transparent); }}
small {{ opacity: .7; }}
</style>
</head>
<body>
{content}
</body>
</html>
"""


def document(blocks: Iterable[Table | Note], title: str) -> str:
    """A page of their own, which needs nothing else."""
    return _DOCUMENT.format(title=escape(title), content=page(blocks))


def page(blocks: Iterable[Table | Note]) -> str:
    """HTML of tables and notes in their order."""
    return "".join(_table(block) if isinstance(block, Table) else _note(block) for block in blocks)


def _note(note: Note) -> str:
    start, _, end = note.text.partition(note.strong) if note.strong else ("", "", note.text)
    return f"<p>{escape(start)}<b>{escape(note.strong)}</b>{escape(end)}</p>"


def _table(table: Table) -> str:
    written = table.written(typeset)
    align = ["left" if i in written.left else "right" for i in range(len(written.header))]
    head = "".join(
        f'<th style="text-align:{a}">{escape(text)}</th>' for a, text in zip(align, written.header, strict=True)
    )
    rows = "".join(
        "<tr>"
        + "".join(f'<td style="text-align:{a}">{_cell(c)}</td>' for a, c in zip(align, row, strict=True))
        + "</tr>"
        for row in written.rows
    )
    return f"<p><b>{escape(written.title)}</b></p><table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>"


def _cell(cell: WrittenCell) -> str:
    text = escape(" ".join([cell.text, "/".join(cell.deviations)]).strip())
    return f"{text} <small>{escape(cell.detail)}</small>" if cell.detail else text
