"""Gain by each optimisation of the kernels: processor time of a first start, and of a step, with and without it.

    python -m research.kernels --repeats 3
    python -m research.kernels --ship jawenv/kernels/shipped

Every variant runs in a process of its own, with an empty cache of kernels. It takes some minutes. The second form makes
what a wheel brings, for the Python that runs it: the kernels of the common models, for each processor in ``LEVELS``.
"""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
import tempfile
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any

import typer
from llvmlite import binding
from numba.core.serialize import dumps

from jawenv.base.files import atomic_write
from jawenv.kernels.cache import CHECKSUM_BYTES, LEVELS, with_checksum
from jawenv.kernels.compiled import WorldKernel

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
    "sizes in the message of an error": (
        "import jawenv.kernels.compiler as own, numba.np.arrayobj as numba_s; "
        "own._sizes_differ = numba_s.raise_with_shape_context"
    ),
}
"""Name -> action before jawenv's kernels are declared."""

COMMON = """
import sys
from pathlib import Path
import gymnasium as gym, jawenv
from jawenv.commands.app import main
from jawenv.live.session import DriveSession
from jawenv.live.setup import Setup

for env_id in ("jawenv/Jaw-v3", "jawenv/JawImaged-v3"):
    for control in ("force", "targets"):
        env = gym.make(env_id, control=control, track_bound=True)
        env.reset(seed=1)
        env.step(env.action_space.sample())
session = DriveSession(Setup.of(seed=500, episode_s=1.0))
session.hand_over("refined")
while not session.ended:
    session.drive()
recording = str(session.save(Path(sys.argv[1]))[1])
for knowledge in ("exact", "imaged", "bench"):
    main(["identify", recording, "--knowledge", knowledge])
"""
"""Program that plays the models with shipped kernels; one world and many share theirs."""

ALIKE = "import sys; from research.kernels import _compile_alike; _compile_alike(sys.argv[1])"


def measure(
    repeats: Annotated[int, typer.Option(help="Starts of every variant; the fastest counts.", min=1)] = 3,
    rounds: Annotated[int, typer.Option(help="Of 100 steps of 8 worlds; the fastest counts.", min=1)] = 20,
    ship: Annotated[
        Path | None, typer.Option(help="Measure nothing; add the kernels that a wheel brings.", metavar="FOLDER")
    ] = None,
) -> None:
    """Print a Markdown table."""
    if ship is not None:
        _make_shipped(ship)
        return
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
    environment = os.environ | {"JAWENV_CACHE_DIR": cache, "JAWENV_KERNELS_DIR": cache, "NUMBA_NUM_THREADS": "1"}
    command = [sys.executable, "-c", before + STEP, str(rounds)]
    output = subprocess.run(command, env=environment, check=True, capture_output=True, text=True).stdout
    start, step = map(float, output.split())
    return start, step


def _make_shipped(folder: Path) -> None:
    """Make the kernels of common models for every level."""
    with tempfile.TemporaryDirectory() as cache:
        make_cache(cache, COMMON)
        print(f"{folder}: {ship_cache(Path(cache), folder)} kernels")


def make_cache(cache: str, code: str) -> None:
    """Fill a cache with what some code calls, played for the last level, which most processors reach."""
    played, *others = reversed(LEVELS)
    for level, run in ((played, code), *((level, ALIKE) for level in others)):
        environment = {"NUMBA_CPU_NAME": level, "NUMBA_CPU_FEATURES": LEVELS[level]}
        environment |= {"JAWENV_CACHE_DIR": cache, "JAWENV_KERNELS_DIR": cache}
        subprocess.run([sys.executable, "-c", run, cache], env=os.environ | environment, check=True)


def ship_cache(cache: Path, folder: Path) -> int:
    """Add a cache's machine code to a folder of shipped kernels; returns how many there are."""
    files = _called_by_python(cache)
    for file in files:
        place = folder / file.parent.name / file.name
        place.parent.mkdir(parents=True, exist_ok=True)
        with atomic_write(place) as unfinished:
            unfinished.write_bytes(with_checksum(dumps(_machine_code_of(_parts(file)))))
    return len(files)


def _compile_alike(cache: str) -> None:
    """Compile for this process's level, unplayed, what the cache holds for another."""
    for file in _called_by_python(Path(cache)):
        _, described, _, signature, *_ = _parts(file)
        kernel: Any = getattr(import_module(described.modname), described.qualname)
        dispatcher: Any = kernel._kernel if isinstance(kernel, WorldKernel) else kernel._outer
        dispatcher.compile(signature.args)


def _called_by_python(cache: Path) -> list[Path]:
    return sorted(file for file in cache.rglob("*.kernel") if not file.parent.name.endswith("-linked"))


def _parts(file: Path) -> tuple[Any, ...]:
    """Parts that Numba keeps of a kernel: code, description, environment, signature and more."""
    parts: tuple[Any, ...] = pickle.loads(file.read_bytes()[CHECKSUM_BYTES:])
    return parts


def _machine_code_of(parts: tuple[Any, ...]) -> tuple[Any, ...]:
    """The same without LLVM code, of which the names that it defines stay, and without the listing of types."""
    (name, kind, (machine, code)), described, environment, signature, objects, lifted, _, *others = parts
    defined = [function.name for function in binding.parse_bitcode(code).functions if not function.is_declaration]
    names = "".join(f'define void @"{each}"() {{ ret void }}\n' for each in defined)
    library = name, kind, (machine, binding.parse_assembly(names).as_bitcode())
    return library, described, environment, signature, objects, lifted, "", *others


def main() -> None:
    """The command."""
    typer.run(measure)


if __name__ == "__main__":
    main()
