"""Worth of each mechanism of the filter, and of each gentle number of the device.

Each row leaves one of them out, and is run by a process of its own that compiles the filter so. A cell is the mean
NEES over the number of parameters, with its 95 % interval over patients, and the largest of a patient. Prints a table
in Markdown; takes some minutes for each row. A second table is of what lasts: errors of the model at a pose, with a
scan's anatomy or beside a disturbance with memory.

    python -m research.ablation --patients 64 --seed 6000
    python -m research.ablation --patients 24 --seed 6000 --table lasting
"""

import argparse
import importlib
import json
import math
import os
import subprocess
import sys
import tempfile
from typing import Any, NamedTuple

import numpy as np

from jawenv.controls import Control
from jawenv.device.device import TICK
from jawenv.filter.learn import learn
from jawenv.filter.model.motion_step import move
from jawenv.filter.readings.lasting import stay_of
from jawenv.kernels.compiled import njit
from jawenv.mechanics.kinematics import angle_rates, contact_point

FILTER = "jawenv.filter."
SCAN = "jawenv/JawImaged-v3"
STIFF_SERVO = {"servo_stiffness_N_m": 2500.0, "servo_damping_N_s_m": 15.0}


class _Variant(NamedTuple):
    """A filter or device without one mechanism: other constants or kernels of modules, other fields of the device."""

    what: str
    constants: dict[str, Any] = {}
    device: dict[str, float] = {}


class _Scenario(NamedTuple):
    """An agent on a cohort."""

    agent: str
    control: Control
    cohort: str = "trismus"
    env_id: str = "jawenv/Jaw-v3"
    seconds: float = 30.0
    device: dict[str, float] = {}

    def __str__(self) -> str:
        return ", ".join(
            [
                f"`{self.agent}`",
                *([self.env_id.removeprefix("jawenv/")] if self.env_id == SCAN else []),
                self.control,
                self.cohort,
                *([f"{self.seconds:.0f} s"] if self.seconds != 30.0 else []),
                *(f"{name}={value}" for name, value in self.device.items()),
            ]
        )


@njit
def _deriving(jaw, motion, samples, dt, derive, scratch):
    """Stand in for ``move``: the Jacobian along the motion that this tick's reading has moved."""
    move(jaw, motion, samples, dt, True, scratch)


@njit
def _rows_of_the_motion(jaw, belief, used, scratch):
    """Stand in for ``set_rows_of_past``: the rows at that motion."""


@njit
def _at_constant_rates(jaw, before, after):
    """Stand in for ``middle_of``: muscle lines where the tick's first rates lead by half way."""
    half, share = before.shape[0] // 2, 0.5 * TICK
    first = half - 3  # of the angles
    pose = (before[0], before[1], before[first], before[first + 1], before[first + 2])
    turning = angle_rates(pose, (before[half + first], before[half + first + 1], before[half + first + 2]))
    x, y = before[0] + share * before[half], before[1] + share * before[half + 1]
    pose = (x, y, pose[2] + share * turning[0], pose[3] + share * turning[1], pose[4] + share * turning[2])
    return pose, contact_point(jaw, pose)


@njit
def as_read(jaw, belief, pose, scratch):
    """Stand in for ``set_balanced_trend``: the load cell's trend as it is."""
    scratch.trend[:] = belief.trend


@njit
def _without_inertia(jaw, belief, pose, dt, scratch):
    """Stand in for ``set_inertia_column`` and do nothing."""


@njit
def whole(jaw, belief, settings):
    """Stand in for ``weight_of_stay``: every reading counts whole."""
    return 1.0


@njit
def _ticks_of_a_visit(jaw, belief, settings):
    """Stand in for ``count_ticks``: earlier visits are forgotten."""
    return 0.0 if settings.whole > 0.0 else stay_of(jaw, belief, settings.dt)


class _Biting:
    """Motors that press the jaw forwards onto its teeth by a constant command."""

    name = "biting"

    def reset(self, num_envs: int, seed: int | None = None) -> None:
        """Nothing is remembered."""

    def predict(
        self, observation: Any, state: Any = None, episode_start: Any = None, deterministic: bool = True
    ) -> tuple[Any, None]:
        return np.tile(np.array([-1.0, -1.0, 1.0, 1.0], np.float32), (*np.shape(observation)[:-1], 1)), None


class _Corners(_Biting):
    """Motors held at a corner of their range, each world at the next of the 16."""

    name = "corners"

    def predict(
        self, observation: Any, state: Any = None, episode_start: Any = None, deterministic: bool = True
    ) -> tuple[Any, None]:
        world = np.arange(np.shape(observation)[0])[:, None]
        return (1.0 - 2.0 * (world >> np.arange(4) & 1)).astype(np.float32), None


HELD = {agent.name: agent for agent in (_Biting, _Corners)}
ROWS = (
    _Variant("the filter as it is"),
    _Variant("no gate", {"updates.measurement_update.GATE": math.inf}),
    _Variant("nothing refused is taken", {"updates.measurement_update.WIDE": math.inf}),
    _Variant("early readings not filtered again", {"tick.LAST_WINDOW": 0}),
    _Variant("windows up to 80 readings alone", {"tick.LAST_WINDOW": 80}),
    _Variant("surprises do not renew the belief", {"tick.SURPRISING": 99}),
    _Variant("every window filtered again", {"tick.MOVED": 0.0}),
    _Variant("nodes do not follow the belief", {"belief.refocus.SHRINKS": 0.0, "belief.refocus.STRAYS": math.inf}),
    _Variant("belief linearised at its mean alone", {"belief.posterior.NEGLIGIBLE": math.inf}),
    _Variant("series of the second order", {"model.motion_step.ORDER": 2}),
    _Variant(
        "Jacobian and rows along the tick's own motion",
        {"updates.time_update.move": _deriving, "updates.measurement_update.set_rows_of_past": _rows_of_the_motion},
    ),
    _Variant("predicted from the first reading on", {"updates.instrument.FIRST_READINGS": 0}),
    _Variant("muscle lines at constant rates", {"updates.time_update.middle_of": _at_constant_rates}),
    _Variant("teeth whose force is certain", {"readings.teeth.TOOTH_NOISE": (0.0,) * 6}),
    _Variant("learning while teeth press", {"tick.NEAR": -math.inf}),
    _Variant("teeth as believed alone, and not as read", {"readings.teeth.COARSEST": 0.0}),
    _Variant("nothing wrong at a pose", {"settings.LASTING": 0.0}),
    _Variant("the gain's column as the cell reads", {"updates.time_update.set_balanced_trend": as_read}),
    _Variant("the gain error without inertia", {"updates.time_update.set_inertia_column": _without_inertia}),
    _Variant("the point follows the belief", {"learn.conclude": learn}),
    _Variant("motors of 50 N/s", device={"slew_N_s": 50.0}),
    _Variant("load cell of 0.07 N", device={"cell_force_N": 0.07, "cell_moment_N_m": 0.0014}),
    _Variant("servos of 2,500 N/m and 15 N s/m", device=STIFF_SERVO),
)
CELLS = (
    _Scenario("open_and_hold", "targets", "severe"),
    _Scenario("opening_with_swings_and_fore_aft", "force"),
    _Scenario("random", "force"),
    _Scenario("open_and_hold", "force"),
    _Scenario("opening_with_swings_and_fore_aft", "trajectory"),
    _Scenario("ou_slow", "trajectory"),
    _Scenario("ou_strong", "force", "wide"),
    _Scenario("slow_opening", "force", "wide"),
    _Scenario("random", "targets", "one_sided"),
    _Scenario("biting", "force"),
    _Scenario("biting", "trajectory"),
)
LASTING_ROWS = (
    _Variant("the filter as it is"),
    _Variant("each visit of a pose by itself", {"readings.lasting.count_ticks": _ticks_of_a_visit}),
    _Variant("every reading counts whole", {"tick.weight_of_stay": whole}),
)
HALF, SECOND = {"unmodelled_time_s": 0.5}, {"unmodelled_time_s": 1.0}
LASTING_CELLS = (
    _Scenario("examples/one_channel.yaml", "targets", env_id=SCAN, seconds=60.0),
    _Scenario("slow_opening", "targets", env_id=SCAN, seconds=120.0),
    _Scenario("refined", "targets", env_id=SCAN),
    _Scenario("slow_opening", "targets", "severe", device=SECOND),
    _Scenario("open_and_hold", "targets", seconds=120.0, device=HALF),
    _Scenario("refined", "targets", device=HALF),
    _Scenario("open_and_hold", "targets", seconds=300.0),
)
TABLES = {"point": (ROWS, CELLS), "lasting": (LASTING_ROWS, LASTING_CELLS)}


def measure(row: _Variant, cells: tuple[_Scenario, ...], patients: int, seed: int) -> list[list[float]]:
    """NEES over the number of parameters of every patient at the end, for each cell."""
    for constant, value in row.constants.items():
        module, _, name = constant.rpartition(".")
        target = importlib.import_module(FILTER + module)
        if not hasattr(target, name):
            raise SystemExit(f"error: {constant} is no constant of the filter")
        setattr(target, name, value)
    import jawenv
    from agents import load_agent

    by_cell = []
    for cell in cells:
        kwargs: dict[str, Any] = {"control": cell.control, "cohort": cell.cohort, "device": row.device | cell.device}
        kwargs |= {"episode_s": cell.seconds, "track_bound": False}
        agent = HELD[cell.agent]() if cell.agent in HELD else load_agent(cell.agent, control=cell.control)
        played = jawenv.play(agent, patients=patients, seed=seed, env_id=cell.env_id, env_kwargs=kwargs)
        error = played.at_end(played.belief_mean) - played.truth
        nees = np.einsum("np,npq,nq->n", error, np.linalg.inv(played.at_end(played.belief_cov)), error)
        by_cell.append((nees / error.shape[1]).tolist())
        print(f"  {cell}: done", file=sys.stderr, flush=True)
    return by_cell


def shown(values: list[float]) -> str:
    mean, half = np.mean(values), 1.96 * np.std(values) / np.sqrt(len(values))
    return f"{mean:.2f} ± {half:.2f} ({np.max(values):.2g})" if np.isfinite(mean) else "lost"


def main() -> None:
    parser = argparse.ArgumentParser(description="Measure what each mechanism of the filter is worth.")
    parser.add_argument("--patients", type=int, default=64)
    parser.add_argument("--seed", type=int, default=6000, help="of the first patient; tuning's are 5000 to 19999")
    parser.add_argument("--only", type=int, nargs="+", help="numbers of the rows to make, from 0")
    parser.add_argument("--table", choices=TABLES, default="point")
    parser.add_argument("--row", type=int, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    table, cells = TABLES[arguments.table]
    if arguments.row is not None:
        print(json.dumps(measure(table[arguments.row], cells, arguments.patients, arguments.seed)))
        return
    rows = list(enumerate(table)) if arguments.only is None else [(number, table[number]) for number in arguments.only]
    print("| left out |" + "".join(f" {cell} |" for cell in cells))
    print("|---|" + len(cells) * "--:|", flush=True)
    for number, row in rows:
        print(f"{row.what} ({number + 1} of {len(table)})", file=sys.stderr, flush=True)
        command = [sys.executable, "-m", "research.ablation", *sys.argv[1:], "--row", str(number)]
        with tempfile.TemporaryDirectory() as cache:
            # The kernels of a filter that lacks something must not be taken for those of the whole one.
            places = {"JAWENV_CACHE_DIR": cache} if row.constants else {}
            ran = subprocess.run(command, env=os.environ | places, stdout=subprocess.PIPE, text=True, check=True)
        print(f"| {row.what} |" + "".join(f" {shown(cell)} |" for cell in json.loads(ran.stdout)), flush=True)


if __name__ == "__main__":
    main()
