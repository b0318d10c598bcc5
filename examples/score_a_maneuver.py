"""Play a maneuver file on simulated patients and print what it found out, and whether that can be believed.

    python examples/score_a_maneuver.py examples/opening_with_circles.yaml --patients 32

For a comparison with other maneuvers and a report use `python -m eval compare`.
"""

import argparse
import sys
from pathlib import Path

import numpy as np

import jawenv
from agents import load_agent
from jawenv.controls import CONTROLS, DEFAULT_CONTROL
from jawenv.ladder import model_of_env

FILE = Path(__file__).parent / "opening_with_circles.yaml"


def main() -> None:
    """Read the command line, play and print."""
    parser = argparse.ArgumentParser(description="Score a maneuver file.")
    parser.add_argument("maneuver", nargs="?", default=FILE, help="maneuver file, or the name of a hand-made one")
    parser.add_argument("--patients", type=int, default=16)
    parser.add_argument("--episode-s", type=float, default=30.0)
    parser.add_argument("--control", choices=[*CONTROLS], default=DEFAULT_CONTROL)
    parser.add_argument("--env", default="jawenv/Jaw-v3", help="id of the environment, e.g. jawenv/JawSides-v3")
    given = parser.parse_args()

    env_id = model_of_env(given.env).env_id
    agent = load_agent(given.maneuver, control=given.control, env_id=env_id)
    env_kwargs = {"control": given.control, "episode_s": given.episode_s}
    recording = jawenv.play(agent, patients=given.patients, seed=0, env_kwargs=env_kwargs, env_id=env_id)
    score = jawenv.score(recording)

    print(f"{agent.name} in {env_id} on {given.patients} patients of the default cohort, {given.episode_s:g} s each\n")
    print("parameter                        claimed sd   rms error     bound   (median, rms, median over the patients)")
    rms = np.sqrt(np.mean(score.error**2, axis=0))
    for i, name in enumerate(score.parameter_names):
        sd, bound = np.median(score.sd[:, i]), np.median(score.bound_sd[:, i])
        print(f"{name:32s} {sd:10.1%} {rms[i]:11.1%} {bound:9.1%}")
    print(
        f"\ninformation: {np.mean(score.information_true):.1f} nats, {np.mean(score.information_claimed):.1f} claimed"
    )
    print(f"NEES: {np.mean(score.nees):.1f} (calibrated: about {len(score.parameter_names)})")
    print(f"discomfort: {np.mean(score.discomfort_s):.2f} s, a hard limit crossed in {np.mean(score.violated):.0%}")
    if score.alarm:
        print(f"alarm: {score.alarm}; do not trust their beliefs")


if __name__ == "__main__":
    try:
        main()
    except jawenv.InputError as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(2)
