"""The motion of the first patient under an entry, as plain numbers for the report's JSON."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from typing import Any

import numpy as np
from rich.console import Console

from eval.comparison.results import Results
from eval.figures import words
from eval.kept.entries import Settings, load_entry
from jawenv.base.errors import InputError, shown
from jawenv.base.named_objects import is_named
from jawenv.playing.agents import Action

LARGEST_RATE = 10.0  # frames per second; between them the page interpolates


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
    settings = Settings.from_mapping(study.about["settings"])
    seed = settings.seed if seed is None else seed
    if seed not in settings.seeds:
        last = settings.seeds[-1]
        raise InputError(f"patient is {seed}; allowed: the seeds of the comparison, {settings.seed} to {last}")
    motions: dict[str, Any] = {}
    for metadata in study.about["entries"]:
        if (label := metadata["label"]) not in labels:
            continue
        recorder = _MotionRecorder()
        try:
            if is_named(metadata["spec"]) and not (own_modules or trust):
                raise InputError(
                    f"{shown(metadata['spec'])} is a module, which runs code; allowed if you trust it: --trust"
                )
            with console.status(f"playing {words.label(label)}"):
                load_entry(metadata["spec"], settings.world, trust=trust).play(1, seed, on_step=recorder)
        except InputError as error:
            console.print(f"not filmed: {words.label(label)} ({error})", soft_wrap=True)
        if recorder.motion():
            motions[label] = recorder.motion()
    return replace(study, motions=motions, about=study.about | {"played_seed": seed})


class _MotionRecorder:
    """Recorder of the first patient's motion, for ``jawenv.play`` (``on_step``)."""

    def __init__(self) -> None:
        """Nothing is seen yet."""
        self._step = 0
        self._motion: dict[str, Any] = {}

    def __call__(self, env: Any, action: Action | None) -> None:
        """Keep a frame now and then."""
        simulation = env.unwrapped.simulation
        every = max(1, round(simulation.configuration.steps_per_s / LARGEST_RATE))
        if action is not None and self._step % every == 0:
            self._keep(simulation)
        self._step += 1

    def motion(self) -> dict[str, Any]:
        """The record so far; lengths in mm, forces in N, sds of natural logs.

        Keys: ``muscles`` (M names), ``origin`` (M, 3), ``insertion`` (M, 3) and ``mouthpiece`` (3) in axes of the body,
        ``path`` (drop and frequency of the condyle's path), ``parameters`` and ``title``; and in
        ``frames``, of every frame, ``time_s``, ``contact`` (3), ``turn`` (3, rotation vector), ``tension`` (M),
        ``force`` (3), ``moved`` (opening, side, fore-aft) and ``sd`` (P).
        """
        return self._motion

    def _keep(self, simulation: Any) -> None:
        """Add a frame, as long as the episode runs."""
        from jawenv.envs.shown_world import build_scene

        world = simulation.worlds[0]
        if world["truth"]["violated"] or not np.isfinite(world["known"]["log_det"]):
            return
        scene = build_scene(simulation)
        if not self._motion:
            self._motion = beginning(scene)
        for name, value in _frame_of(scene).items():
            self._motion["frames"].setdefault(name, []).append(value)


def _frame_of(scene: Any) -> dict[str, Any]:
    """Values of one frame."""
    frame = {
        "time_s": scene.time_s,
        "contact": 1e3 * scene.contact_m,
        "turn": _rotation_vector(scene.rotation),
        "tension": scene.muscle_tension_N,
        "force": scene.mouthpiece_force_N,
        "moved": [scene.opening_mm, *scene.excursion_mm],
        "sd": scene.belief_sd,
    }
    return {name: _rounded(value) for name, value in frame.items()}


def beginning(scene: Any) -> dict[str, Any]:
    """Values common to all frames."""
    in_body = scene.rotation.T
    return {
        "muscles": list(scene.muscle_names),
        "origin": _rounded(1e3 * scene.muscle_origin_m),
        "insertion": _rounded(1e3 * (scene.muscle_insertion_m - scene.contact_m) @ in_body.T),
        "mouthpiece": _rounded(1e3 * in_body @ (scene.mouthpiece_m - scene.contact_m)),
        "path": [1e3 * scene.fossa_drop_m, 1e-3 * scene.fossa_frequency],
        "parameters": list(scene.parameter_names),
        "title": scene.title,
        "frames": {},
    }


def _rotation_vector(rotation: Any) -> Any:
    from scipy.spatial.transform import Rotation

    return Rotation.from_matrix(rotation).as_rotvec()


def _rounded(value: Any) -> Any:
    """Plain numbers with four significant digits, finer than a pixel."""
    array = np.asarray(value, dtype=np.float64)
    if array.ndim:
        return [_rounded(element) for element in array]
    return float(f"{array:.4g}")
