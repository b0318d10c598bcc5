"""Worth of error bars where nobody told the filter of an error: at the end of a recording, as it is and learnt.

    python -m research.untold all > docs/tables/untold.md
    python -m research.untold bench --cohort one_sided --patients 16

Own movements, sines on all four channels, of 30 s. *Filter*: the belief at the end. *Learnt*: the same with sizes of
errors that the recording itself shows (``jawenv.recordings.untold.learnt``). all: the sections of the page. A row is
printed as soon as it is there.
"""

import argparse
import shlex

import numpy as np

import jawenv
from eval.figures import statistics, words
from jawenv.recordings.untold.learnt import learnt
from research._beliefs import Beliefs, head, row

SECONDS = 30.0
_MUJOCO = "jawenv.mechanics.mujoco_jaw:MujocoJaw"
EFFECTS = {
    "none": {},
    "load cell off by 0.1 N, 2 mN m": {"cell_bias_N": 0.1, "cell_bias_N_m": 0.002},
    "head tilted by 3°": {"head_tilt_error_deg": 3.0},
    "openers that pull, 0.3 N": {"other_muscles_F_o_N": 0.3},
    "scar band, 800 N/m": {"scar_stiffness_N_m": 800.0},
    "seat, 0.5 mm, 0.5°": {"mouthpiece_error_mm": 0.5, "mouthpiece_error_deg": 0.5},
    "mass, inertia 10 %, centre 4 mm": {"mass_error": 0.1, "inertia_error": 0.1, "centre_of_mass_error_mm": 4.0},
    "play, 0.3 mm, 0.3°": {"encoder_play_mm": 0.3, "encoder_play_deg": 0.3},
    "swallows, 1 N": {"swallow_N": 1.0},
    "disturbance of 1 s": {"unmodelled_time_s": 1.0},
    "fossa, 10 %": {"fossa_error": 0.1},
    "creep, 0.3": {"creep_share": 0.3},
    "guarding, 1": {"guarding_gain": 1.0},
    "attachments of the mean": {"attachment_error": 1.0},
}
_MUJOCOS = "a jaw that MuJoCo moves"
_EFFECTS = {
    "exact": (*EFFECTS, _MUJOCOS),
    "bench": (
        "none",
        "openers that pull, 0.3 N",
        "scar band, 800 N/m",
        "play, 0.3 mm, 0.3°",
        "swallows, 1 N",
    ),
}
"""Knowledge of the filter -> effects that it was not told."""
MOVEMENTS = {
    "sines": ((0.35, 0.5, 0.5, 0.4), (3.1, 2.3, 1.7, 2.9)),
    "slow": ((0.35, 0.05, 0.05, 0.05), (9.0, 7.0, 11.0, 8.0)),
}
"""Amplitudes of the four channels and their periods, s."""
_EARLIER = {"patients": 16, "seed": 388_000}
_PAGE = (
    {"knowledge": "exact", "effects": (*list(EFFECTS)[:10], _MUJOCOS)},
    {"knowledge": "exact", "effects": tuple(EFFECTS)[10:], **_EARLIER},
    {"knowledge": "exact", "movement": "slow", "patients": 16},
    {"knowledge": "bench"},
    {"knowledge": "bench", "cohort": "one_sided", "patients": 24},
    {"knowledge": "exact", "cohort": "one_sided", "patients": 16, "effects": tuple(EFFECTS)[:9]},
)


class Sines:
    """Sines with periods that have no common one, in targets control; phases are each world's own."""

    control, steps_per_s = "targets", 5.0

    def __init__(self, name):
        self.name = name
        self._amplitudes, self._periods = (np.array(values) for values in MOVEMENTS[name])

    def reset(self, num_envs, seed=None):
        self._step, self._phases = 0, np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, (num_envs, 4))

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        self._step += 1
        turns = self._step / self.steps_per_s / self._periods
        actions = self._amplitudes * np.sin(2.0 * np.pi * turns + self._phases)
        actions[:, 0] = 0.9 * actions[:, 0] - 0.3
        return actions.astype(np.float32), None


def _judged(beliefs):
    """Cells: NEES with its median, inside of 95 %, error."""
    nees = words.with_interval(statistics.mean(beliefs.nees), 2)
    inside = 100.0 * np.mean(np.abs(beliefs.error) < 1.96 * beliefs.sd)
    error = 100.0 * np.sqrt(np.mean(beliefs.error**2))
    return f"{nees}, {np.median(beliefs.nees):.2f}", f"{inside:.1f}", f"{error:.1f}"


def _of_effect(title, arguments):
    kwargs = {"episode_s": SECONDS, "track_bound": False, "record": True, "control": "targets"}
    kwargs |= {"knowledge": arguments.knowledge, "cohort": arguments.cohort}
    kwargs |= {"plant": _MUJOCO} if title == _MUJOCOS else {"reality": EFFECTS[title]}
    played = jawenv.play(Sines(arguments.movement), patients=arguments.patients, seed=arguments.seed, env_kwargs=kwargs)
    chosen = np.flatnonzero(played.valid[:, -1])
    means, covs, truth = played.belief_mean[chosen, -1], played.belief_cov[chosen, -1], played.truth[chosen]
    found = [learnt(played.records[i], *belief) for i, *belief in zip(chosen, means, covs, strict=True)]
    filtered = Beliefs.of(means, covs, truth)
    after = Beliefs.of([one.mean for one in found], [one.cov for one in found], truth)
    wider = np.exp(np.median(np.log(after.sd / filtered.sd)))
    hot = np.median([one.shown.temperature for one in found])
    rings = f"{100.0 * np.mean(played.misfit[chosen, -1] > 1.0):.0f}"
    row(title, rings, *_judged(filtered), *_judged(after), f"{wider:.2f}", f"{hot:.1f}")


def _section(arguments):
    """Print a table of all that a filter was not told."""
    options = " ".join(f"--{name} {getattr(arguments, name)}" for name in ("cohort", "movement", "patients", "seed"))
    print(f"## Told {arguments.knowledge}: `{arguments.cohort}`, {arguments.movement}\n")
    effects = f" --effects {shlex.join(arguments.effects)}" if arguments.effects else ""
    print(f"`python -m research.untold {arguments.knowledge} {options}{effects}`:\n")
    head(
        "untold",
        "rings, %",
        *("filter: NEES/12, median", "in 95 %, %", "error, %"),
        *("learnt: NEES/12, median", "in 95 %, %", "error, %"),
        "error bars x",
        "temperature",
    )
    for title in arguments.effects or _EFFECTS[arguments.knowledge]:
        _of_effect(title, arguments)
    print(flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description="Measure what error bars are worth under errors that nobody told.")
    parser.add_argument("knowledge", choices=("all", *_EFFECTS), help="all: every section of the page")
    parser.add_argument("--patients", type=int, default=48, help="of each row")
    parser.add_argument("--seed", type=int, default=420_000)
    parser.add_argument("--cohort", default="trismus")
    parser.add_argument("--movement", choices=MOVEMENTS, default="sines")
    parser.add_argument("--effects", nargs="*", choices=(*EFFECTS, _MUJOCOS), help="those of the page by default")
    arguments = parser.parse_args()
    if arguments.knowledge != "all":
        _section(arguments)
        return
    print("# Errors that nobody told\n")
    for values in _PAGE:
        _section(argparse.Namespace(**{**vars(arguments), **values}))


if __name__ == "__main__":
    main()
