"""People without a scan, of another size, or who lie: found from their own recordings, and said."""

import argparse
from dataclasses import replace

import numpy as np
import pytest

import jawenv
from eval.patient.recordings import write_page
from jawenv.anatomy.knowledge import IMAGED
from jawenv.answers import tension
from jawenv.answers.tension import tensions_of
from jawenv.filter.model.basis import N_NODES, build_basis
from jawenv.metrics.diagnosis import STIFF_F_O_N
from jawenv.recordings.size import size_of, sized
from jawenv.recordings.untold.blocks import N_OF_WRENCH, blocks_of
from jawenv.recordings.untold.learnt import JointBelief
from research.anyone import CELL_HZ, NO_SCAN, TRACKER_HZ, lab_file, recordings_of

ASKED = argparse.Namespace(patients=1, seed=487_000, seconds=15.0)


def answer(record, path, **told):
    lab_file(record, TRACKER_HZ, CELL_HZ, path / "lab.csv")
    found = jawenv.identify(path / "lab.csv", **told)
    error = found.log_mean - record.truth
    return found, float(error @ np.linalg.solve(found.log_cov, error)) / len(error)


def test_lines_of_muscles_far_from_the_table_are_found_and_said(tmp_path):
    """With the error bars of a scan NEES/12 is 10 to 150."""
    found, share = answer(recordings_of(ASKED, "refined", cohort="one_sided", reality=NO_SCAN)[0], tmp_path)
    assert found.believed and share < 4.0
    assert "10 times as far from the table as a scan leaves them" in str(found)
    assert found.mapping()["learnt"]["lines"] == 10.0


def test_a_head_that_lies_back_is_found_and_can_be_told(tmp_path):
    record = recordings_of(ASKED, "refined", tilt=-80.0, cohort="trismus")[0]
    found, share = answer(record, tmp_path)
    assert found.believed and share < 4.0
    assert found.mapping()["learnt"]["head_tilt_deg"] < -25.0
    assert "the head is pitched by -" in str(found)
    told, share = answer(record, tmp_path, head_tilt_deg=-80.0)
    assert told.believed and share < 4.0 and "pitched down by -80 degrees" in told.assumed


def test_a_jaw_of_another_size_is_read_at_its_size_and_an_anatomy_can_be_given(tmp_path):
    record = recordings_of(ASKED, "refined", cohort="trismus", anatomy=sized(0.93))[0]
    assert size_of(record)[0] == pytest.approx(0.93, abs=0.02)
    found, share = answer(record, tmp_path)
    assert found.believed and share < 4.0 and "mandible 0.9" in found.assumed
    given, share = answer(record, tmp_path, anatomy=sized(0.93))
    assert given.believed and share < 4.0
    assert size_of(recordings_of(ASKED, "refined", cohort="trismus")[0])[0] == 1.0


def test_axes_laid_through_condyles_that_were_felt_for_are_found_unless_they_are_known(tmp_path):
    """Taken for known they end in a refusal, or in NEES/12 of 6 to 14."""
    known = replace(IMAGED, axes_mm=2.0)
    record = recordings_of(ASKED, "refined", cohort="anyone", knowledge=known)[0]
    found, share = answer(record, tmp_path)
    assert found.believed and share < 4.0 and "axes within 3 mm" in found.assumed
    assert not answer(record, tmp_path, knowledge="bench")[0].believed


def test_forces_that_are_late_are_said_to_be(tmp_path):
    record = recordings_of(ASKED, "refined", cohort="anyone")[0]
    lab_file(record, TRACKER_HZ, CELL_HZ, tmp_path / "lab.csv", late_s=0.02)
    found = jawenv.identify(tmp_path / "lab.csv")
    late, sd = found.mapping()["learnt"]["forces_late_s"]
    assert found.believed and 0.01 < late < 0.04 and sd < 0.01
    assert f"forces are late by {1e3 * late:.0f} ms" in str(found)
    assert "late by" not in str(answer(record, tmp_path)[0])


def test_a_gap_in_the_forces_is_no_rate_of_theirs():
    record = recordings_of(ASKED, "slow_opening", cohort="anyone")[0]
    samples = record.samples.copy()
    samples[700:730] = np.nan
    whole, gap = (blocks_of(one, record.truth) for one in (record, replace(record, samples=samples)))
    told = [np.diagonal(one.information, axis1=1, axis2=2)[:, -N_OF_WRENCH - 1].max() for one in (whole, gap)]
    assert told[1] < 1.5 * told[0]


@pytest.mark.parametrize("unread", [slice(3, 6), slice(0, 3)])
def test_a_tracker_of_places_or_of_angles_alone_has_an_answer_in_newtons(unread):
    world = {"record": True, "episode_s": 20.0, "control": "targets", "track_bound": False}
    record = jawenv.play(jawenv.Player("slow_opening"), patients=1, seed=5, env_kwargs=world).records[0]
    whole, measured = tensions_of(record, record.truth, 1e-4 * np.eye(12)), record.measured.copy()
    measured[:, unread] = np.nan
    found = tensions_of(replace(record, measured=measured), record.truth, 1e-4 * np.eye(12))
    assert found["all"] and found["all"][0].force_N == pytest.approx(whole["all"][0].force_N, rel=0.1)


def test_a_law_that_is_bent_leaves_verdicts_to_forces(tmp_path):
    found, _ = answer(recordings_of(ASKED, "refined", cohort="trismus")[0], tmp_path)
    bent = replace(found, learnt=replace(found.learnt, sizes=found.learnt.sizes | {"law": 0.1}))
    assert "no verdict" not in {verdict.word for verdict in found.verdicts.values()}
    assert {verdict.word for verdict in bent.verdicts.values()} == {"no verdict"}
    assert bent.tension["all"][0].word == "raised" and "raised" in str(bent)
    assert "No verdict" in write_page(bent, tmp_path / "page.html").read_text(encoding="utf-8")


def test_a_recording_of_nobody_knows_whom_that_is_too_short_to_weigh_errors_is_not_believed(tmp_path):
    short = argparse.Namespace(**vars(ASKED) | {"seconds": 3.0})
    record = recordings_of(short, "refined", cohort="trismus", reality=NO_SCAN)[0]
    found, _ = answer(record, tmp_path)
    assert not found.believed and "allowed: 5 s or more" in found.doubts[0]
    assert answer(record, tmp_path, knowledge="imaged")[0].believed


def test_forces_at_the_incisors_do_the_work_that_the_muscles_store():
    """Energy of the springs F_o exp(b e), by differences along the opening."""
    world = {"control": "targets", "record": True, "episode_s": 20.0, "track_bound": False}
    record = jawenv.play(jawenv.Player("slow_opening"), patients=1, seed=5, env_kwargs=world).records[0]
    found = tensions_of(record, record.truth, 1e-4 * np.eye(12))
    _, opening, strain, _ = tension.along_the_way(record)
    F_o, b = np.exp(record.truth).reshape(-1, 2)[record.jaw["muscle"]].T
    stored = np.sum(record.jaw["l_o"] * F_o / b * np.exp(b * strain), axis=1)
    force = np.interp(0.01, opening, np.gradient(stored, opening))
    assert found["all"][0].force_N == pytest.approx(force, rel=0.01)
    assert found["all"][0].word == "raised" and found["all"][0].raised > 0.99
    half_way = np.tile(np.log([STIFF_F_O_N, tension.USUAL_B]), 6)
    for ones in tensions_of(record, half_way, 1e-4 * np.eye(12)).values():
        assert ones[0].raised == pytest.approx(0.5, abs=1e-6) and ones[0].word == ""
    softer = tensions_of(record, half_way - 0.5, 1e-4 * np.eye(12))
    assert {ones[0].word for ones in softer.values()} == {"normal"}
    assert sum(found[name][0].force_N for name in ("left", "right")) == pytest.approx(found["all"][0].force_N)
    step, number = 1e-5, 3
    moved, alone = record.truth.copy(), np.zeros((12, 12))
    moved[number], alone[number, number] = moved[number] + step, 1.0
    by_log = tensions_of(record, moved, alone)["all"][0].force_N - found["all"][0].force_N
    basis = build_basis(record.jaw, record.prior)[0]
    known = JointBelief(
        alone, np.zeros((2, 0, *record.jaw["origin"].shape)), np.zeros((1, 6, N_NODES)), basis, (0.0, 1.0)
    )
    sd = tensions_of(record, record.truth, alone, known)["all"][0].force_sd_N
    assert sd == pytest.approx(abs(by_log) / step, rel=1e-3)
    unknown = np.random.default_rng(0).normal(scale=1e-5, size=(2, 1, *record.jaw["origin"].shape))
    jaw, alone = record.jaw.copy(), np.zeros((13, 13))
    for name, moved in zip(("origin", "insertion"), unknown[:, 0], strict=True):
        jaw[name] += moved
    alone[12, 12] = 1.0
    jaw["l_o"] = np.linalg.norm(jaw["origin"] - jaw["insertion"], axis=1)
    elsewhere = tensions_of(replace(record, jaw=jaw), record.truth, alone[:12, :12])
    for name, ones in tensions_of(
        record, record.truth, alone, known._replace(cov=alone, moved=unknown, bent=np.zeros((2, 6, N_NODES)))
    ).items():
        assert ones[0].force_sd_N == pytest.approx(abs(elsewhere[name][0].force_N - ones[0].force_N), rel=0.02)
