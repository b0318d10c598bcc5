"""A run's policy as it is shared: plain weights, a card, and a README made of the card."""

from __future__ import annotations

import re
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import yaml

from agents.evaluations import FILE as EVALUATIONS
from agents.evaluations import read_evaluations
from jawenv.base.errors import InputError, reason_of
from jawenv.base.files import write_text
from jawenv.base.locks import alone
from jawenv.base.reading import read_text
from jawenv.playing.policies.card import CARD, WEIGHTS, ModelCard, Result, read_card
from jawenv.playing.policies.plain import read_weights, write_policy
from training.run.folder import RunFolder

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
"""Licences that the Hub knows by these names, in small letters."""
_TAGS = ["reinforcement-learning", "gymnasium", "system-identification", "biomechanics", "simulation"]
_TASK = "reinforcement-learning"


def export(
    run: RunFolder,
    output: Path,
    *,
    results: tuple[Result, ...] = (),
    licence: str = "MIT",
    command: str = "",
    overwrite: bool = False,
) -> ModelCard:
    """Write a run's best policy, its card with results, and its evaluations into a folder of its own.

    Args:
        run: the run.
        output: the new folder.
        results: figures of the policy.
        licence: under which the weights are given.
        command: how the user asked for it.
        overwrite: replace an exported policy in the folder.

    Returns:
        The card as written.
    """
    run.check_holds_run()
    if run.best_model.exists():
        raise InputError(
            f"{run.best_model}: a card describes no such environment or network; allowed: a run that has {CARD}"
        )
    card_of_run = read_card(run.path)
    weights = read_weights(run.path, card_of_run)
    evaluated = read_text(run.evaluations) if read_evaluations(run.path) else None
    today = datetime.now(UTC).date()
    changes = {
        "results": results,
        "licence": licence,
        "date": today,
        "commands": (*card_of_run.commands, command),
    }
    card = ModelCard(**(dict(card_of_run) | changes))
    with alone(output):
        _check_free(output, overwrite)
        try:
            output.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"output {output}: cannot be made: {reason_of(error)}") from None
        write_text(output / README, readme(output.resolve().name, card))
        (output / EVALUATIONS).unlink(missing_ok=True)
        if evaluated is not None:
            write_text(output / EVALUATIONS, evaluated)
        write_policy(output, weights, card)
    return card


def _check_free(output: Path, overwrite: bool) -> None:
    """Make sure that the folder is new, empty, or an exported policy that may be replaced."""
    try:
        if output.exists() and not output.is_dir():
            raise InputError(f"output {output} is a file; name a folder")
        present = {path.name for path in output.iterdir()} if output.exists() else set()
    except OSError as error:
        raise InputError(f"output {output}: cannot be read: {reason_of(error)}") from None
    if present - {CARD, WEIGHTS, README, EVALUATIONS}:
        raise InputError(f"output {output} is a folder that holds something other than an exported policy")
    if CARD in present and not overwrite:  # weights alone were left by an export that was stopped
        raise InputError(f"output {output} already holds an exported policy; replace it with --overwrite")


def readme(name: str, card: ModelCard) -> str:
    """The README of a policy: its card for readers and for the Hugging Face Hub.

    The header is the Hub's metadata (https://huggingface.co/docs/hub/model-cards). It is made of the card alone, so
    that the two never differ.
    """
    header = yaml.safe_dump(metadata(card), sort_keys=False, allow_unicode=True, width=110)
    return f"---\n{header}---\n\n{_body(name, card)}"


def metadata(card: ModelCard) -> dict[str, Any]:
    """The Hub's metadata: licence, library and tags."""
    licence = card.licence
    named = (
        {"license": licence.lower()} if licence in _LICENCES else {"license": "other", "license_name": _slug(licence)}
    )
    header: dict[str, Any] = {
        **named,
        "library_name": "jawenv",
        "pipeline_tag": _TASK,
        "tags": [*_TAGS, _flat(card.algorithm)],
    }
    return header


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
