"""Write the site's pages as plain Markdown: ``python docs/site/build.py``, before any engine makes HTML of them.

Into runs/site_source go the pages of docs/ and of other folders, with links led to places of the site and formulas as
MathML, and the pages that are made: environments, gallery, examples, notebooks, all
tables, API.
"""

from __future__ import annotations

import argparse
import re
import shutil
import sys
from pathlib import Path

HERE = Path(__file__).parent
DOCS = HERE.parent
ROOT = DOCS.parent
sys.path[:0] = [str(HERE), str(ROOT)]

import environment_pages  # noqa: E402
import example_pages  # noqa: E402
import gallery  # noqa: E402
import landing  # noqa: E402
import notebook_pages  # noqa: E402
import table_page  # noqa: E402
from formulas import with_mathml  # noqa: E402

import jawenv  # noqa: E402
from eval.report.template import TERMS  # noqa: E402

FOLDER = ROOT / "runs" / "site_source"
FOLDERS = ("agents", "training", "eval")
OTHERS = (*(f"{folder}/README.md" for folder in FOLDERS), "CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md")
PAGES = {"README.md": "index.md"} | {name: name for name in OTHERS}
"""Pages outside docs/: where they lie in the repository, and in the site."""
PLAIN = ("LICENSE", "CITATION.cff")
SHOWN = (".svg", ".webp", ".jpg", ".css", ".js")
SEARCH = {"questions.md": "boost: 4", "tables.md": "exclude: true", "CHANGELOG.md": "exclude: true"}
"""Front matter of pages for the search: first come answers and the glossary."""
EXPLAINED = "\n\n" + "\n".join(f"*[{word}]: {TERMS[word]}" for word in ("NEES", "RMSE", "nats")) + "\n"
"""Terms that a reader finds explained under the pointer, wherever they stand."""
LINK = re.compile(r"(\]\()([^)#:\s]+)(#[^)]*)?\)")


def build(folder: Path) -> None:
    """Write everything anew."""
    shutil.rmtree(folder, ignore_errors=True)
    for place, content in (_texts() | _files()).items():
        path = folder / place
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content.encode() if isinstance(content, str) else content)


def _texts() -> dict[str, str]:
    """Place in the site -> Markdown, of every page."""
    origins = {f"docs/{path.name}": path.name for path in sorted(DOCS.glob("*.md"))} | PAGES
    texts = {place: _led(origin) for origin, place in origins.items()}
    texts["index.md"] = landing.landing(texts["index.md"])
    texts["tables.md"] = table_page.page({path.stem: _led(f"docs/tables/{path.name}") for path in table_page.TABLES})
    texts = {place: with_mathml(text) for place, text in (texts | environment_pages.pages()).items()}
    made = {"gallery.md": gallery.page()}
    made |= {"examples.md": example_pages.page(), "api.md": _api()}
    texts |= made | notebook_pages.pages()
    heads = {place: f"---\nsearch: {{{rule}}}\n---\n\n" for place, rule in SEARCH.items()}
    return {place: heads.get(place, "") + text + EXPLAINED for place, text in texts.items()}


def _files() -> dict[str, bytes]:
    """Place in the site -> content, of all that is not Markdown."""
    shown = [path for folder in ("figures", "site") for path in (DOCS / folder).rglob("*") if path.suffix in SHOWN]
    found = {path.relative_to(DOCS).as_posix(): path for path in shown} | {name: ROOT / name for name in PLAIN}
    contents = {place: path.read_bytes() for place, path in found.items()}
    return contents | gallery.files() | example_pages.files()


def _led(origin: str) -> str:
    """A file of the repository, its links led to places of the site."""
    text = (ROOT / origin).read_text(encoding="utf-8")
    depth = PAGES[origin].count("/") if origin in PAGES else 0
    return LINK.sub(lambda link: f"{link[1]}{'../' * depth}{_target(link[2], link[3] or '', origin)})", text)


def _target(link: str, anchor: str, origin: str) -> str:
    path = ((ROOT / origin).parent / link).resolve()
    name = path.relative_to(ROOT).as_posix()
    if path in table_page.TABLES:
        return f"tables.md#{table_page.anchor(path.stem, anchor.removeprefix('#'))}"
    if path.suffix == ".ipynb":
        return f"notebooks/{path.stem}.md"
    return PAGES.get(name, name.removeprefix("docs/")) + anchor


def _api() -> str:
    """One entry for each public name of the package; functions and classes with their docstrings."""
    entries = "\n\n".join(f"::: {_module(name)}.{name}" for name in sorted(jawenv.__all__, key=str.lower))
    return f"# API\n\nThe public names of `jawenv`: `import jawenv`, then `jawenv.NAME`.\n\n{entries}\n"


def _module(name: str) -> str:
    """Where a public name is defined; of a constant, from where it is imported."""
    value = getattr(jawenv, name)
    return str(value.__module__) if callable(value) else jawenv._HOMES[name]


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Write the site's pages as plain Markdown.")
    parser.add_argument("--output", type=Path, default=FOLDER)
    build(parser.parse_args().output)
