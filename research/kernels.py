"""Gain by each optimisation of the kernels: processor time of a first start, and of a step, with and without it.

    python -m research.kernels --repeats 3

Every variant runs in a process of its own, with an empty cache of kernels. It takes some minutes.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from typing import Annotated

import typer

STEP = """
import sys, time, resource
import gymnasium as gym, jawenv

world = gym.make_vec("jawenv/Jaw-v3", num_envs=8, control="force")
world.reset(seed=1)
actions = world.action_space.sample()
world.step(actions)
spent = resource.getrusage(resource.RUSAGE_SELF)
best = float("inf")
for _ in range(int(sys.argv[1])):
    start = time.perf_counter()
    for _ in range(100):
        world.step(actions)
    best = min(best, (time.perf_counter() - start) / 800)
print(spent.ru_utime + spent.ru_stime, 1e6 * best)
"""
VARIANTS = {
    "as it is": "",
    "every kernel compiled by itself, none linked": (
        "import numba; numba.version_info = numba.version_info._replace(short=(0, 0))"
    ),
    "cycles collected while compiling": "import gc; gc.disable = lambda: None",
}
"""Name -> action before jawenv's kernels are declared."""


def measure(
    repeats: Annotated[int, typer.Option(help="Starts of every variant; the fastest counts.", min=1)] = 3,
    rounds: Annotated[int, typer.Option(help="Of 100 steps of 8 worlds; the fastest counts.", min=1)] = 20,
) -> None:
    """Print a Markdown table."""
    print("| variant | first start, s of a processor | second start, s | step, µs |\n|---|--:|--:|--:|")
    for name, before in VARIANTS.items():
        cold, warm = [], []
        for _ in range(repeats):
            with tempfile.TemporaryDirectory() as cache:
                cold.append(_run(before, rounds, cache))
                warm.append(_run(before, rounds, cache))
        step = min(time for _, time in (*cold, *warm))
        print(f"| {name} | {min(cold)[0]:.1f} | {min(warm)[0]:.1f} | {step:.1f} |", flush=True)


def _run(before: str, rounds: int, cache: str) -> tuple[float, float]:
    """Processor time up to the end of the first step, s, and of a step of one world, µs."""
    environment = os.environ | {"JAWENV_CACHE_DIR": cache, "NUMBA_NUM_THREADS": "1"}
    command = [sys.executable, "-c", before + STEP, str(rounds)]
    output = subprocess.run(command, env=environment, check=True, capture_output=True, text=True).stdout
    start, step = map(float, output.split())
    return start, step


def main() -> None:
    """The command."""
    typer.run(measure)


if __name__ == "__main__":
    main()
