"""Sizes of errors that nobody told: the algebra against dense formulas, and patients whose load cell is off."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import jawenv
from jawenv.base.errors import InputError
from jawenv.filter.model.basis import build_basis, set_coefficients, set_derivatives
from jawenv.mechanics import build_jaw
from jawenv.metrics.calibration import nees
from jawenv.recordings.identification import identified
from jawenv.recordings.untold import bank, law
from jawenv.recordings.untold import blocks as parts
from jawenv.recordings.untold.blocks import N_OF_DRIFT, N_OF_WRENCH, Blocks, blocks_of
from jawenv.recordings.untold.definite import factor
from jawenv.recordings.untold.learnt import identified_with_errors, learnt, learnt_beliefs
from jawenv.recordings.untold.temperature import excess, joint_of
from research.untold import Sines

PATIENTS = 4
PRIOR = jawenv.COHORTS["trismus"].prior


@cache
def played(**reality):
    kwargs = {"record": True, "episode_s": 20.0, "control": "targets", "reality": reality, "track_bound": False}
    return jawenv.play(Sines("sines"), patients=PATIENTS, seed=995_000, env_kwargs=kwargs)


def of_cell():
    return played(cell_bias_N=0.3, cell_bias_N_m=0.006)


def last(recording):
    return recording.belief_mean[:, -1], recording.belief_cov[:, -1]


def first(recording):
    return tuple(part[0] for part in last(recording))


@pytest.fixture
def blocks(rng):
    """Blocks of a made-up likelihood, with what it was made of: true columns behind the tensions."""
    basis = build_basis(build_jaw(), PRIOR)[0]
    nominal = np.zeros((6, 5))
    set_coefficients(basis, PRIOR.mean, nominal)
    columns, count = 30 + 1 + 4 + N_OF_DRIFT + N_OF_WRENCH, 40
    rows = rng.normal(size=(count, 60, columns))
    rows[:, :, :30] /= np.abs(nominal).max()
    truth = np.zeros(columns)
    truth[-N_OF_WRENCH:] = 0.1 * rng.standard_normal(N_OF_WRENCH)
    read = rows @ truth + rng.standard_normal((count, 60))
    return Blocks(
        information=np.swapaxes(rows, 1, 2) @ rows,
        score=np.einsum("bri,br->bi", rows, read),
        poses=rng.normal(size=(count, 5)),
        own=np.zeros(columns - 30, dtype=bool),
        attachments=np.zeros(columns - 30, dtype=bool),
        tilt=np.zeros(columns - 30, dtype=bool),
        by_end=np.zeros((2, columns - 30, 6, 3)),
        gain_sd=0.01,
        scan_assumed=True,
        wrench_assumed=0.0,
        point=PRIOR.mean,
        basis=basis,
        nominal=nominal,
        prior_mean=PRIOR.mean,
        prior_sd=PRIOR.sd,
    ), truth


def joint(blocks):
    found = bank.mixture(blocks, 1.0)
    return joint_of(blocks, found.best, found.sizes, 1.0)


def test_tensions_are_those_of_the_filter(rng, blocks):
    theta = PRIOR.mean + PRIOR.sd * rng.standard_normal((3, 12))
    values, derivatives = law.tensions(blocks[0].basis, theta)
    for k in range(3):
        expected, by_log = np.zeros((6, 5)), np.zeros((30, 12))
        set_coefficients(blocks[0].basis, theta[k], expected)
        set_derivatives(blocks[0].basis, theta[k], by_log)
        np.testing.assert_allclose(values[k], expected.ravel(), rtol=1e-10, atol=1e-12)
        np.testing.assert_allclose(derivatives[k], by_log, rtol=1e-10, atol=1e-12)


def test_bends_change_a_law_by_as_much_as_they_say_and_as_no_parameter_does(blocks):
    basis, nominal, found = blocks[0].basis, blocks[0].nominal, law.bends(blocks[0])
    strains = law.STRAINS
    for m in range(6):
        exponentials = np.exp(basis["nodes"][m] * (strains - basis["centre"][m])[:, None])
        relative = (
            exponentials @ found.reshape(6, 5, 12)[m, :, 2 * m : 2 * m + 2] / (exponentials @ nominal[m])[:, None]
        )
        np.testing.assert_allclose(np.mean(relative**2, axis=0), 1.0, rtol=0.05)
        np.testing.assert_allclose(relative.T @ np.column_stack([np.ones_like(strains), strains]), 0.0, atol=0.1)


def test_what_is_integrated_out_leaves_what_dense_covariances_leave(blocks):
    one, _ = blocks
    sizes = np.array([[1.0, 0.1, 0.3, 0.3, 1.0, law_size] for law_size in bank.LAWS])
    information, score, _ = bank._about_tensions(one, 2.0, sizes)
    total, pulled = one.information.sum(axis=0) / 2.0, one.score.sum(axis=0) / 2.0
    prior = np.concatenate([np.zeros(30), one.sds(sizes[:1])[0] ** -2.0])
    cov = np.linalg.inv(total + np.diag(prior))
    np.testing.assert_allclose(np.linalg.inv(information[0]), cov[:30, :30], rtol=1e-6, atol=1e-12)
    np.testing.assert_allclose(np.linalg.solve(information[0], score[0]), (cov @ pulled)[:30], rtol=1e-5, atol=1e-9)
    bent = sizes[2, -1] * law.bends(one)
    wider = np.linalg.inv(information[0]) + bent @ bent.T
    np.testing.assert_allclose(np.linalg.inv(information[2]), wider, rtol=1e-4, atol=1e-5)


def test_a_size_that_is_there_is_found_and_one_that_is_not_is_zero(blocks):
    one, _ = blocks
    found = bank.mixture(one, 1.0)
    np.testing.assert_allclose(found.sizes, [1.0, 0.1, 0.1, 0.0, 1.0, 0.0])
    without = replace(one, score=np.einsum("bij,j->bi", one.information, np.zeros(one.score.shape[1])))
    np.testing.assert_array_equal(bank.mixture(without, 1.0).sizes, [1.0, 0.0, 0.0, 0.0, 1.0, 0.0])


def test_lines_are_those_of_the_mean_anatomy_where_nobody_told_of_a_scan(blocks):
    """The made-up readings say nothing of lines, so that weights are those beforehand."""
    one, _ = blocks
    for wrench, expected in ((0.1, [0.05, 0.05, 0.9]), (0.0, [1.0 / 3.0] * 3)):
        found = bank.mixture(replace(one, wrench_assumed=wrench), 1.0)
        shares = [found.weights[found.every[:, 4] == level].sum() for level in bank.LEVELS["lines"]]
        np.testing.assert_allclose(shares, expected, atol=1e-9)


def test_two_muscles_that_explain_each_others_readings_are_rivals_and_their_valley_is_bent(blocks):
    """The sum of two tensions is told, and is so large that the prior wants one muscle to pull it all."""
    one, _ = blocks
    wide, row = replace(one, prior_sd=np.tile([1.0, 0.05], 6)), np.zeros((6, 5))
    row[:2] = np.exp(-one.basis["nodes"][:2] * one.basis["centre"][:2, None])
    row = row.ravel()
    usual = row @ one.nominal.ravel()
    precise = 1e4 / usual**2
    information, score = precise * np.outer(row, row), precise * row * 30.0 * usual
    start = PRIOR.mean + np.array([4.0, *np.zeros(11)])
    modes, covs, _ = bank._most_probable(wide, information[None], score[None], start[None], bank._LONG)
    found = bank.Mixture(modes[0], covs[0], np.ones(1), modes[0], np.zeros(5), np.zeros((1, 5)), information, score)
    rival = found.rival(wide, modes[0], covs[0])
    np.testing.assert_allclose(rival[2:4] - rival[:2], modes[0][:2] - modes[0][2:4], atol=0.2)
    assert rival[2] - modes[0][2] > 2.0 and found.bend(wide) > 2.0
    plain = bank.mixture(one, 1.0)
    assert plain.rival(one, plain.mean, plain.cov) is None and plain.bend(one) < 1.5


def test_the_filters_belief_stays_where_no_normal_describes_what_the_readings_allow(monkeypatch):
    off = of_cell()
    mean, cov = first(off)
    monkeypatch.setattr(bank.Mixture, "bend", lambda found, blocks: 20.0)
    monkeypatch.setattr(bank.Mixture, "rival", lambda found, blocks, mean, cov: mean + 1.0)
    found, last_belief = identified_with_errors(off.records[0])
    np.testing.assert_allclose(last_belief.mean, mean, atol=0.02)
    np.testing.assert_allclose(last_belief.cov, cov, rtol=0.05, atol=1e-6)
    assert "explains the readings" in found.rival and not found.believable


def test_parts_that_agree_have_no_excess_and_parts_that_do_not_have_one(blocks, rng):
    one, _ = blocks
    assert excess(one, joint(one), 1.0) < 1.0
    pushed = replace(one, score=one.score + 5.0 * (one.score - one.score.mean(axis=0)))
    assert excess(pushed, joint(pushed), 1.0) > 3.0


def test_what_rounding_left_indefinite_is_factored_and_a_contradiction_is_a_doubt(rng, monkeypatch):
    rows = rng.normal(size=(2, 5, 3)) * np.array([1.0, 1e4, 1e8])
    singular = rows @ np.swapaxes(rows, 1, 2) - 1e-15 * np.eye(5)
    with pytest.raises(np.linalg.LinAlgError):
        np.linalg.cholesky(singular)
    root = factor(singular)
    np.testing.assert_allclose(root @ np.swapaxes(root, 1, 2), singular, rtol=1e-6, atol=1e-6 * np.abs(singular).max())
    with pytest.raises(np.linalg.LinAlgError):
        factor(np.full((2, 2), np.nan))

    def fails(*arguments):
        raise np.linalg.LinAlgError

    monkeypatch.setattr("jawenv.recordings.untold.learnt.learnt", fails)
    found, last_belief = identified_with_errors(played().records[0])
    assert last_belief is None and "the readings contradict each other" in found.doubts[0]


def test_an_offset_of_the_load_cell_is_learnt_and_nothing_where_there_is_none():
    honest, off = played(), of_cell()
    for recording, most in ((honest, 2.0), (off, 6.0)):
        means, covs = learnt_beliefs(recording.records, *last(recording))
        assert nees(means - recording.truth, covs).mean() / 12 < most
    assert nees(last(off)[0] - off.truth, last(off)[1]).mean() / 12 > 50.0
    wider = np.sqrt(np.diagonal(learnt_beliefs(honest.records, *last(honest))[1], axis1=1, axis2=2))
    assert np.median(wider / np.sqrt(np.diagonal(last(honest)[1], axis1=1, axis2=2))) < 1.15


def test_what_no_muscle_pulls_is_about_nothing_where_nothing_does_and_of_the_cell_where_it_is_off():
    honest, off = (learnt(each.records[0], *first(each)).shown for each in (played(), of_cell()))
    assert np.all(np.abs(honest.force) < 4.0 * honest.force_sd + 0.02) and np.abs(honest.force).max() < 0.2
    assert np.all(np.diff(honest.opening) > 0.0) and len(honest.pose_opening) == len(honest.disagreement) > 5
    assert np.median(honest.disagreement) < 2.0
    assert np.abs(off.force).max() > 0.1 and np.abs(off.force).max() > 3.0 * np.abs(honest.force).max()


def test_a_short_record_teaches_no_size():
    record = played().records[0]
    assert learnt(record.until(3.0), record.prior.mean, np.eye(12)) is None


def test_a_jaw_that_is_held_still_teaches_no_size():
    kwargs = {"record": True, "episode_s": 8.0, "control": "targets"}
    still = jawenv.play(jawenv.Player("hold_still"), patients=1, seed=5, env_kwargs=kwargs)
    found = learnt(still.records[0], *first(still))
    np.testing.assert_allclose(found.mean, PRIOR.mean, atol=0.3)
    np.testing.assert_allclose(np.sqrt(np.diagonal(found.cov)), PRIOR.sd, rtol=0.1)
    assert found.shown.temperature == 1.0 and np.isfinite(found.shown.force).all()


def test_blocks_begin_within_the_prior_wherever_the_filter_is():
    record = played().records[0]
    blocks = blocks_of(record, record.prior.mean + 50.0)
    assert np.all(np.abs(blocks.point - PRIOR.mean) <= 4.0 * PRIOR.sd + 1e-12)
    assert np.isfinite(blocks.information).all()


def test_identification_and_score_have_it_where_asked_for():
    off = of_cell()
    plain, (found, last_belief) = identified(off.records[0]), identified_with_errors(off.records[0])
    np.testing.assert_array_equal(found.estimate.mean[-1], last_belief.mean)
    np.testing.assert_array_equal(found.estimate.cov[:-1], plain.estimate.cov[:-1])
    assert jawenv.score(off, untold=True).nees.mean() < 0.2 * jawenv.score(off).nees.mean()
    with pytest.raises(InputError, match="records is None") as error:
        jawenv.score(replace(off, records=None), untold=True)
    assert "\n" not in str(error.value)


def test_a_long_recording_has_no_more_blocks_than_memory_takes(monkeypatch):
    """The same information in longer blocks."""
    record, mean = played().records[0], played().belief_mean[0, -1]
    whole = blocks_of(record, mean)
    monkeypatch.setattr(parts, "MOST_BLOCKS", 10)
    longer = blocks_of(record, mean)
    assert (len(whole.score), len(longer.score)) == (40, 10)
    still = np.delete(np.arange(whole.score.shape[1]), slice(-N_OF_DRIFT - N_OF_WRENCH, -N_OF_WRENCH))
    for name in ("information", "score"):  # but for the drift, whose steps are as long as the blocks
        one, other = (getattr(part, name).sum(axis=0)[still] for part in (whole, longer))
        one, other = (part[..., still] if part.ndim > 1 else part for part in (one, other))
        np.testing.assert_allclose(other, one, rtol=1e-9, atol=1e-9 * np.abs(one).max())
