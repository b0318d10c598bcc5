"""Estimate the stiffness of every closing muscle from a recording in a file (docs/recordings.md says what it holds).

python examples/estimate_from_a_recording.py --make runs/recording.csv
python examples/estimate_from_a_recording.py runs/recording.csv
"""

import argparse
import sys
from pathlib import Path

import jawenv
from agents import load_agent
from jawenv.recordings.files import save_record

MANEUVER = "opening_with_swings_and_fore_aft"


def make(path: Path, seconds: float) -> None:
    """Simulate one patient and write down what the device measures."""
    agent, env_kwargs = load_agent(MANEUVER), {"record": True, "episode_s": seconds}
    played = jawenv.play(agent, patients=1, seed=0, env_kwargs=env_kwargs)
    path.parent.mkdir(parents=True, exist_ok=True)
    save_record(played.records[0], path)
    print(f"{path}: {seconds:g} s of {MANEUVER.replace('_', ' ')}")


def main() -> None:
    """Read the command line."""
    parser = argparse.ArgumentParser(description="Estimate stiffness from a recording.")
    parser.add_argument("file", type=Path, help="a .csv or .parquet file")
    parser.add_argument("--make", action="store_true", help="simulate a recording and write it to the file")
    parser.add_argument("--seconds", type=float, default=30.0, help="how long, with --make")
    parser.add_argument("--cohort", help="population that the patient is believed to come from")
    given = parser.parse_args()
    if given.make:
        make(given.file, given.seconds)
    else:
        print(jawenv.identify(given.file, cohort=given.cohort))


if __name__ == "__main__":
    try:
        main()
    except jawenv.InputError as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(2)
