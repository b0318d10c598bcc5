"""Nuisances: regressors against the independent jaw, what their mean does to the model, and whether it is honest."""

from dataclasses import replace

import gymnasium as gym
import newton_euler as twin
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode

from jawenv.anatomy.knowledge import IMAGED, Knowledge
from jawenv.base.errors import InputError
from jawenv.envs.configuration import Configuration, configure
from jawenv.envs.simulation import Simulation
from jawenv.filter.belief.state import FARTHEST
from jawenv.filter.nuisances.changed_jaw import copy_jaw, move_jaw
from jawenv.filter.nuisances.changes import Midway, add_readings, set_wrenches
from jawenv.filter.nuisances.unknowns import cell_turn_of, changed_jaw, offset_of, scaled, turn_of
from jawenv.filter.updates.measurement_update import EXPECTED
from jawenv.kernels.compiled import njit
from jawenv.playing.maneuvers import Player
from jawenv.recordings.online import take_tick

EPS = 1e-3  # sds


KNOWN = replace(
    IMAGED, attachments=0.3, cell_deg=0.5, closing_tone_N=0.1, wrench_N=0.2, axes_mm=2.0
)  # all that has a column

# A filter is compiled for a number of columns. Episodes are played with as many as ``IMAGED`` has, which is compiled
# for other tests too: what stands here leaves some out.
CELL_TURNED = replace(IMAGED, cell_deg=1.0, mouthpiece_mm=0.0)
LARGEST = {name: kind.high for name, kind in Knowledge.numeric_fields().items()} | {
    "closing_tone_N": 0.0,
    "wrench_N": 0.0,
}
LARGEST_INSIDE = LARGEST | {"mouthpiece_mm": 0.0, "head_tilt_deg": 0.0, "cell_deg": 0.0}
LARGEST_OUTSIDE = LARGEST | {"attachments": 0.1, "fossa": 0.0, "axes_mm": 0.0}
COLUMNS_OF_IMAGED = 57


@pytest.fixture(scope="module")
def simulation():
    """One whose episode has not begun: kernels of its columns alone are compiled, no filter of so many."""
    made = Simulation(1, Configuration(knowledge=KNOWN))
    made.models[0] = made._jaw
    made.models[0]["tone"] = 0.3
    return made


@njit
def wrenches_of(jaw, muscles, at, settings, columns, scratch):
    set_wrenches(jaw, muscles, at, settings.nuisances, 0, columns, scratch)


@njit
def readings_of(jaw, motion, settings, used, rows, scratch):
    add_readings(jaw, motion, settings.nuisances, used, 0, rows, scratch)


@njit
def moved(jaw, settings, steps, result):
    copy_jaw(jaw, result)
    move_jaw(result, settings.nuisances, steps, 0)


def read_tick(simulation, belief, measured, samples):
    """One tick late in an episode, which is kept nowhere."""
    settings, scratch = simulation.settings[0]["filter"], simulation.scratches[0]["filter"]
    rows = simulation.ticks[0, :0]
    beliefs = belief, simulation.worlds["known"]["kept"][0]
    take_tick(simulation.models[0], beliefs, rows, (1001, 5), measured, samples, settings, scratch)


def motion_at(rng):
    """A pose within the painless range, clear of the teeth, with rates."""
    q = np.array([4e-3, 1e-3, 0.15, 0.05, -0.04]) * rng.uniform(0.5, 1.5, 5)
    return np.concatenate([q, rng.normal(size=5) * [0.02, 0.02, 0.3, 0.3, 0.3]])


def by_differences(simulation, values, motion, wrench, acceleration):
    """The change of the acceleration by one sd, of the independent jaw, whose device is turned and off by an offset."""
    jaw, muscles = simulation.models[0], simulation.cohort.muscles
    theta = simulation.cohort.prior.mean

    def at(share):
        changed = changed_jaw(jaw, KNOWN, muscles, scaled(values, share))
        about = share * cell_turn_of(KNOWN, values)
        x, y, opening, yaw = motion[:4] / [5e-3, 3e-3, 0.2, 0.05]
        shapes = np.array([1.0, opening, opening**2, x, y, yaw])
        true = wrench - share * shapes @ offset_of(KNOWN, values).reshape(6, 6)
        true = true + np.concatenate([np.cross(about, wrench[:3]), np.cross(about, wrench[3:])])
        return acceleration(changed, theta, motion[:5], motion[5:], true)

    return (at(EPS) - at(-EPS)) / (2.0 * EPS)


def test_a_nuisances_wrench_does_to_the_jaw_what_the_nuisance_does(simulation, rng):
    settings, scratch = simulation.settings[0]["filter"], simulation.scratches[0]["filter"]["time"]["nuisances"]
    jaw, theta = simulation.models[0], simulation.cohort.prior.mean
    muscles = np.exp(theta).reshape(-1, 2)[jaw["muscle"]]
    for _ in range(3):
        motion, wrench = motion_at(rng), rng.normal(size=6) * [3.0, 3.0, 3.0, 0.05, 0.05, 0.05]
        columns = np.zeros((6, len(simulation.nuisance_sds)))
        rate = twin.acceleration(jaw, theta, motion[:5], motion[5:], wrench)
        at = Midway(tuple(motion[:5]), tuple(motion[5:]), tuple(rate), tuple(wrench), False)
        wrenches_of(jaw, muscles, at, settings, columns, scratch)
        by_wrench = twin.derivative(lambda w, m=motion: twin.acceleration(jaw, theta, m[:5], m[5:], w), wrench)
        for j, values in enumerate(simulation.nuisance_sds):
            expected = by_differences(simulation, values, motion, wrench, twin.acceleration)
            np.testing.assert_allclose(
                by_wrench @ columns[:, j], expected, rtol=0.03, atol=2e-3 * np.abs(by_wrench).max(), err_msg=f"{j}"
            )


def test_what_a_jaw_at_rest_shows_and_what_accelerations_show_make_the_whole(rng):
    """Beside a disturbance with memory mass and centre of mass are two numbers each; damping is in motion alone."""
    made = Simulation(1, Configuration(knowledge=KNOWN, device={"unmodelled_time_s": 0.5}))
    settings, scratch = made.settings[0]["filter"], made.scratches[0]["filter"]["time"]["nuisances"]
    muscles = np.exp(made.cohort.prior.mean).reshape(-1, 2)[made._jaw["muscle"]]
    motion, wrench = motion_at(rng), rng.normal(size=6)

    def columns(motion, rate, apart):
        found = np.zeros((6, len(made.nuisance_sds)))
        at = Midway(tuple(motion[:5]), tuple(motion[5:]), tuple(rate), tuple(wrench), apart)
        wrenches_of(made._jaw, muscles, at, settings, found, scratch)
        return found

    rate = rng.normal(size=5)
    whole, apart = columns(motion, rate, False), columns(motion, rate, True)
    still = columns(motion * np.repeat([1.0, 0.0], 5), np.zeros(5), False)
    again, at_rest = (settings["nuisances"][name].astype(bool) for name in ("again", "at_rest"))
    body = np.array([values["mass"].any() or values["centre_of_mass"].any() for values in made.nuisance_sds])
    assert again.sum() == body.sum() == 4
    np.testing.assert_allclose(apart[:, at_rest], still[:, at_rest], atol=1e-12)
    np.testing.assert_allclose(apart[:, again] + apart[:, body], whole[:, body], atol=1e-12)
    damping = np.array([values["damping"].any() for values in made.nuisance_sds])
    assert damping.sum() == 2 and not (damping & (again | at_rest)).any()
    np.testing.assert_allclose(apart[:, damping], whole[:, damping], atol=1e-12)
    assert np.abs(whole[:, damping]).max() > 1e-3


def test_a_nuisance_changes_the_readings_as_the_independent_jaw_says(simulation, rng):
    settings, scratch = simulation.settings[0]["filter"], simulation.scratches[0]["filter"]["update"]["nuisances"]
    jaw, motion = simulation.models[0], motion_at(rng)
    rows, used = np.zeros((12, len(simulation.nuisance_sds))), np.ones(12, dtype=np.uint8)
    readings_of(jaw, motion, settings, used, rows, scratch)

    def read(values, share):
        changed = changed_jaw(jaw, KNOWN, simulation.cohort.muscles, scaled(values, share))
        measured = np.array(twin.measurement(changed, motion))
        measured[:3] -= changed["zero"]
        about = share * turn_of(KNOWN, values)
        for places in ([5, 3, 4], [9, 10, 11]):  # roll, pitch, yaw are about x, y, z
            measured[places] -= np.cross(about, measured[places])
        return measured

    for j, values in enumerate(simulation.nuisance_sds):
        expected = (read(values, EPS) - read(values, -EPS)) / (2.0 * EPS)
        np.testing.assert_allclose(rows[:, j], expected, atol=2e-6, rtol=0.01, err_msg=f"{j}")


def test_the_model_moves_with_the_nuisances(simulation, rng):
    """To that of the same values, but for products of two."""
    jaw, record = simulation.models[0], simulation.models[0].copy()
    steps = np.zeros(len(simulation.nuisance_sds))
    for j in range(len(steps)):
        steps[:] = 0.0
        steps[j] = 0.5
        moved(jaw, simulation.settings[0]["filter"], steps, record)
        values = scaled(simulation.nuisance_sds[j], 0.5)
        expected = changed_jaw(jaw, KNOWN, simulation.cohort.muscles, values)
        for name in ("mass", "centre_of_mass", "gravity", "mouthpiece", "zero", "teeth", "fossa_drop", "crest", "l_o"):
            scale = np.abs(expected[name]).max()
            np.testing.assert_allclose(record[name], expected[name], rtol=5e-3, atol=1e-4 * scale, err_msg=name)
        np.testing.assert_allclose(
            record["inertia_contact_inverse"], expected["inertia_contact_inverse"], rtol=0.05, atol=20.0
        )


def play(knowledge, worlds, seconds, seed, maneuver="refined", **kwargs):
    """Info after a maneuver."""
    disabled = AutoresetMode.DISABLED
    envs = gym.make_vec("jawenv/Jaw-v3", worlds, knowledge=knowledge, episode_s=60.0, autoreset_mode=disabled, **kwargs)
    observations, info = envs.reset(seed=seed)
    player = Player(maneuver, control="targets")
    player.reset(worlds, 0)
    for _ in range(5 * seconds):
        actions, _ = player.predict(observations)
        observations, _, _, _, info = envs.step(actions)
    return envs, info


def test_what_is_unknown_is_marginalised_honestly():
    """Anatomy, mass, tilt, registration, offset and damping drawn for each of 48 patients, seeds of no other use."""
    _, info = play("imaged", 48, 8, 987_000)
    z = (info["belief_mean"] - info["truth"]) / info["belief_sd"]
    assert 0.8 < np.mean(info["nees"]) / 12 < 1.5
    assert np.max(info["nees"]) / 12 < 6.0
    assert np.mean(np.abs(z) < 2.0) > 0.9
    assert np.mean(info["misfit"] > 1.0) < 0.05
    assert np.median(info["belief_sd"]) < 0.08, "and it teaches"


def test_a_wrench_that_no_muscle_pulls_is_marginalised_honestly():
    """Beside all that a scan leaves uncertain: its thirty numbers are drawn, and the filter follows what they do."""
    envs, info = play("bench", 24, 10, 990_000)
    assert 0.7 < np.mean(info["nees"]) / 12 < 1.3
    worlds = envs.unwrapped.simulation.worlds
    truth, belief = worlds["truth"], worlds["known"]["belief"]
    assert np.std(truth["cell_offset"][:, 6:9]) == pytest.approx(0.1, rel=0.3)
    drawn = np.any(envs.unwrapped.simulation.settings["filter"]["nuisances"]["offset"][0][:, 6:] != 0.0, axis=1)
    assert np.corrcoef(belief["nuisances"][:, drawn].ravel(), truth["nuisances"][:, drawn].ravel())[0, 1] > 0.3


def test_a_maneuver_that_teaches_little_is_honest_too():
    """Nuisances are told apart by small differences, which the noise of a tick must not be in (``instrument``)."""
    _, info = play("imaged", 32, 20, 988_000, "opening_with_swings")
    assert 0.6 < np.mean(info["nees"]) / 12 < 1.3
    assert np.max(info["nees"]) / 12 < 4.0


def test_what_is_derived_holds_nothing_of_the_ticks_own_readings(rng):
    envs, _ = play("imaged", 1, 2, 989_000, "opening_with_swings")
    simulation = envs.unwrapped.simulation
    rows, scratch, found = simulation.ticks[0], simulation.scratches[0]["filter"], []
    for noise in (0.0, 0.1):
        belief = simulation.worlds["known"]["belief"][:1].copy()
        samples = rows[100]["samples"] + noise * rng.normal(size=(3, 6))
        measured = rows[100]["measured"] + 1e-3 * noise * rng.normal(size=12)
        read_tick(simulation, belief[0], measured, samples)
        found.append((belief["motion"].copy(), scratch["time"]["total"].copy(), scratch["time"]["line_wrench"].copy()))
        found[-1] += (scratch["update"]["rows"].copy(),)
    (moved_one, *one), (moved_other, *other) = found
    assert not np.array_equal(moved_one, moved_other)
    for name, first, second in zip(("[A, G]", "wrenches", "H"), one, other, strict=True):
        np.testing.assert_array_equal(first, second, err_msg=name)


def test_a_prediction_that_is_lost_loses_the_motion_and_nothing_else():
    """The motion under this tick's readings may be finite where that under the ticks' before is not."""
    envs, _ = play("imaged", 1, 2, 989_000)
    simulation = envs.unwrapped.simulation
    rows, belief = simulation.ticks[0], simulation.worlds["known"]["belief"][:1].copy()
    belief["smoothed"] = np.nan
    read_tick(simulation, belief[0], rows[200]["measured"].astype(float), rows[200]["samples"].astype(float))
    for name in ("motion", "motion_cov", "by_tension", "information", "score"):
        assert np.isfinite(belief[name]).all(), name
    assert simulation.scratches[0]["filter"]["verdict"] == EXPECTED, "and the tick's readings are used"


def test_a_cell_whose_axes_are_off_is_honest_where_that_is_known():
    _, told = play(CELL_TURNED, 24, 6, 986_000)
    _, untold = play("exact", 24, 6, 986_000, reality={"cell_error_deg": 1.0})
    assert 0.7 < np.mean(told["nees"]) / 12 < 1.4 < 5.0 < np.mean(untold["nees"]) / 12


@pytest.mark.parametrize("largest", [LARGEST_INSIDE, LARGEST_OUTSIDE], ids=["inside", "outside"])
def test_whatever_is_done_a_model_stays_one(largest):
    """Full commands at the largest sds: numbers stay finite, and no nuisance is believed beyond its limit."""
    envs = gym.make_vec(
        "jawenv/Jaw-v3",
        16,
        knowledge=largest,
        control="trajectory",
        cohort="wide",
        episode_s=4.0,
        autoreset_mode=AutoresetMode.DISABLED,
    )
    envs.reset(seed=3)
    actions = np.array([[1.0 - 2.0 * (i >> k & 1) for k in range(4)] for i in range(16)], dtype=np.float32)
    for _ in range(60):
        observations, rewards, _, _, info = envs.step(actions)
        for values in (observations, rewards, info["belief_cov"], info["misfit"]):
            assert np.isfinite(values).all()
    believed = envs.unwrapped.simulation.worlds["known"]["belief"]["nuisances"]
    assert believed.shape[1] == COLUMNS_OF_IMAGED  # else a filter is compiled for this test alone
    assert 1.0 < np.abs(believed).max() <= FARTHEST


def test_what_cannot_be_had_together_is_one_line():
    with pytest.raises(InputError):
        configure({"knowledge": "imaged", "model": "sagittal"})
