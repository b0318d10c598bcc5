"""Hostile actions through the real environment: of these patients nobody is lost.

Other patients are lost under motors that are held at full commands (docs/calibration.md).
"""

import gymnasium as gym
import numpy as np
import pytest
from hostile_actions import EXCITATIONS

import jawenv
from jawenv.filter.updates.measurement_update import GATE
from jawenv.metrics.calibration import nees
from jawenv.playing.excitation import ACTION_SIZE
from jawenv.playing.maneuvers import Player
from jawenv.recordings.online import OnlineFilter

EACH = 4  # patients for each way to act
SECONDS = 10.0
CORNERS = np.array(
    [[1, 1, 1, 1], [-1, -1, -1, -1], [1, -1, -1, 1], [-1, 1, 1, -1]], dtype=np.float32
)  # motors at full thrust


class Everybody:
    """All excitations and the corners at once, each for its own worlds."""

    def __init__(self, seed):
        self.parts = [*EXCITATIONS.values()]
        self.names = [*EXCITATIONS, "corners"]
        for part in self.parts:
            part.reset(EACH, seed=seed)

    @property
    def worlds(self):
        return EACH * len(self.names)

    def act(self):
        nothing = np.zeros((EACH, 1))
        return np.concatenate([*(part.predict(nothing)[0] for part in self.parts), CORNERS])


@pytest.mark.parametrize("control", ["force", "trajectory"])
@pytest.mark.parametrize("cohort", sorted(jawenv.COHORTS))
def test_nobody_is_lost(cohort, control):
    """Every number is one all the way, NEES/12 ends at 10 at most."""
    everybody = Everybody(seed=6000)
    env = gym.make_vec(
        "jawenv/Jaw-v3", everybody.worlds, cohort=cohort, control=control, episode_s=SECONDS, autoreset_mode="disabled"
    )
    observation, info = env.reset(seed=6000)
    opened = np.zeros(everybody.worlds)
    for _ in range(round(20 * SECONDS)):
        observation, reward, terminated, truncated, info = env.step(everybody.act())
        assert np.isfinite(observation).all() and np.isfinite(reward).all()
        for name, values in info.items():
            assert not isinstance(values, np.ndarray) or values.dtype.kind != "f" or np.isfinite(values).all(), name
        opened = np.maximum(opened, info["jaw_state"][:, 2])
    lost = info["nees"] / 12.0 > 10.0
    assert not lost.any(), dict(zip(np.repeat(everybody.names, EACH)[lost], info["nees"][lost] / 12.0, strict=True))
    assert (terminated == info["violation"]).all()
    assert opened.max() > 0.08
    swings = (opened > 0.1) & ~terminated & (np.repeat(everybody.names, EACH) != "corners")
    assert ((info["information_claimed"] > 0.5) | (info["gated"] > 0.5))[swings].all(), (
        "and who swings off the teeth teaches it something"
    )
    assert CORNERS.shape == (EACH, ACTION_SIZE) and GATE > 0.0


@pytest.mark.parametrize("seed", [5012, 5198])
def test_a_belief_far_from_the_truth_takes_what_it_refused(seed):
    """A muscle of 16 N, or a b of 24, under a wide prior: ten linearised sds from what is believed."""
    kwargs = {"cohort": "wide", "control": "force", "episode_s": 8.0}
    played = jawenv.play(Player("slow_opening", control="force"), patients=1, seed=seed, env_kwargs=kwargs)
    error = played.belief_mean[0, -1] - played.truth[0]
    assert played.information_claimed[0, -1] > 20.0
    assert nees(error, played.belief_cov[0, -1]) / 12.0 < 3.0


@pytest.mark.parametrize(("cohort", "begins_s"), [("trismus", 10.0), ("wide", 4.0)])
def test_a_burst_of_outliers_is_refused(cohort, begins_s):
    """A tracker that is off by 10 mm for 0.3 s is no false belief."""
    kwargs = {"cohort": cohort, "episode_s": 12.0, "record": True, "track_bound": False}
    played = jawenv.play(Player("slow_opening"), patients=4, seed=6000, env_kwargs=kwargs)
    for record, truth in zip(played.records, played.truth, strict=True):
        first = round(begins_s / record.dt)
        record.measured[first : first + 30, 0] += 0.01
        online = OnlineFilter.of_record(record, every=100)
        for k, measured in enumerate(record.measured):
            belief = online.update(measured, record.samples[k - 1] if k > 0 else None)
        assert nees(belief.log_mean - truth, belief.log_cov) / 12.0 < 4.0


@pytest.mark.parametrize("control", ["force", "targets"])
def test_a_jaw_that_rests_on_the_teeth_of_one_side_teaches_nothing(control):
    """A belief with both sides alike would take it for lifted, by a millimetre within 0.1 s."""
    kwargs = {"cohort": "one_sided", "control": control, "episode_s": 3.0}
    played = jawenv.play(Player("hold_still", control=control), patients=16, seed=6000, env_kwargs=kwargs)
    assert played.information_claimed[:, -1].max() < 0.5


def test_nobody_is_lost_who_follows_targets_at_a_low_rate():
    """Random targets of one second's hold; a step has twenty ticks, in which the belief would not be renewed."""
    rng = np.random.default_rng(0)
    env = gym.make_vec("jawenv/Jaw-v3", 32, cohort="one_sided", control="targets", autoreset_mode="disabled")
    env.reset(seed=6000)
    for step in range(30):
        if step % 5 == 0:
            action = rng.uniform(-1.0, 1.0, (32, 4)).astype(np.float32)
        info = env.step(action)[-1]
    assert (info["nees"] / 12.0 < 10.0).all(), info["nees"] / 12.0


def test_a_patient_who_rests_aside_is_not_lost_in_the_first_second():
    """The first tick moves the jaw by 200 sds of a reading: the muscles are not what the prior's mean says."""
    env = gym.make("jawenv/Jaw-v3", cohort="one_sided", control="targets").unwrapped
    env.reset(seed=30015)
    first = [[-0.66, -0.09, 0.0, 0.0], [-0.32, -0.18, 0.0, 0.0], [0.02, -0.27, 0.0, 0.0]]
    for action in [*first, *[[0.36, -0.36, 0.0, 0.0]] * 5]:
        info = env.step(np.array(action, dtype=np.float32))[-1]
        assert info["nees"] < 60.0
    assert info["belief_sd"].min() < 0.1


@pytest.mark.parametrize("name", ["slow_opening", "hold_still"])
def test_a_wide_prior_loses_nobody_to_a_gentle_maneuver(name):
    """The belief goes on moving for seconds, and with it the motion about which early readings were linearised."""
    played = jawenv.play(
        jawenv.Player(name, control="force"),
        patients=8,
        seed=6047,
        env_kwargs={"cohort": "wide", "episode_s": 15.0, "track_bound": False},
    )
    shares = nees(played.belief_mean[:, -1] - played.truth, played.belief_cov[:, -1]) / 12.0
    assert (shares < 10.0).all(), shares
