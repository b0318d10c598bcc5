"""``python -m eval thesis`` from start to end."""

from __future__ import annotations

from pathlib import Path

from rich.console import Console

from eval.kept.parts import Run
from eval.kept.tables import made_with
from eval.thesis import report
from eval.thesis.catalogue import chosen
from eval.thesis.item import Judgement
from eval.thesis.run import Draws, draw_all, keep


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

    Raises:
        InputError: an unknown item, a number out of range, or a folder that cannot be used.
    """
    items = chosen(only)
    tables = draw_all(items, settings, output, run)
    findings = {item.key: item.judge(tables[item.key]) for item in items}
    for item in items:
        keep(item, tables[item.key], findings[item.key], settings, output)
    report.show(items, findings, settings, console)
    if not console.is_terminal:
        console.print("drawing the report")
    with console.status("drawing the report"):
        written = report.write(items, tables, findings, settings, made_with(command), output / "report.html")
    console.print(f"report:  {written}\nresults: {output}/*.parquet, {output}/*.json", soft_wrap=True)
    return findings
