"""The site's first page, made of the README: its opening beside the film, and its ways in as cards."""

from __future__ import annotations

QUESTION = "How stiff is each jaw muscle, and how soon is that known?"
BUTTONS = {"Drive a jaw": "live.md", "See maneuvers": "gallery.md", "See a report": "examples.md"}


def landing(readme: str) -> str:
    """The README's Markdown with its first screen arranged."""
    opening, ways, rest = _parts(readme)
    _, lead, film, caption, *begin = opening.split("\n\n")
    buttons = " ".join(f"[{words}]({place}){{ .md-button }}" for words, place in BUTTONS.items())
    return "\n\n".join(
        [
            "---\nhide: [navigation, toc]\ntitle: jawenv\n---",
            '<div class="hero" markdown>\n<div class="words" markdown>',
            f"# {QUESTION}",
            lead,
            buttons,
            '</div>\n<div class="film" markdown>',
            film,
            caption,
            "</div>\n</div>",
            *begin,
            _cards(ways),
            rest,
        ]
    )


def _parts(readme: str) -> tuple[str, str, str]:
    """What stands before the ways in, these, and what follows them."""
    opening, ways = readme.split("\n## Where to begin\n")
    ways, rest = ways.split("\n## ", 1)
    return opening.strip(), ways.strip(), "## " + rest


def _cards(ways: str) -> str:
    """The table of the ways in as cards, and what is said below it."""
    table, *after = ways.split("\n\n")
    rows = [line.strip("| ").split(" | ") for line in table.splitlines()[2:]]
    cards = [
        f'<div class="card" markdown>\n\n### You {who}\n\n{first}.\n{{ .first }}\n\nThen {then}.\n\n</div>'
        for who, first, then in rows
    ]
    return "\n\n".join(["## Where to begin", '<div class="ways" markdown>', *cards, "</div>", *after])
