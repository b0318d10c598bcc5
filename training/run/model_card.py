"""The README.md of an exported policy: what its card says, for readers and for the Hugging Face Hub.

The header is the Hub's metadata (https://huggingface.co/docs/hub/model-cards). It is made of the card alone, so that
the two never differ.
"""

from __future__ import annotations

import re
from typing import Any

import yaml

from agents.card import ModelCard, Result

README = "README.md"

_LICENCES = {
    "MIT",
    "Apache-2.0",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "CC0-1.0",
    "CC-BY-4.0",
    "CC-BY-SA-4.0",
    "CC-BY-NC-4.0",
    "GPL-3.0",
    "LGPL-3.0",
    "MPL-2.0",
}
"""Those that the Hub knows by these names, in small letters."""
_TAGS = ["reinforcement-learning", "gymnasium", "system-identification", "biomechanics", "simulation"]
_TASK = "reinforcement-learning"


def readme(name: str, card: ModelCard) -> str:
    """The text of the README.

    Args:
        name: of the policy.
        card: what it is, and what it reached.
    """
    header = yaml.safe_dump(metadata(name, card), sort_keys=False, allow_unicode=True, width=110)
    return f"---\n{header}---\n\n{_body(name, card)}"


def metadata(name: str, card: ModelCard) -> dict[str, Any]:
    """The Hub's metadata: licence, library, tags, and each figure with its interval."""
    licence = card.licence
    named = (
        {"license": licence.lower()} if licence in _LICENCES else {"license": "other", "license_name": _slug(licence)}
    )
    about: dict[str, Any] = {
        **named,
        "library_name": "jawenv",
        "pipeline_tag": _TASK,
        "tags": [*_TAGS, _flat(card.algorithm)],
    }
    if card.results:
        about["model-index"] = [{"name": _flat(name), "results": [_entry(result, card) for result in card.results]}]
    return about


def _entry(result: Result, card: ModelCard) -> dict[str, Any]:
    first, last = result.seeds
    kind, value = _figure(result)
    args = {"statistic": kind, "low": result.low, "high": result.high, "level": result.level}
    patients = {"patients": result.patients, "first_seed": first, "last_seed": last}
    return {
        "task": {"type": _TASK, "name": _flat(card.environment.id)},
        "dataset": {
            "type": f"{_flat(card.environment.id)}/{_slug(result.cohort)}",
            "name": f"{result.patients} simulated patients of {_flat(result.cohort)}, seeds {first} to {last}",
            "args": patients,
        },
        "metrics": [{"type": _slug(result.metric), "name": _flat(result.metric), "value": value, "args": args}],
    }


def _figure(result: Result) -> tuple[str, float]:
    if result.median is not None:
        return "median", result.median
    assert result.mean is not None
    return "mean", result.mean


def _body(name: str, card: ModelCard) -> str:
    environment = card.environment
    does = "moves the jaw" if card.residual is None else f"corrects the maneuver `{card.residual.maneuver.name}`"
    lines = [
        f"# {_flat(name)}",
        "",
        f"A policy that {does} in jawenv, a [Gymnasium](https://gymnasium.farama.org) environment in which maneuvers",
        "are designed that show how stiff each jaw muscle of a patient with trismus is. **All patients are simulated:",
        "nothing here may move a real jaw.**",
        "",
        "| | |",
        "|---|---|",
        f"| environment | `{_cell(environment.id)}`, {environment.control} control at {environment.control_hz:g} Hz, "
        f"sensors {environment.sensors}, reward {_cell(environment.reward)} |",
        f"| trained on | {_cell(_cohort(environment.cohort))}, episodes of {environment.episode_s:g} s |",
        f"| network | {' - '.join(map(str, card.architecture.layers))}, {card.architecture.activation} |",
        f"| training | {_cell(card.algorithm)}, {card.steps:,} steps, seed {card.seed} |",
        f"| exported by | jawenv {_cell(card.jawenv_version)} |",
        f"| licence of the weights | {_cell(card.licence)} |",
        "",
        "## Use",
        "",
        "```python",
        "from agents import load_agent  # of a clone of jawenv",
        "",
        f'agent = load_agent("{re.sub(r"[^A-Za-z0-9_.-]", "_", name)}", control="{environment.control}")',
        "```",
        "",
        "`card.json` holds all that is known of the policy, and the hash of `policy.safetensors`. Loading",
        "it runs no code.",
        "",
    ]
    return "\n".join(lines + _results(card))


def _results(card: ModelCard) -> list[str]:
    if not card.results:
        return []
    rows = []
    for result in card.results:
        kind, value = _figure(result)
        on = f"{result.patients} of {result.cohort}, seeds {result.seeds[0]} to {result.seeds[1]}"
        interval = f"{result.low:g} to {result.high:g} ({100 * result.level:g} %)"
        rows.append(f"| {_cell(result.metric)} | {_cell(on)} | {kind} {value:g} | {interval} |")
    return ["## Results", "", "| figure | simulated patients | value | interval |", "|---|---|---|---|", *rows, ""]


def _cohort(cohort: object) -> str:
    named = cohort if isinstance(cohort, str) else cohort.get("name") if isinstance(cohort, dict) else None
    return f"cohort {named or 'of its own'}"


def _flat(text: str) -> str:
    """A text in one line: a line of its own could end the header."""
    return " ".join(text.split())


def _cell(text: str) -> str:
    """A text in one cell of a table."""
    return _flat(text).replace("|", "\\|")


def _slug(text: str) -> str:
    return re.sub(r"[^a-z0-9.]+", "-", text.lower()).strip("-") or "unnamed"
