"""What the study scripts share: the paper's joint, command-line options, printed tables and the look of the figures."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping
from pathlib import Path

import pandas as pd
from matplotlib.figure import Figure
from rich import box
from rich.console import Console
from rich.table import Table

from tolmc.mechanism.scene import Body, Joint, Loads, Motion, Scene

ROOT = Path(__file__).parents[1]

#: Okabe and Ito's colours, which people with any colour vision tell apart.
BLUE, ORANGE, GREEN, RED, PURPLE, SKY = "#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7", "#56B4E9"
GREY = "#666666"
STYLE = {
    "font.size": 10, "axes.titlelocation": "left", "axes.titlesize": 11, "axes.titleweight": "bold", "figure.titlesize": 13,
    "figure.titleweight": "bold", "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True,
    "axes.axisbelow": True, "grid.color": "#e4e4e4", "grid.linewidth": 0.8, "legend.frameon": False,
}  # fmt: skip


def arguments(description: str, **options: Mapping) -> argparse.Namespace:
    """Command line of a study script: --quick, --figures and further ``options``."""
    parser = argparse.ArgumentParser(description=description.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="a small part of everything, to see that it runs")
    parser.add_argument(
        "--figures", type=Path, default=ROOT / "figures", help="folder of the pictures (default figures/)"
    )
    for name, settings in options.items():
        parser.add_argument(f"--{name}", **settings)
    return parser.parse_args()


def paper_joint(section: str = "circle") -> Scene:
    """The paper's joint R* = 2 r*, L = 2 r* with gravity across the bearing, one second of motion."""
    case = json.loads((ROOT / "tests/data/trajectories.json").read_text())["paper_joint_tilted_start"]
    return Scene(
        Joint(case["bearing_radius"], case["journal_radius"], case["half_length"], section),
        Body(case["mass"], case["center_of_mass"], case["inertia"]),
        Loads(case["gravity"]),
        Motion(**case["motion"]),
        case["duration"],
    )


def show(title: str, table: pd.DataFrame, formats: Mapping[str, str] | None = None) -> None:
    """Print a table, numbers by ``formats`` (column: format specification), NaN as a dash."""
    formats = formats or {}
    printed = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for name, column in table.items():
        printed.add_column(
            str(name), justify="right" if pd.api.types.is_numeric_dtype(column) else "left", no_wrap=True
        )
    for _, row in table.iterrows():
        printed.add_row(*(_text(value, formats.get(name, "")) for name, value in row.items()))
    # A table that goes into a file must not be folded at 80 columns.
    console = Console(width=None if sys.stdout.isatty() else 200)
    console.print(f"\n[bold]{title}[/]", printed)


def _text(value, specification: str) -> str:
    if pd.isna(value):
        return "–"
    return format(value, specification if not isinstance(value, str) else "")


def save(figure: Figure, path: Path) -> None:
    """Write the figure and say where."""
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=150)
    print(f"Written: {path}")
