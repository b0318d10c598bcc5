"""``python -m eval thesis`` from start to end."""

from __future__ import annotations

import time
from pathlib import Path

from rich.console import Console

from eval.comparison.compare import versions
from eval.thesis import report
from eval.thesis.catalogue import chosen
from eval.thesis.item import Finding
from eval.thesis.progress import DrawProgress
from eval.thesis.run import Settings, draw_all, keep


def study(
    only: list[str] | None,
    draws: int,
    seed: int,
    quick: bool,
    output: Path,
    fresh: bool,
    command: str,
    console: Console,
    workers: int | None = None,
) -> dict[str, Finding]:
    """Draw, judge, print and write.

    Args:
        only: keys of the items; all by default.
        draws: of each item.
        seed: of all draws.
        quick: short episodes and few cases.
        output: folder of results and report.
        fresh: draw again what it holds.
        command: how the user asked for it.
        console: where to print.
        workers: processes; all cores by default.

    Returns:
        The findings by the items' keys.

    Raises:
        InputError: an unknown item, a number out of range, or a folder that cannot be used.
    """
    items, settings = chosen(only), Settings(draws, seed, quick)
    in_all = draws * len({item.drawn_as for item in items})
    with DrawProgress(in_all, console) as progress:
        tables = draw_all(items, settings, output, fresh=fresh, workers=workers, progress=progress.finished)
    findings = {item.key: item.judge(tables[item.key]) for item in items}
    for item in items:
        keep(item, tables[item.key], findings[item.key], settings, output)
    report.show(items, findings, console)
    if not console.is_terminal:
        console.print("drawing the report")
    about = {
        "command": command,
        "versions": versions(),
        "finished": time.strftime("%Y-%m-%d %H:%M UTC", time.gmtime()),
    }
    with console.status("drawing the report"):
        written = report.write(items, tables, findings, settings, about, output / "report.html")
    console.print(f"report:  {written}\nresults: {output}/*.parquet, {output}/*.json", soft_wrap=True)
    return findings
