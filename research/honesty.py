"""Honesty of the filter where ``eval calibrate`` does not look: one table in Markdown, chosen by its name.

    python -m research.honesty corners --patients 64 --seed 20000
    python -m research.honesty all > docs/tables/honesty.md

bias: the largest mean z of all parameters and agents, all cohorts, three controls. corners: motors held at each of the
16 corners of their range. memory: a disturbance with memory, told rightly and wrongly. alarm: what rings, of calibrated
episodes and of others. jaws: a true jaw that MuJoCo moves, beside the filter's own. way: how often a belief is false on
its way, all beliefs and those that are settled, and what waiting for these costs. effects: how wrong belief and change
between two treatments are under each effect that the filter is not told. all: those of the page, each under its title,
on as many patients as ``ALL`` says. A row is printed as soon as it is there.
"""

import argparse
from dataclasses import dataclass, field
from itertools import product
from typing import Any, NamedTuple

import numpy as np

import jawenv
from agents import load_agent
from eval.figures import statistics, words
from eval.kept.entries import Entry, Settings, load_entries
from eval.patient.changes import change_of
from eval.patient.treatments import first_treatment, next_treatment, population_of
from eval.studies.design import read
from jawenv.anatomy import COHORTS
from jawenv.controls import CONTROLS
from jawenv.metrics import time_to
from research._beliefs import Beliefs, head, row

MUJOCO = "jawenv.mechanics.mujoco_jaw:MujocoJaw"
LOT, SECONDS = 50, 30.0  # patients that are played together; length of an episode
BUDGET_S = 1.0 / 30.0
FIGURES = ("at an eighth, a quarter", "NEES/12, 30 s", "inside 2 sd, %", "beyond 10")
LOST = 10.0  # NEES over the number of parameters
RICH, SWINGS, PLAIN = "refined", "opening_with_swings_and_fore_aft", "slow_opening"
ONE_CHANNEL = "examples/one_channel.yaml"
POLICY_LIKE = ("random", "ou_strong")
UNTOLD = (
    {"fossa_error": 0.1},
    {"cell_bias_N": 0.1, "cell_bias_N_m": 0.002},
    {"attachment_error": 0.1},
    {"attachment_error": 1.0},
    {"creep_share": 0.2},
    {"creep_share": 0.55},
    {"reflex_gain": 0.5},
    {"encoder_play_mm": 0.3},
    {"articular_stiffness_N_m": 2000.0},
    {"mass_error": 0.1},
    {"centre_of_mass_error_mm": 4.0},
    {"head_tilt_error_deg": 3.0},
    {"mouthpiece_error_mm": 0.5},
    {"mouthpiece_error_deg": 0.5},
    {"cell_error_deg": 0.5},
    {"damping_error": 0.2},
    {"unmodelled_time_s": 0.1},
    {"unmodelled_time_s": 1.0},
)


class _Held:
    """Constant actions, of each world another corner of the range."""

    def __init__(self, control):
        self.name, self.control, self.first = "held", control, 0

    def reset(self, num_envs, seed=None):
        self.first = seed or 0

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        corners = self.first + np.arange(len(observation))
        return 1.0 - 2.0 * (corners[:, None] >> np.arange(4) & 1), None


class _BeliefSample(NamedTuple):
    """Beliefs about N patients at one time, without ended episodes."""

    nees: np.ndarray  # over the number of parameters
    early: np.ndarray  # (N, 2) the same after an eighth and a quarter of the episode
    z: np.ndarray  # (N, P)
    sd: np.ndarray
    rings: np.ndarray

    def figures(self):
        """NEES after an eighth, a quarter and all of the episode, inside 2 sd, beyond 10."""
        eighth, quarter = np.mean(self.early, axis=0)
        nees = words.with_interval(statistics.mean(self.nees), 2)
        inside, lost = 100.0 * np.mean(np.abs(self.z) < 2.0), np.sum(self.nees > LOST)
        return f"{eighth:.2f}, {quarter:.2f} | {nees} | {inside:.1f} | {lost} of {len(self.nees)}"

    def sds(self):
        """Worst and median sd of a patient, in %."""
        return f"{100.0 * self.sd.max(axis=1).mean():.1f} / {100.0 * np.median(self.sd, axis=1).mean():.1f} %"

    def ringing(self):
        """Share that rings, in %."""
        return f"{100.0 * self.rings.mean():.1f}"


def beliefs(agent, arguments, **kwargs):
    """A sample of beliefs at the end of episodes of 30 s."""
    kwargs = {"track_bound": False, "episode_s": SECONDS, "knowledge": arguments.knowledge} | kwargs
    return _BeliefSample(*_of_lots(agent, arguments, kwargs, _last))


def _of_lots(agent, arguments, kwargs, figures):
    """Figures of all patients, who are played in lots."""
    lots = []
    for first in range(0, arguments.patients, LOT):
        number = min(LOT, arguments.patients - first)
        lots.append(figures(jawenv.play(agent, patients=number, seed=arguments.seed + first, env_kwargs=kwargs)))
    return [np.concatenate(parts) for parts in zip(*lots, strict=True)]


def _last(played):
    reached, last = played.valid[:, -1], played.valid.shape[1] - 1
    eighth, quarter, end = (
        Beliefs.of(played.belief_mean[reached, step], played.belief_cov[reached, step], played.truth[reached])
        for step in (last // 8, last // 4, last)
    )
    early = np.stack([eighth.nees, quarter.nees], axis=1)
    return end.nees, early, end.error / end.sd, end.sd, played.misfit[reached, -1] > 1.0


def corners(arguments):
    head("control", *FIGURES, "largest", "rings, %")
    for control in CONTROLS:
        sample = beliefs(_Held(control), arguments, control=control)
        row(control, sample.figures(), f"{sample.nees.max():.1f}", sample.ringing())


def memory(arguments):
    head("agent", "true time, s", "told, s", *FIGURES, "rings, %")
    for name, time, factor in product((RICH, SWINGS, PLAIN), (0.05, 0.1, 0.5, 1.0, 2.0), (1.0, 1.0 / 3.0, 3.0)):
        kwargs = {"device": {"unmodelled_time_s": time * factor}, "reality": {"unmodelled_time_s": time}}
        sample = beliefs(load_agent(name), arguments, **kwargs)
        row(name, f"{time:g}", f"{time * factor:.2g}", sample.figures(), sample.ringing())


def bias(arguments):
    """Print for each cohort and control the agent under which estimates lie furthest to one side."""
    head("cohort", "control", "agent", *FIGURES, "largest mean z", "of")
    names = COHORTS[next(iter(COHORTS))].muscles.parameter_names
    for cohort, control in product(COHORTS, CONTROLS):
        rows = []
        for name in (RICH, SWINGS, PLAIN, ONE_CHANNEL, "random"):
            sample = beliefs(load_agent(name, control=control), arguments, cohort=cohort, control=control)
            means = statistics.means_together(sample.z)
            worst = int(np.argmax([abs(mean.value) for mean in means]))
            cells = name, sample.figures(), words.with_interval(means[worst], 2), names[worst]
            rows.append((abs(means[worst].value), cells))
        row(cohort, control, *max(rows)[1])


def alarm(arguments):
    head("cohort", "control", "agent", *FIGURES, "rings, %")
    total = []
    for cohort, control in product(COHORTS, CONTROLS):
        rows = []
        for name in (RICH, SWINGS, "hold_still", *POLICY_LIKE):
            agent = load_agent(name, control=control)
            sample = beliefs(agent, arguments, cohort=cohort, control=control)
            rows.append((sample.rings.mean(), sample.nees.mean(), (name, sample.figures(), sample.ringing())))
            total.append(sample.rings)
        row(cohort, control, *max(rows)[2])  # who rings most, then who is furthest off
    rings = np.concatenate(total)
    print(f"\n{rings.sum()} of {len(rings)} honest episodes ring: {100.0 * rings.mean():.2f} %\n", flush=True)
    head("not told", "agent", *FIGURES, "NEES/12 > 4", "of these ring, %")
    arguments.patients *= 2
    for reality, name in product(UNTOLD, (RICH, SWINGS, PLAIN)):
        sample = beliefs(load_agent(name), arguments, reality=reality)
        effects = ", ".join(f"`{field}={value:g}`" for field, value in reality.items())
        wrong = sample.nees > 4.0
        share = f"{100.0 * sample.rings[wrong].mean():.0f}" if wrong.any() else "–"
        row(effects, name, sample.figures(), f"{wrong.sum()} of {len(wrong)}", share)


@dataclass(frozen=True)
class _Elsewhere(Entry):
    """An entry whose truth departs from the filter's model by other arguments of the environment."""

    truth: dict[str, Any] = field(default_factory=dict)

    @property
    def env_kwargs(self):
        return super().env_kwargs | self.truth


def _changes_between(entry, arguments):
    """First treatments (N), (estimate - truth) / sd of each change to a second (N, 12) with drift 0.1, and the sds."""
    prior, firsts, z, sd = population_of(entry).prior, [], [], []
    for seed in range(arguments.seed, arguments.seed + arguments.patients):
        course = [first_treatment(entry, seed)]
        course.append(next_treatment(entry, course[0], 2, 0.1, seed))
        estimate = change_of(course, prior)
        firsts.append(course[0])
        z.append((estimate.mean - (course[1].truth - course[0].truth)) / estimate.sd)
        sd.append(estimate.sd)
    return firsts, np.array(z), np.array(sd)


def inside(z):
    """Share of the changes within their 95 % interval, over the patients, %."""
    return words.with_interval(words.scaled(statistics.mean(np.mean(np.abs(z) < 1.96, axis=1)), 100.0), 1)


def effects(arguments):
    """Print the harm of untold effects, with a scan's anatomy: ``refined`` of 10 s, change to a second treatment."""
    settings = Settings.of(1, arguments.seed, episode_s=10.0, knowledge="imaged")
    (entry,) = load_entries([RICH], settings.world)
    truths = {title: {"reality": values} for title, values in read("robustness")[1].reality.items()}
    head("effect", "NEES/12, 10 s", "rings, %", "change inside 95 %, %", "its error, median, %", "its sd, median, %")
    for title, truth in (truths | {"a jaw that MuJoCo moves": {"plant": MUJOCO}}).items():
        firsts, z, sd = _changes_between(_Elsewhere(**vars(entry), truth=truth), arguments)
        nees = words.with_interval(statistics.mean(np.array([first.nees for first in firsts]) / z.shape[1]), 2)
        rings = f"{100.0 * np.mean([first.rings for first in firsts]):.0f}"
        row(title, nees, rings, inside(z), f"{100.0 * np.median(np.abs(z * sd)):.1f}", f"{100.0 * np.median(sd):.1f}")


def jaws(arguments):
    """Imaged ones as in ``JawImaged-v3``, where the disturbance has a memory as well."""
    head("filter", "agent", "true jaw", *FIGURES, "worst / median sd", "rings, %")
    plants = {"its own": None, "MuJoCo": MUJOCO}
    filters = {
        "one point": {"knowledge": "exact"},
        "one point, imaged": {"knowledge": "imaged", "device": {"unmodelled_time_s": 0.5}},
    }
    for (title, kwargs), name, (jaw, plant) in product(filters.items(), (RICH, PLAIN), plants.items()):
        sample = beliefs(load_agent(name), arguments, **kwargs, plant=plant)
        row(title, name, jaw, sample.figures(), sample.sds(), sample.ringing())


def way(arguments):
    """Print the share of false beliefs on the way through 10 s of ``anyone``, with and without a kept budget."""
    of = "false steps, %", "patients with one, %"
    head("agent, 10 s of `anyone`", "budget, s", *of, "settled and false, %", of[1], "price, s")
    for name, budget in product((SWINGS, RICH, "random", "apg_anyone"), (None, BUDGET_S)):
        kwargs = {"cohort": "anyone", "control": "targets", "episode_s": 10.0, "track_bound": False}
        kwargs |= {"comfort_budget_s": budget}
        false, settled, waited = _of_lots(load_agent(name), arguments, kwargs, _on_the_way)
        shares = (100.0 * np.mean(mask) for each in (false, false & settled) for mask in (each, each.any(axis=1)))
        row(
            name,
            "–" if budget is None else f"{budget:.2g}",
            *(f"{share:.2g}" for share in shares),
            f"{waited.mean():.2f}",
        )


def _on_the_way(played):
    """Masks (N, T) of false and of settled beliefs, and s (N,) by which settled ones are within 5 % later."""
    way = Beliefs.of(played.belief_mean, played.belief_cov, played.truth[:, None])
    false = (way.nees > LOST) & played.valid
    last = played.time[-1]
    at, later = (
        np.minimum(time_to(played.belief_sd, played.time, 0.05, mask), last) for mask in (played.valid, played.counts)
    )
    return false, played.settled, later - at


TABLES = {table.__name__: table for table in (bias, corners, memory, alarm, jaws, effects, way)}
ALL = {
    "bias": ("To which side estimates lie", 200, 20_000),
    "corners": ("Motors held at the corners of their range", 64, 20_000),
    "memory": ("A disturbance that lasts, told rightly and wrongly", 32, 20_000),
    "alarm": ("What rings, and what does not", 16, 20_000),
    "jaws": ("A jaw that the filter does not know", 16, 376_000),
    "effects": ("What the filter is not told, and the change", 16, 376_000),
    "way": ("False beliefs on the way", 500, 20_000),
}
"""Table -> its title, patients of a row and first seed; those of ``docs/tables/honesty.md``."""


def every(arguments):
    """``ALL``, each with its command."""
    print("# Where the error bars are right, and where the alarm rings\n")
    for name, (title, arguments.patients, arguments.seed) in ALL.items():
        command = f"python -m research.honesty {name} --patients {arguments.patients} --seed {arguments.seed}"
        print(f"## {title}\n\n`{command}`:\n")
        TABLES[name](arguments)
        print(flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description="Measure how honest the filter is.")
    parser.add_argument("table", choices=("all", *TABLES))
    parser.add_argument("--patients", type=int, default=200, help="of each row")
    parser.add_argument("--seed", type=int, default=20_000)
    arguments = parser.parse_args()
    (TABLES | {"all": every})[arguments.table](arguments)


if __name__ == "__main__":
    main()
