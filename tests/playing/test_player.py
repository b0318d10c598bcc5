"""The player against a simple jaw of its own: first order, springs, a forward push also closes it."""

from dataclasses import dataclass, field

import numpy as np
import pytest

from jawenv.base.errors import InputError
from jawenv.device.device import Device
from jawenv.envs.observation import FORCE_SCALE, OBSERVATION_LAYOUT, Parts
from jawenv.playing.maneuvers.maneuver import Maneuver, Player

DT = 0.05
OPENING_MM, SIDE_MM = 24.0, 6.0
THRUST_N, RATE_MM_S = Device().full_scale_N, Device().max_rate_mm_s


@dataclass
class SpringJaw:
    """N jaws whose opening (mm), side (mm) and fore-aft place (mm) lag behind what drives them.

    `stiffness` multiplies typical springs; a fore-aft push of `reach_N` uses up the limit of the fore-aft excursion.
    """

    control: str
    stiffness: np.ndarray
    reach_N: float = 100.0
    opening: np.ndarray = field(init=False)
    side: np.ndarray = field(init=False)
    fore_aft_N: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        self.opening = np.zeros(len(self.stiffness))
        self.side, self.fore_aft_N = self.opening.copy(), self.opening.copy()

    def step(self, action: np.ndarray) -> None:
        down, forward = action[:, :2].sum(axis=1), action[:, 2:].sum(axis=1)
        yaw = action[:, 3] - action[:, 2]
        if self.control == "trajectory":
            self.opening += RATE_MM_S * down / 2.0 * DT
            self.side += RATE_MM_S * yaw * DT
            self.fore_aft_N += RATE_MM_S * forward / 2.0 * self.stiffness * DT
            return
        follow = 1.0 - np.exp(-DT / 0.06)
        self.fore_aft_N = THRUST_N * forward
        push = THRUST_N * down - 0.5 * self.fore_aft_N
        self.opening += follow * (push / (0.12 * self.stiffness) - self.opening)
        self.side += follow * (0.03 * THRUST_N * yaw / (0.012 * self.stiffness) - self.side)

    def observe(self) -> np.ndarray:
        seen = np.zeros((len(self.opening), Parts().size), dtype=np.float32)
        part = {name: seen[:, place] for name, place in OBSERVATION_LAYOUT.items()}
        pitch = self.opening / 91.0
        part["pose"][:, 2] = pitch / 0.25
        part["jaw"][:, 0], part["jaw"][:, 1] = self.opening / OPENING_MM, self.side / SIDE_MM
        part["jaw_range"][:] = OPENING_MM / 30.0, SIDE_MM / 10.0, 0.5
        part["force"][:, 0], part["force"][:, 2] = (
            np.array([np.cos(pitch), np.sin(pitch)]) * self.fore_aft_N / FORCE_SCALE
        )
        part["comfort_margin"][:] = 1.0
        part["comfort_margin"][:, 3] -= np.abs(self.fore_aft_N) / self.reach_N
        return seen


def maneuver(**channels: dict) -> Maneuver:
    still = {"kind": "keyframes", "points": [{"t_s": 0, "value": 0}]}
    return Maneuver.model_validate(
        {
            "name": "tried",
            "title": "Tried",
            "description": "a test",
            "source": "this file",
            "channels": {"opening": still, **channels},
        }
    )


def swings(fore_aft: float = 0.2) -> Maneuver:
    return maneuver(
        opening={"kind": "keyframes", "points": [{"t_s": 0, "value": 0}, {"t_s": 8, "value": 0.8}]},
        side={"kind": "harmonics", "harmonics": [{"amplitude": 0.7, "period_s": 4}]},
        fore_aft={"kind": "harmonics", "harmonics": [{"amplitude": fore_aft, "period_s": 7}]},
    )


def play(agent: Player, jaw: SpringJaw, seconds: float) -> tuple[np.ndarray, np.ndarray]:
    """Places (opening, side, fore-aft force) as fractions (T, N, 3), and actions (T, N, 4)."""
    agent.reset(len(jaw.opening))
    places, actions = [], []
    for _ in range(round(seconds / DT)):
        action, _ = agent.predict(jaw.observe())
        jaw.step(action)
        places.append(np.stack([jaw.opening / OPENING_MM, jaw.side / SIDE_MM, jaw.fore_aft_N / FORCE_SCALE], axis=-1))
        actions.append(action)
    return np.array(places), np.array(actions)


def test_in_trajectory_control_the_motors_follow_a_jaw_that_moves_away() -> None:
    """A jaw that would load the motors with 1 N/s meets a small force, not one that grows."""
    jaw = SpringJaw("trajectory", stiffness=np.ones(2))
    agent = Player(maneuver(), control="trajectory")
    agent.reset(2)
    forces = []
    for _ in range(200):
        jaw.fore_aft_N += 0.05
        jaw.step(agent.predict(jaw.observe())[0])
        forces.append(jaw.fore_aft_N.copy())
    assert np.abs(forces).max() < 0.1


@pytest.mark.parametrize("control", ["trajectory", "force"])
def test_worlds_do_not_touch_each_other(control: str) -> None:
    stiffness = np.array([0.7, 1.0, 1.5])
    together, _ = play(Player(swings(), control=control), SpringJaw(control, stiffness), 6.0)
    for world in range(3):
        alone, _ = play(Player(swings(), control=control), SpringJaw(control, stiffness[world : world + 1]), 6.0)
        np.testing.assert_array_equal(together[:, world], alone[:, 0])


def test_a_new_episode_starts_in_its_world_alone() -> None:
    jaw = SpringJaw("force", np.ones(3))
    agent = Player(swings(), control="force")
    for _ in range(40):
        jaw.step(agent.predict(jaw.observe())[0])
    _, state = agent.predict(jaw.observe(), episode_start=np.array([False, True, False]))
    assert state is not None
    np.testing.assert_array_equal(state.of_worlds[0], [41, 1, 41])
    alone = agent.predict(jaw.observe()[1:2], None, np.array([True]))[1]
    assert state.of_worlds[1][1] == alone.of_worlds[1][0]


def test_a_push_that_uses_up_a_limit_becomes_smaller() -> None:
    jaw = SpringJaw("force", np.ones(2), reach_N=3.0)
    agent = Player(swings(fore_aft=0.4), control="force")
    places, _ = play(agent, jaw, 28.0)
    used = np.abs(places[..., 2]) * FORCE_SCALE / 3.0
    assert used.max() < 1.1 and used[-140:].max() < 0.95
    _, state = agent.predict(jaw.observe())
    assert state is not None
    size = state.of_worlds[1]["size"]
    assert (size[:, 2] < 0.6).all() and (size[:, :2] == 1.0).all()


def test_a_push_within_the_limit_is_left_alone() -> None:
    places, _ = play(Player(swings(fore_aft=0.1), control="force"), SpringJaw("force", np.ones(1), reach_N=5.0), 21.0)
    assert np.abs(places[..., 2]).max() == pytest.approx(0.1, rel=0.02)


def test_roll_is_the_difference_of_the_vertical_motors() -> None:
    turn = {"kind": "keyframes", "points": [{"t_s": 0, "value": 0}, {"t_s": 2, "value": 1}]}
    for control in ("trajectory", "force"):
        jaw = SpringJaw(control, np.ones(1))
        agent = Player(maneuver(roll=turn), control=control)
        for _ in range(20):
            action, _ = agent.predict(jaw.observe())
        assert action[0, 1] > 0 > action[0, 0] and action[0, 1] == pytest.approx(-action[0, 0], abs=1e-6)
    _, actions = play(Player(maneuver(), control="force"), SpringJaw("force", np.ones(1)), 2.0)
    np.testing.assert_array_equal(actions[..., 0], actions[..., 1])


def test_wrong_input_is_named() -> None:
    with pytest.raises(InputError):
        Player(swings(), control="position")  # type: ignore[arg-type]
    with pytest.raises(InputError):
        Player(swings(), control_hz=-1, control="force")
    agent = Player(swings(), control="force")
    with pytest.raises(InputError):
        agent.predict(np.zeros((2, 5)))
    rows = SpringJaw("force", np.ones(2)).observe()
    agent.predict(rows)
    with pytest.raises(InputError):
        agent.predict(rows[:1])
    rows[1, 3] = np.nan
    with pytest.raises(InputError):
        agent.predict(rows)
