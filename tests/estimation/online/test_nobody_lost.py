"""Hostile actions through the real environment: whoever the patient is, the filter loses nobody."""

import gymnasium as gym
import numpy as np
import pytest

import jawenv
from agents.excitation import ACTION_SIZE, EXCITATIONS
from jawenv.estimation.online.measurement_update import GATE

EACH = 4  # patients for each way to act
SECONDS = 10.0
CORNERS = np.array(
    [[1, 1, 1, 1], [-1, -1, -1, -1], [1, -1, -1, 1], [-1, 1, 1, -1]], dtype=np.float32
)  # motors at full thrust


class Everybody:
    """All excitations and the corners at once, each for its own worlds."""

    def __init__(self, seed):
        self.parts = [make(20.0) for make in EXCITATIONS.values()]
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
    """Every number is one all the way, NEES/12 ends at 10 at most, and what the gate refuses is counted."""
    everybody = Everybody(seed=6000)
    env = gym.make_vec(
        "jawenv/Jaw-v1", everybody.worlds, cohort=cohort, control=control, episode_s=SECONDS, autoreset_mode="disabled"
    )
    observation, info = env.reset(seed=6000)
    worlds = env.unwrapped.simulation.worlds
    refused, active, moved = np.zeros(everybody.worlds), np.ones(everybody.worlds, dtype=bool), 0.0
    for _ in range(round(20 * SECONDS)):
        observation, reward, terminated, truncated, info = env.step(everybody.act())
        refused += np.where(active, 5.0 * worlds["gated"], 0.0)
        active = ~(terminated | truncated)
        assert np.isfinite(observation).all() and np.isfinite(reward).all()
        for name, values in info.items():
            assert not isinstance(values, np.ndarray) or values.dtype.kind != "f" or np.isfinite(values).all(), name
        moved = max(moved, np.abs(info["jaw_state"][:, 2]).max())
    lost = info["nees"] / 12.0 > 10.0
    assert not lost.any(), dict(zip(np.repeat(everybody.names, EACH)[lost], info["nees"][lost] / 12.0, strict=True))
    np.testing.assert_allclose(refused, worlds["belief"]["gated"], atol=1e-9)
    assert (terminated == info["violation"]).all()
    assert moved > 0.1
    assert (info["information_claimed"] > 1.0).all(), "and everybody teaches it something"
    assert CORNERS.shape == (EACH, ACTION_SIZE) and GATE > 0.0
