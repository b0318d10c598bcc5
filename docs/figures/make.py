"""Make the figures of docs/model.md from the code that they describe.

``python docs/figures/make.py`` writes all, ``python docs/figures/make.py muscle_law`` one of them; ``--folder`` and
``--format png`` put them elsewhere. Needs the extras ``eval`` (matplotlib) and, for the comparisons, ``dev``: those
figures show the runs of the tests themselves. The same sources and matplotlib give the same bytes.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

FOLDER = Path(__file__).parent
ROOT = FOLDER.parents[1]
for folder in (FOLDER, ROOT, ROOT / "tests", ROOT / "tests" / "validation"):
    if str(folder) not in sys.path:
        sys.path.append(str(folder))

from draw_anatomy import condyle_path, frames, muscle_law, muscle_lines  # noqa: E402
from draw_motion import friction, integration, printed_equations  # noqa: E402
from draw_rests import equilibrium  # noqa: E402
from drawing_style import STYLE  # noqa: E402

FIGURES: dict[str, Callable[[], Figure]] = {
    "frames": frames,
    "muscle_law": muscle_law,
    "muscle_lines": muscle_lines,
    "condyle_path": condyle_path,
    "printed_equations": printed_equations,
    "equilibrium": equilibrium,
    "integration": integration,
    "friction": friction,
}


def freeze(figure: Figure) -> None:
    """Round what the layout found: its last bits differ from run to run, and the names in the SVG hang on them."""
    figure.draw_without_rendering()
    figure.set_layout_engine("none")
    for axes in figure.axes:
        axes.set_position(np.round(axes.get_position(original=True).bounds, 4))


def make(name: str, folder: Path = FOLDER, form: str = "svg") -> Path:
    """Draw one figure and write it to ``folder``; returns the file."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{name}.{form}"
    with mpl.rc_context(STYLE):
        figure = FIGURES[name]()
        freeze(figure)
        metadata = {"Date": None} if form == "svg" else {}
        figure.savefig(path, metadata=metadata, dpi=110)
    if form == "svg":  # matplotlib leaves blanks at the ends of lines
        lines = path.read_text(encoding="utf-8").splitlines()
        path.write_text("\n".join(line.rstrip() for line in lines) + "\n", encoding="utf-8")
    return path


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description="Make the figures of docs/model.md.")
    parser.add_argument("names", nargs="*", choices=[[], *FIGURES], metavar="NAME", help=", ".join(FIGURES))
    parser.add_argument("--folder", type=Path, default=FOLDER)
    parser.add_argument("--format", default="svg", choices=["svg", "png"])
    given = parser.parse_args()
    for name in given.names or FIGURES:
        print(make(name, given.folder, given.format))


if __name__ == "__main__":
    main()
