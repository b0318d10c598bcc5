"""A page for each environment, made of Gymnasium's registry, the docstring, the spaces and the arguments' types.

What an argument or an entry of the observation means stands once, in the tables of docs/environment.md.
"""

from __future__ import annotations

import inspect
import re
from pathlib import Path
from typing import Any

import arguments
import gymnasium as gym

import jawenv  # noqa: F401  registers the environments
from jawenv.envs.argument_checks import action_space, observation_space
from jawenv.envs.jaw import JawEnv
from jawenv.envs.observation import Parts
from jawenv.envs.registration import ENVIRONMENTS
from jawenv.ladder import KNOWN_WITHIN_SDS, MODELS, Model

REFERENCE = Path(__file__).parents[1] / "environment.md"
SECTION = re.compile(r"^## (.+)$", re.M)
MODEL_OF = {**ENVIRONMENTS, KNOWN_WITHIN_SDS: "jaw"}
SCAN = "the reference as a clinic would have it: anatomy and device known as a scan and a bench test show them"
FIRST = (
    "Choose an environment here: five models of the jaw with one interface, simplest first, and one known from a scan."
)
CAPTION = (
    "The first four seconds of *opening with swings* on one patient. The bluer a muscle, the better it is known. "
    "Made by `python docs/figures/draw_environments.py`. [All environments](index.md)."
)
FILM = """<picture class="film"><source media="(prefers-reduced-motion: reduce)" srcset="{folder}{title}.webp">\
<img src="{folder}{title}_film.webp" alt="The jaw of {title} from the side and from the front, opened with swings">\
</picture>"""


def pages() -> dict[str, str]:
    """Place in the site -> Markdown, for every registered environment and their overview."""
    made = {f"environments/{_title(env_id)}.md": _page(env_id, MODELS[model]) for env_id, model in MODEL_OF.items()}
    return {"environments/index.md": _overview()} | made


def _overview() -> str:
    """A card with the picture of each, and what they can show."""
    cards, rows = [], []
    for env_id, name in MODEL_OF.items():
        title, model = _title(env_id), MODELS[name]
        link, number = f"{title}.md", len(model.muscles.parameter_names)
        cards.append(f'<div class="card" markdown>\n\n### [{title}]({link})\n\n{_picture(env_id)}\n\n</div>')
        shows, hides = (SCAN, model.hides) if env_id == KNOWN_WITHIN_SDS else (model.shows, model.hides)
        rows.append(f"| [`{env_id}`]({link}) | {number} | {shows} | {hides} |")
    table = "\n".join(["| id | parameters | can show | cannot show |", "|---|--:|---|---|", *rows])
    return "\n\n".join(["# Environments", FIRST, '<div class="ways" markdown>', *cards, "</div>", table]) + "\n"


def _picture(env_id: str) -> str:
    title = _title(env_id)
    return f"![The jaw of {title} from the side and from the front](../figures/environments/{title}.webp)"


def _page(env_id: str, model: Model) -> str:
    """A film, then the sections of Gymnasium's own pages, in their order."""
    spec, title = gym.spec(env_id), _title(env_id)
    film = FILM.format(folder="../figures/environments/", title=title)
    parts = [f"# {title}", film, CAPTION, _facts(env_id, spec, model)]
    for heading, text in _docstring().items():
        text = _of_model(text, model) if heading in ("Description", "Action Space", "Observation Space") else text
        parts.append(f"## {heading}\n\n{text}")
        if heading == "Observation Space":
            parts.append(_observation(model))
        if heading == "Arguments":
            parts.append(arguments.table(spec.kwargs, types=True).rstrip())
    return "\n\n".join(parts) + "\n"


def _title(env_id: str) -> str:
    return env_id.removeprefix("jawenv/")


def _docstring() -> dict[str, str]:
    """Sections of the class's docstring; what stands before the first is left out."""
    text = inspect.cleandoc(JawEnv.__doc__ or "").replace("``", "`")
    _, *pieces = SECTION.split(text)
    return {title: body.strip() for title, body in zip(pieces[::2], pieces[1::2], strict=True)}


def _of_model(text: str, model: Model) -> str:
    """The docstring is of the reference environment; numbers that depend on the model are put in."""
    numbers = {name: len(MODELS[name].muscles.parameter_names) for name in ("jaw", model.name)}
    sizes = {name: Parts(number).size for name, number in numbers.items()}
    text = text.replace(f"({sizes['jaw']},)", f"({sizes[model.name]},)")
    return text.replace(f"all {numbers['jaw']} F_o", f"all {numbers[model.name]} F_o")


def _facts(env_id: str, spec: Any, model: Model) -> str:
    names = model.muscles.parameter_names
    space = observation_space(Parts(len(names)).size)
    rows = {
        "Import": f'`import jawenv`, then `gymnasium.make("{env_id}")`',
        "Vector form": f'`gymnasium.make_vec("{env_id}", num_envs=256)`, native',
        "Action space": f"`{action_space()}`",
        "Observation space": f"`{space}`",
        "Parameters": f"{len(names)}: " + ", ".join(f"`{name}`" for name in names),
        "Can show": SCAN if env_id == KNOWN_WITHIN_SDS else model.shows,
        "Cannot show": model.hides,
        "Mechanics of the truth": model.plant,
        "Entry points": f"`{spec.entry_point}`, `{spec.vector_entry_point}`",
    }
    return "\n".join([f"| id | `{env_id}` |", "|---|---|", *(f"| {name} | {value} |" for name, value in rows.items())])


def _observation(model: Model) -> str:
    """Where each part lies in this environment."""
    content = {_name(row[1]): row[2] for row in _table("Observation")}
    lines = ["| indices | name | content and scale |", "|---|---|---|"]
    for name, place in Parts(len(model.muscles.parameter_names)).layout.items():
        last = place.stop - 1
        indices = f"{place.start}–{last}" if last > place.start else f"{last}"
        lines.append(f"| {indices} | `{name}` | {content[name]} |")
    return "\n".join(lines)


def _table(heading: str) -> list[list[str]]:
    """Cells of the first table under a heading of the reference, links led from this folder."""
    section = REFERENCE.read_text(encoding="utf-8").split(f"\n## {heading}\n")[1]
    rows = re.search(r"(?:^\|.*\n)+", section, re.M)
    assert rows is not None
    text = re.sub(r"\]\((\w+\.md)?#", lambda link: f"](../{link[1] or REFERENCE.name}#", rows[0])
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in text.splitlines()[2:]]


def _name(cell: str) -> str:
    return cell.split("`")[1]
