"""What is played back in the report: how an entry moves the first patient, as plain numbers for JSON."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from jawenv.controls import CONTROLS
from jawenv.errors import InputError
from jawenv.files import atomic_write
from jawenv.playing.protocol import Action, Mask, Observation, State
from jawenv.reading import read_bytes

LARGEST_RATE = 10.0  # frames per second; between them the page interpolates


class Watched:
    """An agent that is played as ever, and leaves behind what happens to the first of its patients.

    Args:
        agent: who plays.

    Attributes:
        name: that of the agent.
        control: that of the agent; None if it names none.
    """

    def __init__(self, agent: Any) -> None:
        self._agent = agent
        self.name: str = agent.name
        self.control = getattr(agent, "control", None)
        self._motion: dict[str, Any] | None = None

    def reset(self, num_envs: int, seed: int | None = None) -> None:
        """See ``jawenv.playing.protocol.Agent.reset``."""
        if hasattr(self._agent, "reset"):
            self._agent.reset(num_envs, seed)

    def attach(self, env: Any) -> None:
        """See ``jawenv.playing.protocol.Planning.attach``; called once, before the first step."""
        if hasattr(self._agent, "attach"):
            self._agent.attach(env)
        self._simulation = env.unwrapped.simulation
        rate = self._simulation.configuration.steps_per_s
        self._every = max(1, round(rate / LARGEST_RATE))
        self._step = 0
        self._motion = None

    def predict(
        self,
        observation: Observation,
        state: State = None,
        episode_start: Mask | None = None,
        deterministic: bool = True,
    ) -> tuple[Action, State]:
        """See ``jawenv.playing.protocol.Agent.predict``."""
        action, after = self._agent.predict(observation, state, episode_start, deterministic)
        if self._step % self._every == 0:
            self._keep(np.atleast_2d(action)[0])
        self._step += 1
        return action, after

    def motion(self) -> dict[str, Any]:
        """What was seen so far; lengths in mm, forces in N, sds of natural logs.

        Keys: ``muscles`` (M names), ``origin`` (M, 3), ``insertion`` (M, 3) and ``mouthpiece`` (3) in axes of the body,
        ``path`` (drop and frequency of the condyle's path), ``parameters``, ``commands`` (names) and ``title``; and in
        ``frames``, of every frame, ``time_s``, ``contact`` (3), ``turn`` (3, rotation vector), ``tension`` (M),
        ``force`` (3), ``command`` (4, of -1 to 1), ``moved`` (opening, side, fore-aft) and ``sd`` (P).
        """
        return self._motion or {}

    def _keep(self, action: Action) -> None:
        """Add a frame, as long as the episode runs."""
        from jawenv.envs.shown_world import build_scene

        world = self._simulation.worlds[0]
        if world["truth"]["violated"] or not np.isfinite(world["known"]["log_det"]):
            return
        scene = build_scene(self._simulation)
        if self._motion is None:
            self._motion = _beginning(scene, self._simulation.configuration.control)
        frame = {
            "time_s": scene.time_s,
            "contact": 1e3 * scene.contact_m,
            "turn": _rotation_vector(scene.rotation),
            "tension": scene.muscle_tension_N,
            "force": scene.mouthpiece_force_N,
            "command": action,
            "moved": [scene.opening_mm, *scene.excursion_mm],
            "sd": scene.belief_sd,
        }
        for name, value in frame.items():
            self._motion["frames"].setdefault(name, []).append(_rounded(value))


def _beginning(scene: Any, control: str) -> dict[str, Any]:
    """What is the same in all frames."""
    in_body = scene.rotation.T
    return {
        "muscles": list(scene.muscle_names),
        "origin": _rounded(1e3 * scene.muscle_origin_m),
        "insertion": _rounded(1e3 * (scene.muscle_insertion_m - scene.contact_m) @ in_body.T),
        "mouthpiece": _rounded(1e3 * in_body @ (scene.mouthpiece_m - scene.contact_m)),
        "path": [1e3 * scene.fossa_drop_m, 1e-3 * scene.fossa_frequency],
        "parameters": list(scene.parameter_names),
        "commands": list(CONTROLS[control].commanded),
        "title": scene.title,
        "frames": {},
    }


def _rotation_vector(rotation: Any) -> Any:
    from scipy.spatial.transform import Rotation

    return Rotation.from_matrix(rotation).as_rotvec()


def _rounded(value: Any) -> Any:
    """Plain numbers with four significant digits, which is finer than a pixel."""
    array = np.asarray(value, dtype=np.float64)
    if array.ndim:
        return [_rounded(each) for each in array]
    return float(f"{array:.4g}")


def save(motions: dict[str, Any], path: Path) -> None:
    """Write the motions of entries, by their labels, wholly or not at all.

    Raises:
        InputError: the file cannot be written.
    """
    with atomic_write(path) as unfinished:
        unfinished.write_text(json.dumps(motions, separators=(",", ":")), encoding="utf-8")


def load(path: Path) -> dict[str, Any]:
    """Read what `save` has written; nothing where there is no such file, as in older studies.

    Raises:
        InputError: the file is damaged.
    """
    if not path.exists():
        return {}
    text = read_bytes(path)
    try:
        motions = json.loads(text)
    except (ValueError, RecursionError) as error:
        reason = " ".join(str(error).split())[:120]
        raise InputError(f"{path} is damaged ({reason}); delete it: the report is then without playback") from None
    if not isinstance(motions, dict):
        raise InputError(f"{path} holds a {type(motions).__name__}, allowed are motions by the names of entries")
    return motions
