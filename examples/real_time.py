"""Feed a recording to the filter as a device's loop does, 100 times a second, and say what is known meanwhile.

    python examples/real_time.py                                # 5 s of a simulated patient
    python examples/real_time.py runs/recording.csv --fast      # a file, without waiting

A line a second has the largest sd of the parameters, which of them it is, and the misfit (above 1 nothing that the
filter could believe explains the readings). The last lines have the times of an update. A few updates filter all
readings so far again, and take as long as those did; while one runs, readings have to wait.
"""

import argparse
import sys
import time
from pathlib import Path

import numpy as np

import jawenv
from agents import load_agent
from jawenv.recordings.files import load_record
from jawenv.recordings.record import Record

MANEUVER = "opening_with_swings_and_fore_aft"


def simulated(seconds: float) -> Record:
    """What the device reads of one simulated patient."""
    played = jawenv.play(load_agent(MANEUVER), patients=1, seed=0, env_kwargs={"record": True, "episode_s": seconds})
    record: Record = played.records[0]
    return record


def wait_until(moment: float) -> float:
    """Sleep until the clock shows ``moment``; returns how late it is, s."""
    left = moment - time.perf_counter()
    if left > 0.0:
        time.sleep(left)
    return max(0.0, time.perf_counter() - moment)


def replay(record: Record, fast: bool) -> None:
    """Feed every reading at its time, and print once a second what is known."""
    online = jawenv.OnlineFilter.of_record(record)
    updates_s, begun, late_s = [], time.perf_counter(), 0.0
    for tick, measured in enumerate(record.measured):
        if not fast:
            late_s = max(late_s, wait_until(begun + tick * record.dt))
        before = time.perf_counter()
        belief = online.update(measured, record.samples[tick - 1] if tick else None)
        updates_s.append(time.perf_counter() - before)
        if tick and tick % round(1.0 / record.dt) == 0:
            worst = int(np.argmax(belief.log_sd))
            name = belief.names[worst].removeprefix("log_")
            print(f"{belief.time_s:4.0f} s: all within {100 * belief.log_sd[worst]:5.1f} % ({name}), ", end="")
            print(f"misfit {belief.misfit:.2f}", flush=True)
    times_us = 1e6 * np.array(updates_s)
    print(f"{len(times_us)} updates: median {np.median(times_us):.0f} us, worst {times_us.max():.0f} us, ", end="")
    print(f"{np.sum(times_us > 1e6 * record.dt)} longer than {1e3 * record.dt:g} ms")
    if not fast:
        print(f"a reading was taken {1e3 * late_s:.1f} ms late at worst")


def main() -> None:
    """Read the command line."""
    parser = argparse.ArgumentParser(description="Identify from a recording in real time.")
    parser.add_argument("file", type=Path, nargs="?", help="a .csv or .parquet file; without, a patient is simulated")
    parser.add_argument("--seconds", type=float, default=5.0, help="how much of it")
    parser.add_argument("--fast", action="store_true", help="do not wait for the clock")
    given = parser.parse_args()
    if not given.seconds > 0.0:
        raise jawenv.InputError(f"seconds is {given.seconds:g}; allowed: more than 0")
    record = simulated(given.seconds) if given.file is None else load_record(given.file)
    replay(record if given.seconds >= record.time[-1] else record.until(given.seconds), given.fast)


if __name__ == "__main__":
    try:
        main()
    except jawenv.InputError as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(2)
