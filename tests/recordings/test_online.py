"""The filter that a device's loop calls: the environment's belief to the bit, in memory that does not grow."""

import gc
import os
import tracemalloc
from dataclasses import replace
from pathlib import Path

import gymnasium as gym
import numpy as np
import pytest
from recorded import BODY, SWINGS, Waves
from scipy.stats import lognorm

import jawenv
from agents import load_agent
from jawenv.anatomy import default_mandible
from jawenv.envs.configuration import Configuration, configure
from jawenv.mechanics import build_jaw
from jawenv.recordings import defaults
from jawenv.recordings.online import OnlineFilter
from jawenv.recordings.online_belief import OnlineBelief
from jawenv.recordings.record_filter import TensionFilter
from jawenv.recordings.untold.learnt import learnt

FAULTS = {"lost_share": 0.2, "frozen_share": 0.2}
NOTHING = np.full(12, np.nan)


def played(env_id="jawenv/Jaw-v3", **more):
    kwargs = {"record": True, "control": "force", "episode_s": 3.0, **more}
    return jawenv.play(Waves(), patients=1, seed=5000, env_id=env_id, env_kwargs=kwargs)


def fed(online, measured, samples):
    """Beliefs after each tick of (T + 1, 12) and (T, 3, 6)."""
    beliefs = [online.update(measured[0])]
    beliefs += [online.update(reading, during) for reading, during in zip(measured[1:], samples, strict=True)]
    return beliefs


def same(beliefs, mean, cov, every):
    np.testing.assert_array_equal([belief.log_mean for belief in beliefs[::every]], mean)
    np.testing.assert_array_equal([belief.log_cov for belief in beliefs[::every]], cov)


@pytest.mark.parametrize("faulty", [False, True], ids=["sound", "faulty"])
def test_a_records_readings_give_the_environments_belief_to_the_bit(faulty):
    run = played("jawenv/Jaw-v3", reality=FAULTS if faulty else None)
    record = run.records[0]
    beliefs = fed(jawenv.OnlineFilter.of_record(record), record.measured, record.samples)
    same(beliefs, run.belief_mean[0], run.belief_cov[0], 5)
    assert beliefs[-1].names == record.parameter_names
    assert beliefs[-1].time_s == pytest.approx(record.time[-1])
    assert any(belief.left_out > 0 for belief in beliefs[1:]) == faulty


def test_an_environments_configuration_gives_its_belief_to_the_bit():
    """Its anatomy and the ticks of its control step are in it; what is told by name comes before it."""
    anatomy = {"mandible": {"mass_kg": 0.3}}
    run = played(anatomy=anatomy, control_hz=10.0)
    record, world = run.records[0], configure({"anatomy": anatomy, "control_hz": 10.0, "control": "force"})
    for online in (OnlineFilter(world), OnlineFilter(replace(world, cohort="healthy"), cohort="trismus")):
        online.reset(record.start_mean)
        same(fed(online, record.measured, record.samples), run.belief_mean[0], run.belief_cov[0], 10)


@pytest.mark.parametrize(
    "told",
    [{"knowledge": "imaged"}, {"device": {"unmodelled_time_s": 0.5}}, {"force_sensor": "straps", "knowledge": BODY}],
)
def test_what_is_unknown_beside_the_muscles_gives_the_environments_belief_to_the_bit(told):
    env = gym.make("jawenv/Jaw-v3", **told, episode_s=4.0).unwrapped
    _, info = env.reset(seed=5000)
    infos = [info] + [env.step(0.5 * np.sin(np.arange(4.0) + k))[4] for k in range(20)]
    rows = env.simulation.ticks[0]
    online = OnlineFilter(**told, cohort="trismus", every=20)
    online.reset(env.simulation.worlds["known"]["belief"]["began"][0])
    beliefs = fed(online, rows["measured"][:401], rows["samples"][1:401])
    same(beliefs, [info["belief_mean"] for info in infos], [info["belief_cov"] for info in infos], 20)
    assert beliefs[-1].misfit == infos[-1]["misfit"] > 0.0


def test_a_geometry_of_ones_own():
    """Heavier, and tilted: the belief is that of a record that says so, and another where it is known within sds."""
    record = played().records[0]
    own = build_jaw(mandible=replace(default_mandible(), mass_kg=0.4), head_tilt_deg=5.0)
    beliefs = []
    for jaw in (own, record.jaw):
        online = OnlineFilter(jaw=jaw, cohort="trismus")
        online.reset(record.start_mean)
        beliefs.append(fed(online, record.measured, record.samples)[-1].log_mean)
        np.testing.assert_array_equal(beliefs[-1], TensionFilter().estimate(replace(record, jaw=jaw)).mean[-1])
    assert np.abs(beliefs[0] - beliefs[1]).max() > 0.01
    imaged = [OnlineFilter(knowledge="imaged", **more) for more in ({}, {"jaw": record.jaw}, {"jaw": own})]
    for online in imaged:
        online.reset(record.start_mean)
    last = [fed(online, record.measured, record.samples)[-1] for online in imaged]
    np.testing.assert_array_equal(last[0].log_mean, last[1].log_mean)
    assert np.abs(last[0].log_mean - last[2].log_mean).max() > 1e-3
    default, ours = (online._settings["nuisances"] for online in imaged[1:])
    for name in ("mass", "first_moment", "inertia", "gravity", "fossa_drop", "offset"):  # an sd is as large
        np.testing.assert_array_equal(ours[name], default[name], err_msg=name)


def test_a_start_that_is_not_told_follows_from_the_first_reading():
    """``load_record`` has the same of a file that does not say."""
    record = played().records[0]
    start = defaults.motion_of_reading(record.jaw, record.measured[0], record.measurement_sd)
    unknown = replace(record, start_mean=start, start_sd=defaults.start_sd(record.jaw))
    expected = TensionFilter().estimate(unknown)
    last = fed(OnlineFilter(cohort="trismus"), record.measured, record.samples)[-1]
    np.testing.assert_allclose(last.log_mean, expected.mean[-1], rtol=1e-6)
    np.testing.assert_allclose(last.log_cov, expected.cov[-1], rtol=1e-4, atol=1e-10)


def test_a_reset_forgets_all():
    record = played().records[0]
    online = OnlineFilter.of_record(record)
    first = fed(online, record.measured, record.samples)
    elsewhere = replace(record, start_mean=np.zeros(10))
    online.reset(elsewhere.start_mean)
    other = fed(online, record.measured, record.samples)[-1]
    np.testing.assert_array_equal(other.log_mean, TensionFilter().estimate(elsewhere).mean[-1])
    online.reset()
    again = fed(online, record.measured, record.samples)
    same(again, [belief.log_mean for belief in first], [belief.log_cov for belief in first], 1)
    assert [belief.misfit for belief in again] == [belief.misfit for belief in first]
    assert not np.shares_memory(again[-1].log_mean, again[-2].log_mean)


def memory():
    """Bytes that Python has allocated, and those of this process that no file backs (0 where the system is silent)."""
    gc.collect()
    statm, own = Path("/proc/self/statm"), 0
    if statm.exists():
        resident, shared = map(int, statm.read_text().split()[1:3])
        own = (resident - shared) * os.sysconf("SC_PAGE_SIZE")
    return tracemalloc.get_traced_memory()[0], own


def test_5000_updates_take_no_memory():
    """What leaks grows in every thousand updates; what the interpreter keeps once, or another thread, does not."""
    agent = load_agent(SWINGS, control="force")
    run = jawenv.play(agent, patients=1, seed=6000, env_kwargs={"record": True, "episode_s": 52.0})
    record = run.records[0]
    online = OnlineFilter.of_record(record)
    online.update(record.measured[0])
    gc.collect()
    tracemalloc.start()
    sizes = np.zeros((6, 2))
    for k, (measured, samples) in enumerate(zip(record.measured[1:], record.samples, strict=True)):
        belief = online.update(measured, samples)
        if k % 1000 == 199:
            sizes[k // 1000] = memory()
    tracemalloc.stop()
    grown = np.diff(sizes, axis=0)
    assert len(record.samples) == 5200 and (sizes[:, 0] > 0.0).all()
    assert (grown.min(axis=0) < 4000.0).all()  # four bytes an update: the smallest object of Python's has 16
    assert (grown.sum(axis=0) < [2**16, 2**22]).all()
    assert belief.log_sd.max() < 0.05


def test_a_belief_in_units_of_the_parameters():
    """Mean and sd of lognormal distributions, as SciPy has them."""
    cov = np.array([[0.09, 0.02], [0.02, 0.25]])
    belief = OnlineBelief(("log_F_o/a", "log_b/a"), 0.0, np.log([2.0, 7.0]), cov, 0.0, 0, 0, 0, False)
    expected = lognorm(s=[0.3, 0.5], scale=[2.0, 7.0])
    np.testing.assert_allclose(belief.log_sd, [0.3, 0.5])
    np.testing.assert_allclose(belief.mean, expected.mean())
    np.testing.assert_allclose(belief.sd, expected.std())


@pytest.fixture(scope="module")
def online():
    return OnlineFilter()


@pytest.mark.parametrize(
    ("measured", "samples", "message"),
    [
        (np.zeros(11), np.zeros((3, 6)), "measured has shape (11,); allowed: (12,)"),
        (np.zeros((1, 12)), np.zeros((3, 6)), "measured has shape (1, 12); allowed: (12,)"),
        (["a"] * 12, np.zeros((3, 6)), "measured is "),
        (np.zeros(12), np.zeros(18), "samples has shape (18,); allowed: (3, 6)"),
        (np.zeros(12), None, "samples is None; allowed after the first update: shape (3, 6), NaN where not read"),
    ],
)
def test_readings_of_another_shape_are_refused_and_change_nothing(online, measured, samples, message):
    record = played().records[0]
    online.reset(record.start_mean)
    fed(online, record.measured[:7], record.samples[:6])
    with pytest.raises(jawenv.InputError) as refused:
        online.update(measured, samples)
    assert str(refused.value).startswith(message) and "\n" not in str(refused.value)
    after = online.update(record.measured[7], record.samples[6])
    online.reset(record.start_mean)
    expected = fed(online, record.measured[:8], record.samples[:7])[-1]
    np.testing.assert_array_equal(after.log_mean, expected.log_mean)
    assert after.time_s == expected.time_s


def test_a_filter_that_knows_no_start_waits_for_a_reading(online):
    online.reset()
    with pytest.raises(jawenv.InputError):
        online.update(NOTHING)
    assert online.update(played().records[0].measured[0]).time_s == 0.0
    online.reset(np.zeros(10))
    assert online.update(NOTHING).left_out == 12


@pytest.mark.parametrize(
    "arguments",
    [
        (np.zeros(12),),
        (np.full(10, np.nan),),
    ],
)
def test_what_a_reset_refuses(online, arguments):
    with pytest.raises(jawenv.InputError):
        online.reset(*arguments)


@pytest.mark.parametrize(
    "arguments",
    [
        {"every": 0},
        {"every": 2.5},
        {"head_tilt_deg": np.nan},
        {"head_tilt_deg": 91},
        {"model": "shark"},
        {"jaw": defaults.geometry_of(Configuration(model="portions"))},
        {"jaw": build_jaw(), "head_tilt_deg": 3},
        {"cohort": "fish"},
        {"sensors": "smell"},
        {"knowledge": "vague"},
        {"chort": "trismus"},
    ],
)
def test_what_the_constructor_refuses(arguments):
    with pytest.raises(jawenv.InputError):
        OnlineFilter(**arguments)


def test_a_person_without_a_scan_is_believed_as_the_readings_so_far_have_it():
    """The filter's own error bars are so narrow that NEES/12 is 20 to 50."""
    world = {"record": True, "episode_s": 6.0, "knowledge": "imaged", "reality": {"attachment_error": 1.0}}
    record = jawenv.play(load_agent("refined"), patients=1, seed=499_000, env_kwargs=world).records[0]
    online = OnlineFilter(knowledge="imaged", cohort="trismus", device=record.device)
    with pytest.raises(jawenv.InputError, match="0 updates were made; allowed: 2 or more"):
        online.record()
    belief = fed(online, record.measured, record.samples)[-1]
    found = learnt(online.record(), belief.log_mean, belief.log_cov)
    np.testing.assert_array_equal(online.record().measured, record.measured)
    np.testing.assert_array_equal(online.record().samples, record.samples)
    away = belief.log_mean - record.truth, found.mean - record.truth
    squares = [
        error @ np.linalg.solve(cov, error) / 12 for error, cov in zip(away, (belief.log_cov, found.cov), strict=True)
    ]
    assert squares[0] > 8.0 and squares[1] < 2.0 and found.sizes["lines"] == 10.0
    again = OnlineFilter.of_record(record)
    belief = fed(again, record.measured, record.samples)[-1]
    assert learnt(again.record(), belief.log_mean, belief.log_cov).sizes == found.sizes
