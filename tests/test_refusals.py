"""What cannot be is refused in one line that names the field, its value and what is allowed: a table for each room.

Each row has words that stand in the line, and what is refused.
"""

from dataclasses import replace

import numpy as np
import pytest
from estimation_records import records

import agents
import jawenv
from eval.comparison.admission import AdmissionLimits
from eval.kept.entries import Settings, load_entries
from eval.patient.treatments import Course
from eval.thesis.methods.inverse_kinematics import motion_from_pose
from eval.thesis.methods.moment_balance import balance_of
from jawenv import InputError
from jawenv.analysis.wording import in_words
from jawenv.anatomy import MuscleSet, Patient, Prior, attachment, cohort, default_fossa, default_mandible, muscle_set
from jawenv.anatomy.prior import Stiffness
from jawenv.ladder import model_named, model_of_env
from jawenv.mechanics import build_jaw
from jawenv.metrics import diagnose, nees, time_to
from jawenv.playing.policies.following import TargetsLaw, decision_hz
from jawenv.playing.rollout import play
from jawenv.playing.singles import SingleWorlds
from jawenv.references.extended_kalman import ExtendedKalman
from jawenv.rendering.renderer import Renderer
from training.run.config import Residual, TrainingConfig
from training.search.gradient import search

nan, inf = np.nan, np.inf
ONE, TWO = np.ones((1, 3)), np.ones((2, 3))
NOTHING, SD, FREE = np.zeros((3, 12)), np.ones(12), np.ones(10)
BLIND = np.where(np.arange(12) > 2, nan, NOTHING)  # no angle is read
STILL = {"q": np.zeros(5), "u": np.zeros(5), "log_parameters": np.zeros(12), "force": np.zeros(3)}


def hinge():
    """A record of 30 s."""
    return records("JawHinge")[0]


ANATOMY = [
    ("digastric allowed superficial_masseter", lambda: attachment("digastric", "left")),
    ("side middle left", lambda: attachment("deep_masseter", "middle")),
    ("cohort trizmus one_sided .toml", lambda: cohort("trizmus")),
    *((f"F_o_sd {sd!r} above", lambda sd=sd: Stiffness(1.0, sd, 7.0, 0.3)) for sd in (0.0, -1.0, nan, "1", True)),
    ("sd (12,) (11,)", lambda: Prior(np.zeros(11), np.ones(12))),
    ("sd 0.0 above", lambda: Prior(SD, np.r_[1.0, 0.0, np.ones(10)])),
    ("sd inf finite", lambda: Prior(SD, np.full(12, inf))),
    ("model knee sagittal", lambda: model_named("knee")),
    ("env knee jawenv/JawHinge-v3", lambda: model_of_env("knee")),
    ("b closers left", lambda: Patient(F_o_N={"left": 1.0, "right": 1.0}, b={"closers": 7.0})),
    ("drop_m -0.001 above", lambda: replace(default_fossa(), drop_m=-1e-3)),
    *(
        (words, lambda change=change: replace(default_mandible(), **change))
        for words, change in (
            ("mass_kg 0.0 above", {"mass_kg": 0.0}),
            ("mass_kg nan finite", {"mass_kg": nan}),
            ("mass_kg (1,) ()", {"mass_kg": [0.3]}),
            ("mass_kg heavy numbers", {"mass_kg": "heavy"}),
            ("damping_sliding -1.0 from", {"damping_sliding": -1.0}),
            ("condyle_half_width_m 0.0 above", {"condyle_half_width_m": 0.0}),
            ("disc_damping -1.0 from", {"disc_damping": -1.0}),
            ("teeth_m (2, (3,", {"teeth_m": TWO}),
            ("inertia_kg_m2 symmetric", {"inertia_kg_m2": [[1, 1, 0], [0, 1, 0], [0, 0, 1]]}),
            ("inertia_kg_m2 -1.0 above", {"inertia_kg_m2": np.diag([1.0, -1.0, 1.0])}),
            ("inertia_kg_m2 3.0 largest", {"inertia_kg_m2": np.diag([1.0, 1.0, 3.0])}),
        )
    ),
    ("digastric portions", lambda: muscle_set({"digastric": ()})),
    ("digastric allowed", lambda: muscle_set({"opener": ("digastric",)})),
    ("l_o_m 0.0 above", lambda: MuscleSet(("a",), (0,), ONE, ONE, np.zeros(1), ONE, ONE)),
    ("origin_m (1, (2,", lambda: MuscleSet(("a", "b"), (0, 1), ONE, ONE, np.ones(2), ONE, ONE)),
    ("l_o_m nan finite", lambda: MuscleSet(("a",), (0,), ONE, ONE, np.array([nan]), ONE, ONE)),
    ("muscle (0, line", lambda: MuscleSet(("a", "b"), (0, 0), TWO, TWO, np.ones(2), TWO, TWO)),
    *(
        (words, lambda theta=theta: Patient.from_log_parameters(theta))
        for words, theta in (
            ("parameters (11,) (12,)", np.zeros(11)),
            ("parameters (2, (12,)", np.zeros((2, 12))),
            ("log_F_o/masseter_left nan finite", np.r_[nan, np.zeros(11)]),
            ("b.medial_pterygoid_right 148.4 60", np.r_[np.zeros(11), 5.0]),
            ("F_o_N.masseter_left inf finite", np.r_[900.0, np.zeros(11)]),
            ("parameters numbers", ["a"] * 12),
        )
    ),
]
LOOP = [
    ("psi alpha allowed", lambda: build_jaw(free=(True, True, True, True, False))),
    *(
        (words, lambda change=change: jawenv.acceleration(build_jaw(), **(STILL | change)))
        for words, change in (
            ("q (4,) (5,)", {"q": np.zeros(4)}),
            ("u nan finite", {"u": [0, 0, nan, 0, 0]}),
            ("force (2,) (6,)", {"force": np.zeros(2)}),
            ("log_parameters inf finite", {"log_parameters": np.full(12, inf)}),
        )
    ),
    ("render_mode ansi human", lambda: Renderer("ansi", 20)),
    ("fps 0 above", lambda: Renderer("rgb_array", 0)),
    ("fps nan above", lambda: Renderer("rgb_array", nan)),
    ("size 64 480", lambda: Renderer("rgb_array", 20, (64, 64))),
]
LABORATORY = [
    ("every 0 more", lambda: jawenv.OnlineFilter(every=0)),
    ("scale square allowed", lambda: ExtendedKalman("square")),
    ("parameter_rate -1.0 allowed", lambda: ExtendedKalman(parameter_rate=-1.0)),
    ("parameter_time 0.0 allowed", lambda: ExtendedKalman(parameter_time=0.0)),
    ("every 0 allowed", lambda: ExtendedKalman(every=0)),
    ("start_mean shape", lambda: motion_from_pose(build_jaw(), NOTHING, SD, np.zeros(12), np.ones(12))),
    ("read", lambda: balance_of(replace(hinge(), measured=BLIND[:1].repeat(len(hinge().measured), 0)))),
    ("record has allowed", lambda: balance_of(hinge().until(0.05))),
    *(
        ("direction 12 finite", lambda way=way: in_words(way, jawenv.PARAMETER_NAMES))
        for way in (np.zeros(12), np.ones(3), np.full(12, inf))
    ),
]
PLAYING = [
    ("covariance definite", lambda: nees(np.ones(2), np.diag([1.0, -1.0]))),
    ("threshold 0 allowed", lambda: time_to(np.ones((1, 2, 1)), np.arange(2.0), 0)),
    ("threshold -1.0 allowed", lambda: diagnose(ONE, ONE, ONE, -1.0, 0.95)),
    ("confidence 1.0 allowed", lambda: diagnose(ONE, ONE, ONE, 1.0, 1.0)),
    ("confidence 0.3 allowed", lambda: diagnose(ONE, ONE, ONE, 1.0, 0.3)),
    ("env_id Pendulum-v1 jawenv", lambda: SingleWorlds("Pendulum-v1", 1, {})),
    ("agent object predict", lambda: play(object(), patients=1, seed=0)),
    *(
        (words, lambda change=change: play(agents.load_agent("hold_still"), **({"patients": 1, "seed": 0} | change)))
        for words, change in (
            ("patients 0 allowed", {"patients": 0}),
            ("patients 0 allowed", {"patients": []}),
            ("patients 2.0 allowed", {"patients": 2.0}),
            ("patients two allowed", {"patients": "two"}),
            ("patients[0] 3 allowed", {"patients": [3]}),
            ("seed -1 4294967295", {"seed": -1}),
            (f"seed {10**24} 4294967295", {"seed": 10**24}),
            ("seed one 4294967295", {"seed": "one"}),
            ("seed 3 1", {"seed": [1, 2, 3]}),
            ("seed -2 9223372036854775807", {"seed": [-2]}),
            ("cohort nobody allowed", {"env_kwargs": {"cohort": "nobody"}}),
            ("env_kwargs 5 allowed", {"env_kwargs": 5}),
        )
    ),
]
AGENTS = [
    ("env knee jawenv/JawHinge-v3", lambda: agents.load_agent("hold_still", env_id="knee")),
    ("gone.zip file", lambda: agents.load_agent("gone.zip")),
    ("missing.yaml file", lambda: agents.load_agent("missing.yaml")),
    ("control_hz 20 5", lambda: agents.load_agent("ppo_trismus", control="targets", control_hz=20.0)),
    ("control force targets", lambda: agents.load_agent("clairvoyant", control="force")),
    ("chrip chirp allowed", lambda: agents.load_agent("chrip")),
    ("control_hz 12 5", lambda: TargetsLaw("force", 12.0)),
    ("control_hz often positive", lambda: decision_hz({"control": "targets", "control_hz": "often"})),
    ("scale 0 greater", lambda: Residual(maneuver="chirp", scale=0)),
]
COMMANDS = [
    ("nowhere.yaml file", lambda: TrainingConfig.load("nowhere.yaml")),
    ("knees trismus", lambda: search("chirp", "knees", 1, 1, 1.0)),
    ("nothing.yaml file", lambda: search("nothing.yaml", "trismus", 1, 1, 1.0)),
    ("episode_s -1 allowed", lambda: search("chirp", "trismus", 1, 1, -1.0)),
    ("largest-discomfort-s nan finite", lambda: AdmissionLimits(discomfort_s=nan)),
    ("largest-discomfort-s -1.0 allowed", lambda: AdmissionLimits(discomfort_s=-1.0)),
    ("largest-violation 1.5 share", lambda: AdmissionLimits(violation=1.5)),
    ("treatments 0 1", lambda: Course(number=0)),
    *((f"drift {drift} 0.5", lambda drift=drift: Course(drift=drift)) for drift in (-0.1, nan, 2.0)),
    (
        "control force careful",
        lambda: load_entries(["examples.careful_agent:Careful"], Settings.of(control="force").world),
    ),
]
TABLES = {
    "anatomy": ANATOMY,
    "loop": LOOP,
    "laboratory": LABORATORY,
    "playing": PLAYING,
    "agents": AGENTS,
    "commands": COMMANDS,
}


@pytest.mark.parametrize(
    ("words", "refused"), [pytest.param(*row, id=f"{room}-{row[0]}") for room, rows in TABLES.items() for row in rows]
)
def test_a_refusal_is_one_line_that_names_field_value_and_what_is_allowed(words, refused):
    with pytest.raises(InputError) as caught:
        refused()
    line = str(caught.value)
    assert "\n" not in line
    assert [word for word in words.split() if word not in line] == []
