"""Worth of each mechanism of the filter: what it reads is recorded once, and filtered again without one of them.

Each row leaves one out, and is run by a process of its own that compiles the filter so; all filter the same readings.
A cell is the mean NEES over the number of parameters at an eighth, a quarter and the end of an episode, the worst error
bar at its end as a multiple of the first row's (geometric mean), and how many beliefs end beyond 10. Prints a table in
Markdown; takes some minutes for each row.

    python -m research.ablation --patients 32 --seed 6000
"""

import argparse
import importlib
import json
import math
import os
import pickle
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

import jawenv
from agents import load_agent
from jawenv.controls import Control
from jawenv.filter.learn import learn
from jawenv.filter.readings.model_error import dwell_ticks
from jawenv.kernels.compiled import njit
from jawenv.recordings.online import OnlineFilter
from jawenv.recordings.record import Record
from research._beliefs import Beliefs, head, row

FILTER = "jawenv.filter."
SCAN = "jawenv/JawImaged-v3"
LOST = 10.0  # NEES over the number of parameters
EVERY = 5  # ticks from one belief to the next


class _Variant(NamedTuple):
    """A filter without one mechanism: other constants or kernels of modules."""

    what: str
    constants: dict[str, Any] = {}


class _Cell(NamedTuple):
    """An agent on a cohort."""

    agent: str
    cohort: str
    seconds: float = 10.0
    control: Control = "targets"
    env_id: str = "jawenv/Jaw-v3"

    def __str__(self) -> str:
        scan = ["a scan's anatomy"] if self.env_id == SCAN else []
        return ", ".join([f"`{self.agent}`", *scan, self.control, self.cohort, f"{self.seconds:g} s"])


@njit
def as_read(jaw, belief, pose, scratch):
    """Stand in for ``set_balanced_trend``: the load cell's trend as it is."""
    scratch.trend[:] = belief.trend


@njit
def _without_inertia(jaw, belief, pose, dt, scratch):
    """Stand in for ``set_inertia_column`` and do nothing."""


@njit
def _without_model_error(jaw, belief, settings, variance):
    """Stand in for ``add_model_error`` and do nothing."""


@njit
def full_weight(jaw, belief, settings):
    """Stand in for ``reading_weight``: every reading counts in full."""
    return 1.0


@njit
def _ticks_of_a_visit(jaw, belief, settings):
    """Stand in for ``count_ticks``: earlier visits are forgotten."""
    return 0.0 if settings.full_weight_ticks > 0.0 else dwell_ticks(jaw, belief, settings.dt)


ROWS = (
    _Variant("the filter as it is"),
    _Variant("each visit of a pose by itself", {"readings.model_error.count_ticks": _ticks_of_a_visit}),
    _Variant("no ticks at a pose that count whole", {"settings.FULL_WEIGHT_TICKS": 0.0}),
    _Variant("one share of the force that may be wrong", {"settings.MODEL_ERROR_EXACT": 2e-3}),
    _Variant("nothing wrong at a pose as noise of the motion", {"tick.add_model_error": _without_model_error}),
    _Variant("every reading counts whole", {"tick.reading_weight": full_weight}),
    _Variant("the gain error without inertia", {"updates.time_update.set_inertia_column": _without_inertia}),
    _Variant("the gain's column as the cell reads", {"updates.time_update.set_balanced_trend": as_read}),
    _Variant("one trend of the load cell, of 50 ms", {"tick.SMOOTHING_TIME": 0.05}),
    _Variant("nothing refused is taken", {"updates.measurement_update.PATIENCE": 10**9}),
    _Variant("predicted from the first reading on", {"updates.instrument.FIRST_READINGS": 0}),
    _Variant("nodes do not follow the belief", {"belief.refocus.SHRINKS": 0.0, "belief.refocus.STRAYS": math.inf}),
    _Variant("belief linearised at its mean alone", {"belief.posterior.NEGLIGIBLE": math.inf}),
    _Variant("the point follows the belief", {"learn.conclude": learn}),
    _Variant("surprises do not renew the belief", {"tick.SURPRISING": 99}),
    _Variant("early readings not filtered again", {"tick.LAST_WINDOW": 0}),
    _Variant("teeth whose force is certain", {"readings.teeth.TOOTH_NOISE": (0.0,) * 6}),
    _Variant("learning while teeth press", {"tick.LEAST_GAP": -math.inf}),
    _Variant("no gate", {"updates.measurement_update.GATE": math.inf}),
)
CELLS = (
    _Cell("refined", "trismus"),
    _Cell("refined", "one_sided"),
    _Cell("slow_opening", "severe"),
    _Cell("opening_with_swings_and_fore_aft", "anyone"),
    _Cell("apg_anyone", "anyone"),
    _Cell("open_and_hold", "trismus", 120.0),
    _Cell("random", "trismus", 20.0, "force"),
    _Cell("ou_strong", "wide", 20.0, "force"),
    _Cell("refined", "one_sided", env_id=SCAN),
    _Cell("apg_anyone", "one_sided", env_id=SCAN),
    _Cell("open_and_hold", "one_sided", 120.0, env_id=SCAN),
)


def recorded(cell: _Cell, patients: int, seed: int) -> list[tuple[Record, NDArray[np.float64]]]:
    """The readings of each patient, and the natural logs of the true parameters."""
    kwargs: dict[str, Any] = {"control": cell.control, "cohort": cell.cohort, "episode_s": cell.seconds}
    kwargs |= {"record": True, "track_bound": False}
    if cell.agent.startswith("apg"):
        kwargs["comfort_budget_s"] = 1.0 / 30.0
    agent = load_agent(cell.agent, control=cell.control)
    number = max(4, round(patients * min(1.0, 20.0 / cell.seconds)))
    played = jawenv.play(agent, patients=number, seed=seed, env_id=cell.env_id, env_kwargs=kwargs)
    return [
        (record, truth) for record, truth in zip(played.records or (), played.truth, strict=True) if record is not None
    ]


def measure(variant: _Variant, cells: list[list[tuple[Record, NDArray[np.float64]]]]) -> list[list[list[float]]]:
    """NEES over the number of parameters, thrice, and log of the worst sd at the end, of each patient of each cell."""
    for constant, value in variant.constants.items():
        module, _, name = constant.rpartition(".")
        target = importlib.import_module(FILTER + module)
        if not hasattr(target, name):
            raise SystemExit(f"error: {constant} is no constant of the filter")
        setattr(target, name, value)
    found = []
    for patients in cells:
        found.append([_filtered(record, truth) for record, truth in patients])
        print(f"  {len(found)} of {len(cells)} cells", file=sys.stderr, flush=True)
    return found


def _filtered(record: Record, truth: NDArray[np.float64]) -> list[float]:
    online, last = OnlineFilter.of_record(record, every=EVERY), len(record.time) - 1
    judged = {EVERY * (last // part // EVERY) for part in (8, 4, 1)}
    figures = []
    for tick, measured in enumerate(record.measured):
        belief = online.update(measured, record.samples[tick - 1] if tick > 0 else None)
        if tick in judged:
            figures.append(float(Beliefs.of(belief.log_mean, belief.log_cov, truth).nees))
    return [*figures, 0.5 * float(np.log(np.diag(belief.log_cov).max()))]


def shown(values: list[list[float]], first: list[list[float]]) -> str:
    early, quarter, end, sd = np.mean(values, axis=0)
    wider, lost = np.exp(sd - np.mean(first, axis=0)[3]), np.sum(np.array(values)[:, 2] > LOST)
    return f"{early:.2f}, {quarter:.2f}, {end:.2f}; {wider:.3f}" + (f"; {lost} lost" if lost else "")


def main() -> None:
    parser = argparse.ArgumentParser(description="Measure what each mechanism of the filter is worth.")
    parser.add_argument("--patients", type=int, default=32)
    parser.add_argument("--seed", type=int, default=6000, help="of the first patient; tuning's are 5000 to 19999")
    parser.add_argument("--only", type=int, nargs="+", default=range(len(ROWS)), help="numbers of the rows to make")
    parser.add_argument("--row", type=int, help=argparse.SUPPRESS)
    parser.add_argument("--recorded", type=Path, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.row is not None:
        print(json.dumps(measure(ROWS[arguments.row], pickle.loads(arguments.recorded.read_bytes()))))
        return
    head("left out", *CELLS)
    first: Any = None
    with tempfile.TemporaryDirectory() as folder:
        kept = Path(folder, "recorded")
        kept.write_bytes(pickle.dumps([recorded(cell, arguments.patients, arguments.seed) for cell in CELLS]))
        for number in (0, *(number for number in arguments.only if number)):
            variant = ROWS[number]
            print(f"{variant.what} ({number + 1} of {len(ROWS)})", file=sys.stderr, flush=True)
            command = [sys.executable, "-m", "research.ablation", "--row", str(number), "--recorded", str(kept)]
            # The kernels of a filter that lacks something must not be taken for those of the whole one.
            places = {"JAWENV_CACHE_DIR": str(Path(folder, str(number)))} if variant.constants else {}
            ran = subprocess.run(command, env=os.environ | places, stdout=subprocess.PIPE, text=True, check=True)
            found = json.loads(ran.stdout)
            first = first or found
            row(variant.what, *(shown(cell, base) for cell, base in zip(found, first, strict=True)))


if __name__ == "__main__":
    main()
