"""What MkDocs does not do by itself: pages from other folders, generated pages, notebooks, formulas without scripts."""

from __future__ import annotations

import re
import sys
from html import unescape
from pathlib import Path
from typing import Any

from latex2mathml.converter import convert
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
sys.path[:0] = [str(HERE), str(ROOT)]

import environment_pages  # noqa: E402
import example_pages  # noqa: E402
import gallery  # noqa: E402
import landing  # noqa: E402
import notebook_pages  # noqa: E402

import jawenv  # noqa: E402
from eval.report.template import TERMS  # noqa: E402

PAGES = {"README.md": "index.md"} | {
    name: name
    for name in (
        "agents/README.md",
        "training/README.md",
        "eval/README.md",
        "CHANGELOG.md",
        "CONTRIBUTING.md",
        "SECURITY.md",
    )
}
"""Pages outside docs/: where they lie in the repository, and in the site."""
PLAIN = ("LICENSE", "CITATION.cff")
EXPLAINED = "\n\n" + "\n".join(f"*[{word}]: {TERMS[word]}" for word in ("NEES", "RMSE", "nats"))
"""Terms that a reader finds explained under the pointer, wherever they stand."""
LINK = re.compile(r"(\]\()([^)#:\s]+)((?:#[^)]*)?\))")
MATRIX = re.compile(r"<mo>(&#x00028;|&#x0005B;)</mo>(<mtable>.*?</mtable>)<mo>(&#x00029;|&#x0005D;)</mo>")
FUNCTION = re.compile(
    r"(<mi>(?:arccos|arctan|cos|det|exp|ln|log|max|min|sin|tan)</mi>)(?=<m(?:i|n|sub|sup|over|frac|subsup)>)"
)
LONG_NAME = re.compile(r"(?<=<code>)\w{21,}(?=</code>)")
FORMULA = re.compile(r'<(span|div) class="arithmatex">\\([(\[])(.*?)\\[)\]]</\1>', re.S)


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add what does not lie in docs/."""

    def add(place: str, content: str | bytes) -> None:
        files.append(File.generated(config, place, content=content))

    for source, place in PAGES.items():
        text = (ROOT / source).read_text(encoding="utf-8")
        add(place, landing.landing(text) if source == "README.md" else text)
    for name in PLAIN:
        add(name, (ROOT / name).read_bytes())
    for place, content in (environment_pages.pages() | notebook_pages.pages()).items():
        add(place, content)
    for place, shown in (gallery.files() | example_pages.files()).items():
        add(place, shown)
    add("gallery.md", gallery.page())
    add("examples.md", example_pages.page())
    add("api.md", _api())
    return files


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """Turn links between places in the repository into links between places in the site."""
    place = page.file.src_uri
    origin = next((source for source, known in PAGES.items() if known == place), f"docs/{place}")
    if origin in PAGES or (ROOT / origin).exists():
        markdown = LINK.sub(lambda link: link[1] + _target(link[2], origin, place) + link[3], markdown)
    return markdown + EXPLAINED


def on_page_content(html: str, **_: Any) -> str:
    """Formulas become MathML, which browsers draw without a script; long names may break after an underscore."""

    def drawn(formula: re.Match[str]) -> str:
        maths = str(convert(unescape(formula[3]), display="block" if formula[2] == "[" else "inline"))
        maths = MATRIX.sub(r'<mrow><mo form="prefix">\1</mo>\2<mo form="postfix">\3</mo></mrow>', maths)
        return FUNCTION.sub(r'\1<mspace width="0.17em"/>', maths)

    html = LONG_NAME.sub(lambda name: name[0].replace("_", "_<wbr>"), html)
    return FORMULA.sub(drawn, html)


def on_post_page(output: str, **_: Any) -> str:
    """The theme's search box says what it is."""
    search = 'data-md-component="search" role="dialog"'
    return output.replace(search, f'{search} aria-label="Search"')


def _target(link: str, origin: str, place: str) -> str:
    """A link in a file of the repository, as seen from the page that is made of it."""
    path = ((ROOT / origin).parent / link).resolve()
    if not path.is_relative_to(ROOT):
        return link
    name = path.relative_to(ROOT).as_posix()
    inside = PAGES.get(name, name.removeprefix("docs/"))
    return "../" * place.count("/") + inside


def _api() -> str:
    """One entry for each public name of the package; functions and classes with their docstrings."""
    entries = "\n\n".join(f"::: {_module(name)}.{name}" for name in sorted(jawenv.__all__, key=str.lower))
    return f"# API\n\nThe public names of `jawenv`: `import jawenv`, then `jawenv.NAME`.\n\n{entries}\n"


def _module(name: str) -> str:
    """Where a public name is defined; of a constant, from where it is imported."""
    value = getattr(jawenv, name)
    return str(value.__module__) if callable(value) else jawenv._HOMES[name]
