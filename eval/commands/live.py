"""``python -m eval live``: the page of ``jawenv live`` with trained policies and agents of one's own."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from eval.commands import options
from jawenv.base.errors import InputError
from jawenv.base.seeds import REPORTS
from jawenv.envs.configuration import Configuration
from jawenv.playing.agents import Agent, Planning


@options.takes_world()
def _live_command(
    world: dict[str, Any],
    entries: Annotated[list[str], typer.Argument(metavar="MANEUVER|FILE|RUN|MODULE:NAME...", help=options.ENTRIES)],
    port: Annotated[int, typer.Option(help="Of the page on this machine; 0 takes a free one.", metavar="N")] = 8090,
    driver: Annotated[
        str | None, typer.Option(help="Who drives at first; the first entry by default.", metavar="NAME")
    ] = None,
    seed: options.Seed = REPORTS[0].start,
    output: Annotated[Path, typer.Option(help="Folder where drives are saved.", metavar="FOLDER")] = Path("runs/live"),
    open_browser: Annotated[bool, typer.Option("--open", help="Open the page in a browser.")] = False,
    trust: options.Trust = False,
) -> None:
    """Drive a jaw by hand beside agents of targets control, which one can take over from and give back to."""
    from eval.kept.entries import env_of_runs
    from jawenv.commands.live import drive
    from jawenv.live.setup import Setup

    asked = Configuration.from_mapping({"env": env_of_runs(entries)} | world)
    agents = _agents(entries, asked, trust)
    first = next(iter(agents)) if driver is None else driver
    drive(Setup(asked, seed), first, port, output, open_browser, agents)


def _agents(entries: list[str], world: Configuration, trust: bool) -> dict[str, Agent]:
    """Agents by their labels."""
    from eval.kept.entries import load_entries

    agents: dict[str, Agent] = {}
    for entry in load_entries(entries, world, trust=trust):
        if not entry.world.mode.takes_targets:
            raise InputError(f"{entry.label}: control {entry.world.control}; allowed: targets")
        if isinstance(entry.agent, Planning):
            raise InputError(f"{entry.label}: plans longer than a step of the live page lasts; allowed: other agents")
        agents[entry.label] = entry.agent
    return agents
