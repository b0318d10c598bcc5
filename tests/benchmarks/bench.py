"""Speed beside Gymnasium's Humanoid-v5, growth of memory, start-up times: `make bench`.

Speeds are those of whole episodes, medians of interleaved repeats, so that what else the machine does falls on all of
them alike. A target that is missed is reported as missed; the exit code says only whether the measurement ran. On a
busy machine look at the ratio, and at the processor time beside each elapsed one.
"""

import argparse
import ctypes
import gc
import os
import platform
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median

import gymnasium as gym
import numba
import numpy as np
from speeds import WORLDS, Row, Sinusoids, Size, humanoid, ladder_speeds, run_single, run_vector, say, sinusoids, speeds

import jawenv
from jawenv.playing.rollout import DEFAULT_ENV

HEAVY = ("torch", "matplotlib", "pymunk")
IMPORT = f"""
import sys, time
start = time.perf_counter()
import jawenv
print(time.perf_counter() - start, *[name for name in {HEAVY} if name in sys.modules])
"""
FIRST_STEP = """
import time
import gymnasium as gym, jawenv
env = gym.make("jawenv/Jaw-v3", control="force")
env.reset(seed=0)
env.step(env.action_space.sample())
print(time.time(), time.process_time())
"""


FULL, QUICK = Size(), Size(2, 500, 1.0, 1, 20_000, 1_000)


def bound_speed(size: Size) -> list[Row]:
    """The bound along a record of 30 s, 3000 ticks, in steps of Humanoid-v5; the first call compiles."""
    rows, reference_speed = [], humanoid()
    for env_id in (DEFAULT_ENV, "jawenv/JawPortions-v3"):
        say(f"bound: {env_id}")
        record = jawenv.play(Sinusoids(), patients=1, seed=0, env_kwargs={"record": True}, env_id=env_id).records[0]
        jawenv.bound_along(record, every=5)
        times = []
        for _ in range(size.repeats):
            start = time.perf_counter()
            jawenv.bound_along(record, every=5)
            elapsed = time.perf_counter() - start
            times.append((elapsed, elapsed * reference_speed(500)))
        seconds, steps = np.median(times, axis=0)
        reference = env_id == DEFAULT_ENV
        rows += [
            Row(f"bound along {len(record.time) - 1} ticks of {env_id}", f"{1e3 * seconds:.0f} ms"),
            Row(
                "  in steps of Humanoid-v5, median of paired ratios",
                f"{steps:.0f}",
                "<= 100" if reference else "",
                bool(steps <= 100.0) if reference else None,
            ),
        ]
    return rows


def resident_mib() -> float:
    """Memory that this process occupies now, without what a collection or the allocator would give back."""
    gc.collect()
    if sys.platform == "linux":
        if platform.libc_ver()[0] == "glibc":
            ctypes.CDLL(None).malloc_trim(0)
        return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 2**20
    return int(subprocess.check_output(["ps", "-o", "rss=", "-p", str(os.getpid())])) / 2**10


def growth(run: Callable[[int], object], steps: int, what: str) -> Row:
    """Growth of memory over `steps`, after a tenth of them as warm-up."""
    for tenth in range(11):
        say(f"memory: {what}, {f'{10 * tenth} %' if tenth else 'warm-up'}")
        run(steps // 10)
        if tenth == 0:
            before = resident_mib()
    grown = resident_mib() - before  # over a million steps, one byte lost in each would show
    return Row(f"memory growth, {what}", f"{grown:+.2f} MiB of {before:.0f}", "< 1 MiB", grown < 1.0)


def memory(size: Size) -> list[Row]:
    vec, jaw = (
        gym.make_vec("jawenv/Jaw-v3", num_envs=WORLDS, control="force"),
        gym.make("jawenv/Jaw-v3", control="force"),
    )
    vec.reset(seed=0)
    jaw.reset(seed=0)
    calls, alone = size.memory_env_steps // WORLDS // 10 * 10, size.memory_single_steps
    return [
        growth(
            lambda n: run_vector(vec, sinusoids(WORLDS), n), calls, f"{WORLDS} worlds, {calls * WORLDS:,} env-steps"
        ),
        growth(lambda n: run_single(jaw, sinusoids(None), n), alone, f"one environment, {alone:,} steps"),
    ]


def child(code: str, **environment: str) -> str:
    command = [sys.executable, "-c", code]
    return subprocess.run(
        command, check=True, stdout=subprocess.PIPE, text=True, env=os.environ | environment, timeout=600
    ).stdout


def start_up(size: Size) -> list[Row]:
    """Import time, what it drags in, and the time to the first step; the kernels are cached by now."""
    say("start-up")
    imports = [child(IMPORT).split() for _ in range(size.repeats)]
    heavy = sorted({name for _, *names in imports for name in names})
    seconds = median(float(first) for first, *_ in imports)
    firsts = []
    for _ in range(size.repeats):
        start = time.time()
        end, processor_s = map(float, child(FIRST_STEP).split())
        firsts.append((end - start, processor_s))
    first, busy = (median(column) for column in zip(*firsts, strict=True))
    say("start-up: without a cache")
    with tempfile.TemporaryDirectory() as cache:
        start = time.time()
        cold = float(child(FIRST_STEP, JAWENV_CACHE_DIR=cache, JAWENV_KERNELS_DIR=cache).split()[0]) - start
    return [
        Row("import jawenv, fresh process", f"{seconds:.2f} s", "<= 1 s", seconds <= 1.0),
        Row(f"  of {', '.join(HEAVY)} it imports", ", ".join(heavy) or "none", "none", not heavy),
        Row("process start to end of first step", f"{first:.2f} s", "<= 2 s", first <= 2.0),
        Row("  processor time of that", f"{busy:.2f} s"),
        Row("the same where the kernels have to be compiled", f"{cold:.0f} s", "<= 60 s", cold <= 60.0),
    ]


def processor() -> str:
    source = Path("/proc/cpuinfo")
    lines = source.read_text().splitlines() if source.exists() else []
    return next((line.partition(":")[2].strip() for line in lines if "model name" in line), platform.machine())


def show(load_before: tuple[float, float, float], rows: list[Row]) -> None:
    load, threads = os.getloadavg(), numba.get_num_threads()
    print(f"{processor()}, {os.cpu_count()} cores, {threads} threads for worlds; {platform.platform()}")
    print(f"load average (1 min): {load_before[0]:.2f} before, {load[0]:.2f} after")
    print(f"Python {platform.python_version()}, Numba {numba.__version__}, Gymnasium {gym.__version__}")
    what, value, target = (max(len(str(row[i])) for row in rows) for i in range(3))
    for row in rows:
        verdict = "" if row.met is None else "met" if row.met else "missed"
        print(f"{row.what:<{what}}  {row.value:>{value}}  {row.target:<{target}}  {verdict}".rstrip())


def main() -> None:
    parser = argparse.ArgumentParser(description="Measure speed, growth of memory and start-up of jawenv.")
    parser.add_argument("--quick", action="store_true", help="small numbers, to see that it runs")
    size = QUICK if parser.parse_args().quick else FULL
    parts = (speeds, bound_speed, memory, start_up, ladder_speeds)
    show(os.getloadavg(), [row for part in parts for row in part(size)])


if __name__ == "__main__":
    main()
