"""Search the multisine maneuver that could teach most: optimal experiment design by the bound, within comfort.

    python examples/optimise_maneuver.py --output my_maneuver.yaml

The D criterion (Goodwin & Payne 1977, chapter 6): half the fall of log det of the posterior Cramer-Rao bound, in nats
at the end of an episode, mean over patients, less what discomfort costs. Each channel is the sum of two sines on
multiples of 1/30 Hz, whose frequencies, phases, ratio and peak are searched by differential evolution (Storn & Price
1997). About a second per evaluation with eight patients on one core; the same seed gives the same file.
"""

import argparse
import sys
from pathlib import Path

import numpy as np
import yaml
from numpy.typing import NDArray
from scipy.optimize import differential_evolution

import jawenv
from agents import load_agent, names
from jawenv.maneuvers.maneuver import Maneuver
from jawenv.maneuvers.player import Player
from jawenv.seeds import REPORTS, TUNING

PERIOD_S = 30.0
TRAIN_SEED, TEST_SEED = TUNING.start, REPORTS[1].start
# Nats that a second of cost 1, a patient whose hard limit is crossed, a share of time with the governor at work, and a
# mm/s too fast are worth. The hand-made maneuvers cost 0.002 to 0.013 s.
PER_DISCOMFORT_S, PER_VIOLATION, PER_GOVERNOR, PER_SPEED = 100.0, 200.0, 100.0, 1.0
RANGE_MM, SPEED_MM_S = np.array([25.0, 6.0]), 23.0  # opening and side range of a typical patient; targets no faster

# Of each channel: two frequencies (multiples of 1/30 Hz), share of the second, two phases (degrees), peak; of the
# opening also its lowest value. The start is the motion of opening_with_swings_and_fore_aft, and some roll.
LOW = {
    "opening": [1, 2, 0.0, -180, -180, 0.6, 0.01],
    "side": [1, 1, 0.0, -180, -180, 0.3],
    "fore_aft": [1, 1, 0.0, -180, -180, 0.05],
    "roll": [1, 1, 0.0, -180, -180, 0.0],
}
HIGH = {
    "opening": [4, 6, 0.5, 180, 180, 0.95, 0.4],
    "side": [10, 10, 0.5, 180, 180, 0.95],
    "fore_aft": [10, 10, 0.5, 180, 180, 0.4],
    "roll": [10, 10, 0.5, 180, 180, 0.9],
}
START = {
    "opening": [2, 3, 0.05, -90, 0, 0.9, 0.02],
    "side": [7, 3, 0.05, 0, 0, 0.75],
    "fore_aft": [4, 5, 0.3, 0, 180, 0.2],
    "roll": [6, 9, 0.05, 0, 0, 0.4],
}
PER_CHANNEL = {name: len(low) for name, low in LOW.items()}


def channel(name: str, numbers: NDArray) -> dict[str, object]:
    """A channel of a maneuver file from its numbers; rounded, so that the file is what was judged."""
    first, second, share, phase, other_phase, peak = numbers[:6]
    weights, cycles = np.array([1.0 - share, share]), np.round([first, second])
    phases = np.round([phase, other_phase])
    t = np.arange(0.0, PERIOD_S, 0.01)
    wave = np.sin(2.0 * np.pi * np.multiply.outer(t, cycles) / PERIOD_S + np.deg2rad(phases)) @ weights
    low, high = wave.min(), wave.max()
    if name == "opening":
        scale = (peak - numbers[6]) / (high - low)
        extra = {"offset": round(float(peak - scale * high), 3)}
    else:
        scale = peak / max(high, -low, 1e-9)
        extra = {}
    harmonics = [
        {"frequency_hz": round(float(c) / PERIOD_S, 6), "amplitude": round(float(scale * w), 3), "phase_deg": float(p)}
        for c, w, p in zip(cycles, weights, phases, strict=True)
    ]
    return {"kind": "harmonics", **extra, "harmonics": harmonics}


def content(numbers: NDArray) -> dict[str, object]:
    """A maneuver file's content from all numbers."""
    ends = np.cumsum(list(PER_CHANNEL.values()))[:-1]
    parts = dict(zip(PER_CHANNEL, np.split(numbers, ends), strict=True))
    return {
        "name": "information_optimal",
        "title": "Information-optimal multisine",
        "description": (
            "Sums of two sines on opening, side, fore-aft force and roll whose frequencies, phases and sizes were "
            "searched for the most information by the Cramer-Rao bound within comfort."
        ),
        "source": "examples/optimise_maneuver.py; D-optimal input design, Goodwin and Payne 1977, chapter 6",
        "fade_in_s": 3,
        "channels": {name: channel(name, part) for name, part in parts.items()},
    }


def fastest_mm_s(maneuver: Maneuver) -> float:
    """Largest speed of the targets of opening and side on a typical patient."""
    rate = maneuver.targets(np.arange(0.0, PERIOD_S, 0.05)).rate[:, :2]
    return float(np.linalg.norm(rate * RANGE_MM, axis=1).max())


def loss(numbers: NDArray, patients: int, episode_s: float) -> float:
    """Minus the mean information of the bound (nats), and what discomfort is worth."""
    maneuver = Maneuver.model_validate(content(numbers))
    too_fast = max(0.0, fastest_mm_s(maneuver) - SPEED_MM_S)
    settings = {"episode_s": episode_s}
    score = jawenv.score(jawenv.play(Player(maneuver), patients=patients, seed=TRAIN_SEED, env_kwargs=settings))
    return float(
        -np.mean(score.information_bound)
        + PER_DISCOMFORT_S * np.mean(score.discomfort_s)
        + PER_VIOLATION * np.mean(score.violated)
        + PER_GOVERNOR * np.mean(score.governor)
        + PER_SPEED * too_fast
    )


def search(patients: int, evaluations: int, seed: int, episode_s: float) -> NDArray:
    """The best numbers found."""
    low, high, start = (np.concatenate(list(table.values())) for table in (LOW, HIGH, START))
    generator = np.random.default_rng(seed)
    members = len(low)
    # Half the first population lies near the start: a wide one would need many more evaluations.
    spread = np.where(np.arange(members) < members // 2, 0.1, 0.4)[:, None]
    first = np.clip(start + spread * (high - low) * generator.standard_normal((members, len(low))), low, high)
    first[0] = start
    whole = np.array([k < 2 for size in PER_CHANNEL.values() for k in range(size)])
    done, best = 0, np.inf

    def judge(numbers: NDArray) -> float:
        nonlocal done, best
        value = loss(numbers, patients, episode_s)
        done, best = done + 1, min(best, value)
        if done % 10 == 0:
            print(f"{done} of about {evaluations}: best {-best:.2f} nats after penalties", file=sys.stderr, flush=True)
        return value

    found = differential_evolution(
        judge,
        list(zip(low, high, strict=True)),
        init=first,
        integrality=whole,
        maxiter=max(evaluations // members - 1, 0),
        mutation=(0.3, 0.8),
        recombination=0.6,
        tol=0.0,
        polish=False,
        rng=generator,
    )
    return np.asarray(found.x)


def compare(path: Path, patients: int, episode_s: float) -> None:
    """Print the file beside the hand-made maneuvers, on patients that the search has not seen."""
    print(f"{patients} patients, seeds {TEST_SEED} and on, force control; means over the patients\n")
    print("maneuver                           bound, nats   true, nats   discomfort, s   violated   governor")
    for spec in [str(path), *(name for name in names() if name != path.stem)]:
        settings = {"episode_s": episode_s}
        score = jawenv.score(jawenv.play(load_agent(spec), patients=patients, seed=TEST_SEED, env_kwargs=settings))
        row = (score.information_bound, score.information_true, score.discomfort_s, score.violated, score.governor)
        bound, true, discomfort, violated, governor = (float(np.mean(value)) for value in row)
        name = Path(spec).stem
        print(f"{name:34s} {bound:11.2f} {true:12.2f} {discomfort:15.4f} {violated:10.0%} {governor:10.2%}", flush=True)


def main() -> None:
    """Read the command line, search, write the file and compare it."""
    parser = argparse.ArgumentParser(description="Search the maneuver with the most information by the bound.")
    parser.add_argument("--patients", type=int, default=8, help="patients that each candidate is played on")
    parser.add_argument("--evaluations", type=int, default=500, help="candidates to play, about; 25 or more are")
    parser.add_argument("--seed", type=int, default=0, help="of the search")
    parser.add_argument("--episode-s", type=float, default=30.0)
    parser.add_argument("--test-patients", type=int, default=32, help="other patients, for the comparison; 0 for none")
    parser.add_argument("--output", type=Path, required=True, help="maneuver file to write (.yaml)")
    given = parser.parse_args()
    for name, least in (("patients", 1), ("evaluations", 1), ("seed", 0), ("test_patients", 0)):
        if getattr(given, name) < least:
            raise jawenv.InputError(f"{name}: {getattr(given, name)} given, allowed is {least} or more")
    if given.output.suffix != ".yaml" or not given.output.parent.is_dir():
        raise jawenv.InputError(f"output: {given.output} given, allowed is a .yaml file in a folder that exists")

    best = search(given.patients, given.evaluations, given.seed, given.episode_s)
    command = (
        f"python examples/optimise_maneuver.py --patients {given.patients} --evaluations {given.evaluations} "
        f"--seed {given.seed} --episode-s {given.episode_s:g}"
    )
    comment = f"# Found, not made by hand, by\n# {command}\n"
    text = yaml.safe_dump(content(best), sort_keys=False, width=110, default_flow_style=None)
    given.output.write_text(comment + text, encoding="utf-8")
    print(f"written: {given.output}", file=sys.stderr)
    if given.test_patients:
        compare(given.output, given.test_patients, given.episode_s)


if __name__ == "__main__":
    try:
        main()
    except jawenv.InputError as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(2)
