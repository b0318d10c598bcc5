"""What cannot be is refused in one line that names the field, its value and what is allowed: a table for each room."""

import re
from dataclasses import replace

import numpy as np
import pytest
from estimation_records import records

import agents
import jawenv
from agents.following import TargetsLaw, decision_hz
from agents.planners import PLANNERS
from agents.residual import Residual
from eval.comparison.admission import Admission
from eval.entries import load_entries
from eval.patient.treatments import Course
from eval.settings import Settings
from jawenv import InputError
from jawenv.anatomy import MuscleSet, Patient, Prior, attachment, cohort, default_fossa, default_mandible, muscle_set
from jawenv.anatomy.cohorts import Stiffness
from jawenv.laboratory.analysis.identifiability import collinearity, collinearity_of_size
from jawenv.laboratory.analysis.observability import observability
from jawenv.laboratory.analysis.wording import in_words
from jawenv.laboratory.record_filter import TensionFilter
from jawenv.laboratory.references.extended_kalman import ExtendedKalman
from jawenv.laboratory.references.filterpy_filters import FilterpyExtendedKalman, FilterpyUnscentedKalman
from jawenv.laboratory.references.smoother import IteratedSmoother
from jawenv.laboratory.thesis_methods.inverse_kinematics import motion_from_pose
from jawenv.laboratory.thesis_methods.least_squares import NonlinearLeastSquares
from jawenv.laboratory.thesis_methods.moment_balance import balance_of
from jawenv.laboratory.thesis_methods.two_stage import TwoStageLogLinear
from jawenv.ladder import model_named, model_of_env
from jawenv.mechanics import build_jaw
from jawenv.metrics import diagnose, nees, time_to
from jawenv.playing.rollout import information_bound, play
from jawenv.playing.singles import SingleWorlds
from jawenv.rendering import Renderer
from training.run.config import TrainingConfig
from training.run.several import parse_seeds
from training.search.optimise import Design
from training.search.sequential import SequentialDesign

nan, inf = np.nan, np.inf
ONE, TWO = np.ones((1, 3)), np.ones((2, 3))
NOTHING, SD, FREE = np.zeros((3, 12)), np.ones(12), np.ones(10)
BLIND = np.where(np.arange(12) > 2, nan, NOTHING)  # no angle is read


def hinge():
    """A record of 30 s."""
    return records("JawHinge")[0]


def exactly(message):
    return f"^{re.escape(message)}$"


ANATOMY = [
    (
        lambda: attachment("digastric", "left"),
        "^muscle portion 'digastric' is unknown; allowed: superficial_masseter, ",
    ),
    (lambda: attachment("deep_masseter", "middle"), "^side 'middle' is unknown; allowed: left, right$"),
    (
        lambda: cohort("trizmus"),
        exactly(
            "cohort is 'trizmus'; did you mean trismus? allowed: trismus, healthy, severe, one_sided, blockage, wide, "
            "or a file (.json, .toml, .yaml, .yml)"
        ),
    ),
    *(
        (lambda sd=sd: Stiffness(1.0, sd, 7.0, 0.3), exactly(f"F_o_sd = {sd!r} must be finite and greater than 0"))
        for sd in (0.0, -1.0, nan, "1", True)
    ),
    (lambda: Prior(np.zeros(11), np.ones(12)), r"^sd has shape \(12,\), must be \(11,\)$"),
    (lambda: Prior(SD, np.r_[1.0, 0.0, np.ones(10)]), "^prior sd of parameter 1 = 0.0 must be greater than 0$"),
    (lambda: Prior(SD, np.full(12, inf)), "^sd = .*inf.* must be finite$"),
    (lambda: model_named("knee"), "^model is 'knee'; allowed: hinge, sagittal, sides, jaw, portions, bilateral$"),
    (lambda: model_of_env("knee"), "^env is 'knee'; allowed: jawenv/JawHinge-v2, .*JawBilateral-v2"),
    (
        lambda: Patient(F_o_N={"left": 1.0, "right": 1.0}, b={"closers": 7.0}),
        "b is of closers, but F_o_N of left, right",
    ),
    (lambda: replace(default_fossa(), drop_m=-1e-3), "^drop_m = -0.001 must be greater than 0$"),
    *(
        (lambda change=change: replace(default_mandible(), **change), exactly(message))
        for change, message in (
            ({"mass_kg": 0.0}, "mass_kg = 0.0 must be greater than 0"),
            ({"mass_kg": nan}, "mass_kg = nan must be finite"),
            ({"mass_kg": [0.3]}, "mass_kg has shape (1,), must be ()"),
            ({"mass_kg": "heavy"}, "mass_kg must be made of numbers, not 'heavy'"),
            ({"damping_sliding": -1.0}, "damping_sliding = -1.0 must be at least 0"),
            ({"condyle_half_width_m": 0.0}, "condyle_half_width_m = 0.0 must be greater than 0"),
            ({"disc_damping": -1.0}, "disc_damping = -1.0 must be at least 0"),
            ({"teeth_m": TWO}, "teeth_m has shape (2, 3), must be (3, 3)"),
            ({"inertia_kg_m2": [[1, 1, 0], [0, 1, 0], [0, 0, 1]]}, "inertia_kg_m2 must be symmetric"),
            (
                {"inertia_kg_m2": np.diag([1.0, -1.0, 1.0])},
                "inertia_kg_m2 must be positive definite; its principal moments are [-1.0, 1.0, 1.0]",
            ),
            (
                {"inertia_kg_m2": np.diag([1.0, 1.0, 3.0])},
                "inertia_kg_m2 has the principal moments [1.0, 1.0, 3.0]; "
                "the largest must not exceed the sum of the others",
            ),
        )
    ),
    (lambda: muscle_set({"digastric": ()}), "^muscle 'digastric' has no portions; it needs at least one$"),
    (lambda: muscle_set({"opener": ("digastric",)}), "^muscle portion 'digastric' is unknown; allowed: "),
    (lambda: MuscleSet(("a",), (0,), ONE, ONE, np.zeros(1), ONE, ONE), "^l_o_m of a = 0.0 must be greater than 0$"),
    (
        lambda: MuscleSet(("a", "b"), (0, 1), ONE, ONE, np.ones(2), ONE, ONE),
        r"^origin_m has shape \(1, 3\), must be \(2, 3\)$",
    ),
    (lambda: MuscleSet(("a",), (0,), ONE, ONE, np.array([nan]), ONE, ONE), r"^l_o_m = \[nan\] must be finite$"),
    (
        lambda: MuscleSet(("a", "b"), (0, 0), TWO, TWO, np.ones(2), TWO, TWO),
        r"^muscle = \(0, 0\) must give each of 2 muscles a line$",
    ),
    *(
        (lambda theta=theta: Patient.from_log_parameters(theta), exactly(message))
        for theta, message in (
            (np.zeros(11), "log parameters have shape (11,), must be (12,)"),
            (np.zeros((2, 12)), "log parameters have shape (2, 12), must be (12,)"),
            (np.r_[nan, np.zeros(11)], "log_F_o/masseter_left = nan must be finite"),
            (
                np.r_[np.zeros(11), 5.0],
                "Patient: b.medial_pterygoid_right = 148.4131591025766 must be less than or equal to 60",
            ),
            (np.r_[900.0, np.zeros(11)], "Patient: F_o_N.masseter_left = inf must be a finite number"),
            (["a"] * 12, "log parameters must be numbers"),
        )
    ),
]
LOOP = [
    (lambda: build_jaw(free=(True, True, True, True, False)), "allowed: psi and alpha free both or none"),
    *(
        (
            lambda change=change: jawenv.acceleration(
                build_jaw(),
                **({"q": np.zeros(5), "u": np.zeros(5), "log_parameters": np.zeros(12), "force": np.zeros(3)} | change),
            ),
            f"^{message}$",
        )
        for change, message in (
            ({"q": np.zeros(4)}, r"q has shape \(4,\); allowed: \(5,\)"),
            ({"u": [0, 0, nan, 0, 0]}, r"u is \[0.0, 0.0, nan, 0.0, 0.0\]; allowed: finite numbers"),
            ({"force": np.zeros(2)}, r"force has shape \(2,\); allowed: \(3,\) or \(6,\)"),
            ({"log_parameters": np.full(12, inf)}, r"log_parameters is \[inf, .*\]; allowed: finite numbers"),
        )
    ),
    (lambda: Renderer("ansi", 20), "render_mode: 'ansi' must be one of rgb_array, human"),
    (lambda: Renderer("rgb_array", 0), "fps: 0 must be above 0"),
    (lambda: Renderer("rgb_array", nan), "fps: nan must be above 0"),
    (lambda: Renderer("rgb_array", 20, (64, 64)), r"size: \(64, 64\) must be at least 480 by 270"),
]
LABORATORY = [
    (lambda: TensionFilter(every=0), "^every: 0 given, allowed is 1 or more$"),
    (lambda: ExtendedKalman("square"), "scale is 'square'"),
    (lambda: ExtendedKalman(parameter_rate=-1.0), "parameter_rate is -1.0"),
    (lambda: ExtendedKalman(parameter_time=0.0), "parameter_time is 0.0"),
    (lambda: ExtendedKalman(every=0), "every is 0"),
    (lambda: FilterpyExtendedKalman(every=0), "every is 0"),
    (lambda: FilterpyUnscentedKalman(alpha=0.0), "alpha is 0.0"),
    (lambda: IteratedSmoother(max_iterations=0), "max_iterations is 0"),
    (lambda: IteratedSmoother(tolerance=0.0), "tolerance is 0.0"),
    (lambda: IteratedSmoother(times=()), r"times is \(\)"),
    (lambda: IteratedSmoother(times=(2.0, 1.0)), r"times is \(2.0, 1.0\)"),
    (lambda: NonlinearLeastSquares(starts=0), "starts is 0"),
    (lambda: TwoStageLogLinear("sum"), "form is 'sum'"),
    (lambda: TwoStageLogLinear(small_share=1.0), "small_share is 1"),
    (lambda: motion_from_pose(build_jaw(), BLIND, SD, np.zeros(10), FREE), "not read"),
    (lambda: motion_from_pose(build_jaw(), NOTHING[:, :6], SD, np.zeros(10), FREE), "measured has shape"),
    (lambda: motion_from_pose(build_jaw(), NOTHING, SD, np.zeros(12), np.ones(12)), "start_mean has shape"),
    (lambda: motion_from_pose(build_jaw(condyles=2), NOTHING, SD, np.zeros(10), FREE), "condyles"),
    (lambda: balance_of(replace(hinge(), measured=BLIND[:1].repeat(len(hinge().measured), 0))), "not read"),
    (lambda: balance_of(hinge(), rows="five"), "rows is 'five'"),
    (lambda: balance_of(hinge(), smoothing_s=1e3), "smoothing_s"),
    (lambda: balance_of(hinge(), smoothing_s=nan), "smoothing_s"),
    *(
        (
            lambda subset=subset: collinearity(np.eye(12), subset),
            "^subset: .* given, allowed are different numbers from 0 to 11",
        )
        for subset in ([], [0, 0], [0, 12], [-1])
    ),
    (lambda: collinearity_of_size(np.eye(12), 0), "^size: 0 given"),
    (lambda: collinearity_of_size(np.eye(12), 13), "^size: 13 given"),
    (lambda: collinearity_of_size(np.eye(40), 20), "subsets"),
    *(
        (lambda s=s: observability(hinge(), window_s=s), f"^window_s: {s} given, allowed are 0.01 to 30 s")
        for s in (0.0, 30.5, nan, inf)
    ),
    *(
        (lambda way=way: in_words(way, jawenv.PARAMETER_NAMES), "^direction: .* allowed are 12 finite numbers")
        for way in (np.zeros(12), np.ones(3), np.full(12, inf))
    ),
]
PLAYING = [
    (lambda: nees(np.ones(2), np.diag([1.0, -1.0])), "covariance: not positive definite"),
    (lambda: time_to(np.ones((1, 2, 1)), np.arange(2.0), 0), "threshold: 0 given"),
    (lambda: diagnose(ONE, ONE, ONE, -1.0, 0.95), "threshold: -1.0 given"),
    (lambda: diagnose(ONE, ONE, ONE, 1.0, 1.0), "confidence: 1.0 given"),
    (lambda: diagnose(ONE, ONE, ONE, 1.0, 0.3), "confidence: 0.3 given"),
    (lambda: information_bound(1.0, agents.load_agent("hold_still"), None), "env_or_jaw: a float given"),
    (
        lambda: SingleWorlds("Pendulum-v1", 1, {}),
        "^env_id is 'Pendulum-v1'; allowed: an environment of jawenv, or a sub",
    ),
    (
        lambda: play(object(), patients=1, seed=0),
        "^agent: <object object at .*> given, allowed is an object with predict",
    ),
    *(
        (
            lambda change=change: play(agents.load_agent("hold_still"), **({"patients": 1, "seed": 0} | change)),
            message,
        )
        for change, message in (
            ({"patients": 0}, "patients: 0 given"),
            ({"patients": []}, "patients: 0 given"),
            ({"patients": 2.0}, "patients: 2.0 given"),
            ({"patients": "two"}, "patients: 'two' given"),
            ({"patients": [3]}, r"option patients\[0\] is 3"),
            ({"seed": -1}, "seed: -1 given"),
            ({"seed": 10**24}, f"seed: {10**24} given, allowed is a whole number, 0 to 4294967295"),
            ({"seed": "one"}, "seed: 'one' given"),
            ({"seed": [1, 2, 3]}, "seed: 3 given, allowed are one, or one for each of 1 patients"),
            ({"seed": [-2]}, "given, allowed is a whole number, 0 to 4294967295"),
            ({"env_kwargs": {"cohort": "nobody"}}, "nobody"),
            ({"env_kwargs": 5}, "env_kwargs: 5 given"),
        )
    ),
]
AGENTS = [
    (lambda: agents.load_agent("hold_still", env_id="knee"), "^env is 'knee'; allowed: jawenv/JawHinge-v2, "),
    (lambda: agents.load_agent("gone.zip"), "gone.zip: no such file"),
    (lambda: agents.load_agent("missing.yaml"), "missing.yaml: no such file"),
    (
        lambda: agents.load_agent("ppo_trismus", control="targets", control_hz=20.0),
        "^control_hz 20: ppo_trismus decides 5 times a second$",
    ),
    (
        lambda: agents.load_agent("myopic", control="force"),
        "^agent 'myopic': control is 'force'; allowed for a planner: targets$",
    ),
    (lambda: TargetsLaw("force", 12.0), "^control_hz 12: must be a multiple of the 5 decisions per second$"),
    (
        lambda: decision_hz({"control": "targets", "control_hz": "often"}),
        "control_hz 'often': must be a positive number",
    ),
    (lambda: Residual(maneuver="chirp", scale=0), "scale = 0 must be greater than 0"),
    (
        lambda: PLANNERS["receding_horizon"].kind(replace(PLANNERS["receding_horizon"].plan, maneuvers=())),
        r"^agent 'receding_horizon': maneuvers is \(\); allowed: one or more$",
    ),
    *(
        (lambda n=n, a=a: replace(PLANNERS[a].plan, candidates=n), f"^candidates is {n}; allowed: {least} to 10000$")
        for a, n, least in (("myopic", 10**9, 1), ("myopic", 0, 1), ("myopic", 64.0, 1), ("receding_horizon", 5, 6))
    ),
]
COMMANDS = [
    (lambda: TrainingConfig.load("nowhere.yaml"), "nowhere.yaml: no such file"),
    *(
        (lambda text=text: parse_seeds(text), "^seeds '")
        for text in ("", "a", "1-", "-1", "2-1", "0-5000", "1;2", "1.5")
    ),
    *(
        (lambda field=field, value=value: Design(**{field: value}), message)
        for field, value, message in (
            ("criterion", "E", "criterion is 'E'; allowed: worst, D, A"),
            ("over", "all", "over is 'all'; allowed: mean, tail, nominal"),
            ("population", 10**9, "population is 1000000000 and patients 12; allowed: 10,000 worlds"),
            ("patients", 0, "patients is 0; allowed: 1 or more"),
            ("sigma", 2.0, "sigma is 2; allowed: above 0, at most 1"),
            ("control", "thought", "control is 'thought'"),
            ("cohort", "knees", "knees"),
            ("horizon_s", -1.0, "episode_s is -1"),
            ("refine", "nothing.yaml", "nothing.yaml"),
            ("then", "refined", "then is 'refined'; allowed: nothing without refine"),
        )
    ),
    *(
        (lambda field=field, value=value: SequentialDesign(**{field: value}), message)
        for field, value, message in (
            ("goal", "most", "^goal is 'most'; allowed: mixed, worst, uncertainty$"),
            ("over", "nominal", "^over is 'nominal'; allowed: mean, tail$"),
            ("patients", 0, "^patients is 0; allowed: 1 or more$"),
            ("candidates", 3, "^candidates is 3; allowed: 6 to 10000$"),
            ("candidates", 10**9, "^candidates is 1000000000; allowed: 6 to 10000$"),
            ("look_ahead_s", nan, "^look_ahead_s is nan; allowed: 0.2 to 30$"),
            ("comfort_weight", nan, "^comfort_weight is nan; allowed: 0 or more, finite$"),
            ("comfort_weight", inf, "^comfort_weight is inf; allowed: 0 or more, finite$"),
            ("cohort", "nobody", "nobody"),
        )
    ),
    (lambda: Admission(discomfort_s=nan), "largest-discomfort-s: nan given, allowed is a finite number, 0 or more"),
    (lambda: Admission(discomfort_s=-1.0), "largest-discomfort-s: -1.0 given"),
    (lambda: Admission(violation=1.5), "largest-violation: 1.5 given, allowed is a share, 0 to 1"),
    (lambda: Course(number=0), "treatments: 0 given, allowed is 1 or more"),
    (lambda: Course(drift=-0.1), "drift: -0.1 given, allowed is 0 to 0.5"),
    (lambda: Course(drift=nan), "drift: nan given"),
    (lambda: Course(drift=2.0), "drift: 2.0 given"),
    (
        lambda: load_entries(["examples.careful_agent:Careful"], Settings.of(control="force").world),
        "control is 'force'; allowed for agent 'careful'",
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
    ("refused", "message"),
    [pytest.param(*row, id=f"{room}-{row[1][:60]}") for room, rows in TABLES.items() for row in rows],
)
def test_refusals(refused, message):
    with pytest.raises(InputError, match=message) as caught:
        refused()
    assert "\n" not in str(caught.value)
