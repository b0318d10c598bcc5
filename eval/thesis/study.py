"""``python -m eval thesis`` from start to end: a table in the terminal, and one HTML file that needs no other file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import pandas as pd
from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from eval.kept.parts import Run
from eval.kept.tables import made_with
from eval.report import template
from eval.report.template import picture
from eval.thesis.catalogue import chosen
from eval.thesis.item import Item, Judgement
from eval.thesis.run import ENOUGH, Draws, draw_all, keep

_COLOUR = {"reproduced": "green", "partly": "yellow", "not reproduced": "red"}
UNDECIDED = "too few draws"


def study(
    only: list[str] | None, settings: Draws, output: Path, run: Run, command: str, console: Console
) -> dict[str, Judgement]:
    """Draw, judge, print and write.

    Args:
        only: keys of the items; all by default.
        settings: how the items are drawn.
        output: folder of results and report.
        run: how the draws are made.
        command: how the user asked for it.
        console: where to print.

    Returns:
        The findings by the items' keys.
    """
    items = chosen(only)
    tables = draw_all(items, settings, output, run)
    findings = {item.key: item.judge(tables[item.key]) for item in items}
    for item in items:
        keep(item, tables[item.key], findings[item.key], settings, output)
    show(items, findings, settings, console)
    if not console.is_terminal:
        console.print("drawing the report")
    with console.status("drawing the report"):
        written = write(items, tables, findings, settings, made_with(command), output / "report.html")
    console.print(f"report:  {written}\nresults: {output}/*.parquet, {output}/*.json", soft_wrap=True)
    return findings


def show(items: Sequence[Item], findings: dict[str, Judgement], settings: Draws, console: Console) -> None:
    """Print every result: place in the thesis, measurement, and the verdict if there are enough draws for one."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, title="Young (2016) and what we measure", title_justify="left")
    table.add_column("result", min_width=20)
    table.add_column("we measure", ratio=1)
    table.add_column("verdict", min_width=10)
    for item in items:
        finding = findings[item.key]
        name = Text.assemble((item.title, "bold"), "\n", (item.where, "dim"))
        if settings.decisive:
            table.add_row(name, finding.measured, Text(finding.verdict, style=_COLOUR[finding.verdict]))
            table.add_row("", Text(finding.why, style="dim"), "")
        else:
            table.add_row(name, finding.measured, Text(UNDECIDED, style="dim"))
    console.print(table)


def write(
    items: Sequence[Item],
    tables: dict[str, pd.DataFrame],
    findings: dict[str, Judgement],
    settings: Draws,
    metadata: dict[str, Any],
    path: Path,
) -> Path:
    """Write the report.

    Args:
        items: in their order.
        tables: rows of all draws by the items' keys.
        findings: by the items' keys.
        settings: of the draws.
        metadata: command, versions and time.
        path: of the HTML file.

    Returns:
        The path.
    """
    page = template.render(
        "thesis.html.j2",
        items=items,
        findings=findings,
        pictures={item.key: picture(item.figure(tables[item.key]), item.key, item.title) for item in items},
        settings=asdict(settings),
        decisive=settings.decisive,
        undecided=UNDECIDED,
        enough=ENOUGH,
        about=metadata,
        counts={verdict: sum(finding.verdict == verdict for finding in findings.values()) for verdict in _COLOUR},
    )
    return template.write(page, path)
