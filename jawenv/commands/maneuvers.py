"""The commands ``jawenv score`` and ``jawenv play``."""

from __future__ import annotations

import numpy as np

from jawenv.envs.configuration import Configuration
from jawenv.metrics import score
from jawenv.playing.maneuvers import Player
from jawenv.playing.rollout import play as play_on


def print_score(maneuver: str, patients: int, seed: int, world: Configuration) -> None:
    """Play a maneuver on patients, and print what it found out.

    Raises:
        InputError: an unknown maneuver, or what the environment refuses.
    """
    player, env_id = Player(maneuver, control=world.control, control_hz=world.control_hz), world.env_id
    reached = score(play_on(player, patients=patients, seed=seed, env_kwargs=world.arguments, env_id=env_id))
    medians = (np.median(values, axis=0) for values in (reached.sd, np.abs(reached.error), reached.bound_sd))
    print(f"{player.name} in {env_id} on {patients} patients, medians over them\n")
    print(f"{'parameter':32s}{'claimed sd':>12}{'error':>9}{'bound':>9}")
    for name, sd, error, bound in zip(reached.parameter_names, *medians, strict=True):
        print(f"{name:32s}{sd:12.1%}{error:9.1%}{bound:9.1%}")
    for threshold, times in reached.time_to_s.items():
        share = np.isfinite(times).mean()
        middle = np.quantile(times, 0.5, method="inverted_cdf")
        words = f"{middle:.1f} s" if np.isfinite(middle) else "never"
        print(f"all known to {threshold:.0%}: {words} in the median, reached by {share:.0%}")
    information = f"{reached.information_true.mean():.1f} nats, {reached.information_claimed.mean():.1f} claimed"
    print(f"information: {information}")
    print(f"NEES: {reached.nees.mean():.1f} (honest: about {len(reached.parameter_names)})")
    print(f"discomfort: {reached.discomfort_s.mean():.2f} s, a hard limit crossed in {reached.violated.mean():.0%}")
    if reached.alarm:
        print(f"alarm: {reached.alarm}; do not trust their beliefs")
    if not world.build_knowledge().exact:
        print("the bound is that of a filter that knows the anatomy")


def play(maneuver: str, seed: int, world: Configuration) -> None:
    """Show one episode in a window.

    Raises:
        InputError: an unknown maneuver, no display, or what the environment refuses.
        MissingPackageError: pygame is not installed.
    """
    import gymnasium as gym

    import jawenv.envs.registration  # noqa: F401  (the ids)
    from jawenv.rendering.display import check_display

    player = Player(maneuver, control=world.control, control_hz=world.control_hz)
    check_display("a window", "use `jawenv live --driver NAME`, which shows it in a browser")
    env = gym.make(world.env_id, render_mode="human", **world.arguments)
    try:
        observation, info = env.reset(seed=seed)
        ended = False
        while not ended:
            action, _ = player.predict(observation)
            observation, _, terminated, truncated, info = env.step(action)
            ended = terminated or truncated
    finally:
        env.close()
    print(f"{player.name}: worst sd {info['belief_sd'].max():.1%} after {info['time']:.1f} s")
