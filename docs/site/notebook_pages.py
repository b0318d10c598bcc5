"""Pages of the notebooks with what they print and draw: ``python docs/site/notebook_pages.py`` runs them first.

An executed notebook is kept in runs/notebooks until the notebook or anything that it may call has changed. One that was
not executed is shown without outputs.
"""

from __future__ import annotations

import hashlib
import os
import sys
from html import escape
from pathlib import Path

import nbformat
from markdown import markdown
from nbclient import NotebookClient
from nbclient.exceptions import CellExecutionError
from nbformat import NotebookNode
from rich.console import Console

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(Path(__file__).parent), str(ROOT)]

from formulas import with_mathml  # noqa: E402

from jawenv.base.files import atomic_write  # noqa: E402
from jawenv.base.locks import alone  # noqa: E402
from jawenv.base.progress import Progress  # noqa: E402

SOURCES = sorted((ROOT / "eval" / "notebooks").glob("*.ipynb"))
KEPT = ROOT / "runs" / "notebooks"


def pages() -> dict[str, str]:
    """Place in the site -> Markdown."""
    return {f"notebooks/{path.stem}.md": _page(path) for path in SOURCES}


def execute_all(console: Console) -> int:
    """Run every notebook whose outputs are not kept; what is finished stays when this is interrupted.

    Returns:
        The exit code: 0, or 1 where a cell raised an error.
    """
    KEPT.mkdir(parents=True, exist_ok=True)
    with alone(KEPT), Progress(len(SOURCES), "notebooks", console) as progress:
        for number, path in enumerate(SOURCES, 1):
            place = _kept(path)
            if not place.exists():
                progress.say(f"running {path.name}")
                notebook = nbformat.read(path, as_version=4)
                try:
                    _execute(notebook, path.parent)
                except CellExecutionError as error:
                    console.print(f"error: {path.name}: {error.ename}: {error.evalue}", soft_wrap=True)
                    return 1
                with atomic_write(place) as unfinished:
                    unfinished.write_text(nbformat.writes(notebook), encoding="utf-8")
            progress.advance_to(number)
    return 0


def _execute(notebook: NotebookNode, folder: Path) -> None:
    """Run all cells in a kernel of its own, which reports errors only."""
    quiet = ["--IPKernelApp.log_level=40"]
    resources = {"metadata": {"path": str(folder)}}
    NotebookClient(notebook, timeout=3600, resources=resources, extra_arguments=quiet).execute()


def _kept(path: Path) -> Path:
    """Where the executed notebook lies; its name says of which sources and size it is."""
    mark = hashlib.sha256()
    packages = (ROOT / name for name in ("jawenv", "agents", "training", "eval"))
    for source in (path, *sorted(file for package in packages for file in package.rglob("*.py"))):
        if source.parent != path.parent or source == path:
            mark.update(source.read_bytes())
    mark.update(repr(sorted((k, v) for k, v in os.environ.items() if k.startswith("JAWENV_NOTEBOOK_"))).encode())
    return KEPT / f"{path.stem}-{mark.hexdigest()[:12]}.ipynb"


def _page(path: Path) -> str:
    place = _kept(path)
    notebook = nbformat.read(place if place.exists() else path, as_version=4)
    parts = []
    for cell in notebook.cells:
        if cell.cell_type == "markdown":
            parts.append(with_mathml(cell.source))
        else:
            parts.append(f"```python\n{cell.source}\n```")
            parts += [_boxed(_html(output)) for output in cell.outputs]
    parts.append(f"This page is the notebook `eval/notebooks/{path.name}`; `make notebooks` opens it.")
    return "\n\n".join(part for part in parts if part) + "\n"


def _boxed(html: str) -> str:
    """A block that Markdown leaves as it is: no blank line within it."""
    body = "\n".join(line for line in html.splitlines() if line.strip())
    return f'<div class="notebook-output">{body}</div>' if body else ""


def _html(output: NotebookNode) -> str:
    """The richest form of an output that a page can show; empty for what is of interest to nobody."""
    if output.output_type == "stream":
        return _printed(output.text) if output.name == "stdout" else ""
    data = output.get("data", {})
    for kind in ("image/png", "image/jpeg"):
        if kind in data:
            source = f"data:{kind};base64,{''.join(data[kind].split())}"
            return f'<img alt="Figure made by the cell above" src="{source}">'
    if "text/html" in data:
        return str(data["text/html"])
    if "text/markdown" in data:
        return markdown(data["text/markdown"])
    return _printed(data["text/plain"]) if "text/plain" in data else ""


def _printed(text: str) -> str:
    """A blank line would end the block; one with a space that does not break does not."""
    return "<pre>" + "\n".join(line or "&nbsp;" for line in escape(text.rstrip()).splitlines()) + "</pre>"


if __name__ == "__main__":
    try:
        sys.exit(execute_all(Console(stderr=True)))
    except KeyboardInterrupt:
        sys.exit("stopped; finished notebooks are kept, and the same command goes on")
