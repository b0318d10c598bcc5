"""What a training has changed is said as far as the study shows it."""

import numpy as np
import pytest

from eval.comparison.ranking import rank
from eval.report.learned import learned
from jawenv.playing.maneuvers import Maneuver
from jawenv.playing.policies.card import CARD
from tests.eval.studies import IDLE, TRAINED, study
from tests.plain_policies import write_corrector


def trained_on(base: str, folder):
    """The study, whose trained entry corrects another one."""
    write_corrector(folder, Maneuver.named("hold_still").model_copy(update={"name": base}))
    (folder / "evaluations.csv").write_text(
        "steps,return,worst_sd_10s,worst_sd,discomfort_s\n0,1,1,1,0\n9600,2,1,1,0\n"
    )
    made = study(12)
    entries = [each | ({"spec": str(folder)} if each["trained"] else {}) for each in made.about["entries"]]
    about = made.about | {"entries": entries}
    return type(made)(made.patients, made.curves, about)


def test_what_learning_did_is_the_gain_over_what_is_corrected(tmp_path):
    made = trained_on(IDLE, tmp_path)
    (found,) = learned(made, rank(made))
    assert (found.entry.entry, found.base.entry, found.steps) == (TRAINED, IDLE, 9600)
    when, share = found.gain
    assert when == "after 10 s" and share.high < 1.0 and share.value == pytest.approx(np.exp(found.early.value))
    known = "In half of the patients all parameters are within 5 %: with hold still never, with ppo-seed0 never."
    assert found.sooner == f"ppo-seed0 began as hold still. {known}"


def test_runs_that_are_gone_or_correct_nothing_of_the_study_are_left_out(tmp_path):
    made = trained_on("chirp", tmp_path)
    assert learned(made, rank(made)) == ()
    (tmp_path / CARD).unlink()
    assert learned(made, rank(made)) == ()
