"""The motion of the first patient under an entry, as the scenes of a film."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.console import Console

from eval.comparison.results import Results
from eval.figures import words
from eval.kept.entries import Settings, load_entry
from jawenv.base.errors import InputError, shown
from jawenv.base.named_objects import is_named
from jawenv.envs.shown_world import build_scene
from jawenv.playing.agents import Action

if TYPE_CHECKING:
    from jawenv.rendering.scene import Scene

LARGEST_RATE = 10.0  # frames per second


def play_patient(
    study: Results,
    labels: Collection[str],
    console: Console,
    seed: int | None = None,
    *,
    trust: bool = False,
    own_modules: bool = False,
) -> Results:
    """The same results with the motions of one patient by the entries that can still be loaded.

    Args:
        study: a finished comparison.
        labels: of the entries that are played.
        console: where progress is shown, and who is not there any more.
        seed: of the patient; the first by default.
        trust: see ``load_entries``.
        own_modules: whether entries that are modules may be run, since the user has named them.
    """
    settings = Settings.of(**study.about["settings"])
    seed = settings.seed if seed is None else seed
    if seed not in settings.seeds:
        last = settings.seeds[-1]
        raise InputError(f"patient is {seed}; allowed: the seeds of the comparison, {settings.seed} to {last}")
    motions: dict[str, list[Scene]] = {}
    for metadata in study.about["entries"]:
        if (label := metadata["label"]) not in labels:
            continue
        scenes: list[Scene] = []
        try:
            if is_named(metadata["spec"]) and not (own_modules or trust):
                raise InputError(
                    f"{shown(metadata['spec'])} is a module, which runs code; allowed if you trust it: --trust"
                )
            with console.status(f"playing {words.label(label)}"):
                load_entry(metadata["spec"], settings.world, trust=trust).play(1, seed, on_step=_recorder(scenes))
        except InputError as error:
            console.print(f"not filmed: {words.label(label)} ({error})", soft_wrap=True)
        if scenes:
            motions[label] = scenes
    return replace(study, motions=motions, about=study.about | {"played_seed": seed})


def _recorder(scenes: list[Scene]) -> Callable[[Any, Action | None], None]:
    """Keeps a scene of the first patient now and then while the episode runs, as `jawenv.play` calls it."""
    step = 0

    def keep(env: Any, action: Action | None) -> None:
        nonlocal step
        simulation = env.unwrapped.simulation
        world, every = simulation.worlds[0], max(1, round(simulation.configuration.steps_per_s / LARGEST_RATE))
        runs = not world["truth"]["violated"] and np.isfinite(world["known"]["log_det"])
        if action is not None and step % every == 0 and runs:
            scenes.append(build_scene(simulation))
        step += 1

    return keep
