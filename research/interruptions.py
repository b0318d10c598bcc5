"""Stop each command at many moments by SIGKILL or SIGINT, give it again until it ends, and compare with a whole run.

    python -m research.interruptions --times 3 --seed 1

The moments are drawn between the end of loading and that of the whole run. What is compared are the contents of all
files but for what says when and for how long a command ran. Ends with 1 where something differs or is left by halves.
"""

import argparse
import json
import shutil
import signal
import sys
import tempfile
import time
import zipfile
from pathlib import Path

import numpy as np

from tests.stopping import finished, stopped, unfinished

TRAINING = """
algorithm: ppo
n_envs: 2
env: {kwargs: {control: targets, reward: worst, episode_s: 2.0}}
residual: {maneuver: opening_with_swings, scale: 2.0}
ppo: {n_steps: 5, batch_size: 10, network: {policy: [16], value: [16]}}
evaluation: {every_steps: 1000, patients: 2}
"""
STUDY = """
title: small
entries: [hold_still, slow_opening]
controls: [force]
patients: 4
seed: 20000
episode_s: 5
metrics: [worst_sd]
pairs: [[hold_still, slow_opening]]
"""
SMALL = ["--horizon-s", "4", "--patients", "2"]
GENERATIONS = ["--population", "4", "--generations", "6"]
COMMANDS = {
    "optimise": ["training", "optimise", "--refine", "chirp", "--output", "mine.yaml", *SMALL, *GENERATIONS],
    "train": ["training", "train", "d.yaml", "--continue", "--steps", "60", "--output", "run"],
    "study": ["eval", "study", "s.yaml", "--output", "out", "--workers", "2"],
    "export": ["training", "export", "run", "--output", "shared"],
}
TIMES = {"repeat.json", "mine.search.pkl"}
"""Files that say when a command ran."""


def main() -> int:
    """Stop them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--times", type=int, default=3)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("commands", nargs="*", default=list(COMMANDS))
    arguments = parser.parse_args()
    rng, faults = np.random.default_rng(arguments.seed), 0
    with tempfile.TemporaryDirectory() as folder:
        for name in arguments.commands:
            whole = prepared(Path(folder) / f"{name}-whole")
            if name == "export":
                finished(COMMANDS["train"], whole)
            start = time.monotonic()
            finished(COMMANDS[name], whole)
            length = time.monotonic() - start
            for signal_ in (signal.SIGKILL, signal.SIGINT):
                faults += broken(
                    name, whole, Path(folder) / f"{name}-{signal_.name}", signal_, length, arguments.times, rng
                )
    return 1 if faults else 0


def prepared(folder: Path) -> Path:
    """A folder with the files that the commands take."""
    folder.mkdir()
    (folder / "d.yaml").write_text(TRAINING)
    (folder / "s.yaml").write_text(STUDY)
    return folder


def broken(name, whole, folder, signal_, length, times, rng) -> bool:
    """Stop a command several times in a row; whether its files differ in the end from a whole run's."""
    prepared(folder)
    if name == "export":
        shutil.copytree(whole / "run", folder / "run")
    codes = []
    for _ in range(times):
        end = time.monotonic() + rng.uniform(0.3, 1.0) * length
        code, error = stopped(COMMANDS[name], folder, lambda end=end: time.monotonic() > end, signal_)
        codes.append(code)
        if code == 2:
            print(error)
        if name == "export" and (folder / "shared" / "card.json").exists():  # nothing is left to do
            shutil.rmtree(folder / "shared")
    finished(COMMANDS[name], folder)
    expected, actual = contents(whole), contents(folder)
    other = sorted(path for path in expected.keys() | actual.keys() if expected.get(path) != actual.get(path))
    left = unfinished(folder)
    print(
        f"{name:9s} {signal_.name}: exit codes {codes}, other: {other or 'nothing'}, left: {left or 'nothing'}",
        flush=True,
    )
    return bool(other or left or 2 in codes)


def contents(folder: Path) -> dict[str, object]:
    """Path of each file -> its content."""
    files = [path for path in folder.rglob("*") if path.is_file() and "tensorboard" not in path.parts]
    return {str(path.relative_to(folder)): content(path) for path in files if path.name not in TIMES}


def content(path: Path) -> object:
    """Content of a file without the time of its making."""
    if path.suffix == ".zip":
        with zipfile.ZipFile(path) as archive:
            return [archive.read(name) for name in ("policy.pth", "pytorch_variables.pth")]
    if path.suffix == ".parquet":
        from eval.kept.tables import rows_in

        return rows_in(path).to_json()
    if path.name == "card.json":
        return {key: value for key, value in json.loads(path.read_text()).items() if key != "commands"}
    if path.name == "study.md":
        return [line for line in path.read_text().splitlines() if "UTC" not in line]
    return path.read_bytes()


if __name__ == "__main__":
    sys.exit(main())
