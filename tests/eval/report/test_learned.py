"""What a training has changed is said as far as the study shows it."""

import numpy as np
import pytest

from eval.comparison.ranking import rank
from eval.report.learned import learned
from jawenv.playing.maneuvers import Maneuver
from jawenv.playing.policies.card import CARD
from tests.eval.studies import IDLE, TRAINED, study
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
    (found,) = learned(made, rank(made)).lessons
    assert (found.entry.entry, found.base.entry, found.steps) == (TRAINED, IDLE, 9600)
    when, share = found.gain
    assert when == "after 10 s" and share.high < 1.0 and share.value == pytest.approx(np.exp(found.early.value))
    known = "In half of the patients all parameters are within 5 %: with hold still never, with ppo-seed0 never."
    assert found.sooner == f"ppo-seed0 began as hold still. {known}"
    assert [change.target for change in found.changes] == ["opening", "side", "fore-aft", "roll"]


def test_commands_of_other_control_modes_are_no_targets(tmp_path):
    made = trained_on(IDLE, tmp_path, control="force")
    (found,) = learned(made, rank(made)).lessons
    assert found.changes == ()


def test_runs_that_are_gone_or_correct_nothing_of_the_study_are_left_out(tmp_path):
    made = trained_on("chirp", tmp_path)
    assert learned(made, rank(made)).lessons == ()
    (tmp_path / CARD).unlink()
    assert learned(made, rank(made)).lessons == ()
