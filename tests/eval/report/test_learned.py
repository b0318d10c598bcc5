"""What a training has changed is said as far as the study shows it."""

import numpy as np

from agents.card import CARD
from eval.comparison.ranking import rank
from eval.report.learned import learned
from jawenv.playing.maneuvers import Maneuver
from tests.eval.studies import GOOD, IDLE, TRAINED, study
from tests.plain_policies import write_corrector

STILL, WIDE = [0.0, 0.0, 0.0, 0.0], [0.5, 0.8, 0.0, -0.4]


def motion(commands: list[list[float]]) -> dict:
    return {"commands": ["opening", "side", "fore-aft", "roll"], "frames": {"command": commands}}


def trained_on(base: str, folder, patients: int = 12, control: str = "targets"):
    """The study, whose trained entry corrects another one."""
    write_corrector(folder, Maneuver.named("hold_still").model_copy(update={"name": base}))
    (folder / "evaluations.csv").write_text(
        "steps,return,worst_sd_10s,worst_sd,discomfort_s\n0,1,1,1,0\n9600,2,1,1,0\n"
    )
    made = study(patients)
    entries = [each | ({"spec": str(folder)} if each["trained"] else {}) for each in made.about["entries"]]
    about = made.about | {"entries": entries, "settings": made.about["settings"] | {"control": control}}
    moved = {base: motion([STILL, STILL]), TRAINED: motion([WIDE, [-x for x in WIDE]])}
    return type(made)(made.patients, made.curves, about, moved)


def test_what_learning_did_is_the_gain_over_what_is_corrected(tmp_path):
    made = trained_on(IDLE, tmp_path)
    (found,) = learned(made, rank(made))
    assert (found.entry.entry, found.base.entry, found.steps) == (TRAINED, IDLE, 9600)
    assert (
        found.early.high < 0.0
        and "of that of hold still on the same patient: that is what learning did." in found.verdict
    )
    assert found.verdict.endswith("Good one, which no training made, is still ahead of it.")
    known = "In half of the patients that knows all parameters to 5 % never, ppo-seed0 never."
    assert found.sooner == f"ppo-seed0 began as hold still. {known}"
    assert [change.target for change in found.changes] == ["opening", "side", "fore-aft", "roll"]


def test_a_loss_is_not_what_learning_did(tmp_path):
    made = trained_on(GOOD, tmp_path)
    (found,) = learned(made, rank(made))
    assert found.early.low > 0.0 and "worse" in found.verdict and "did." not in found.verdict


def test_no_difference_is_said_to_be_none(tmp_path):
    made = trained_on(IDLE, tmp_path)
    same = made.patients[made.patients["entry"] == IDLE]
    rows = made.patients["entry"] == TRAINED
    patients = made.patients.copy()
    for column in ("early_worst_sd", "worst_sd"):
        wobble = 1.0 + 0.01 * (-1.0) ** np.arange(len(same))
        patients.loc[rows, column] = same[column].to_numpy() * wobble
    made = type(made)(patients, made.curves, made.about, made.motions)
    (found,) = learned(made, rank(made))
    assert found.verdict.endswith("that learning changed anything is not shown.")


def test_commands_of_other_control_modes_are_no_targets(tmp_path):
    made = trained_on(IDLE, tmp_path, control="force")
    (found,) = learned(made, rank(made))
    assert found.changes == ()


def test_runs_that_are_gone_or_correct_nothing_of_the_study_are_left_out(tmp_path):
    made = trained_on("chirp", tmp_path)
    assert learned(made, rank(made)) == ()
    (tmp_path / CARD).unlink()
    assert learned(made, rank(made)) == ()
