"""Entries against their own replays."""

import re

import numpy as np
import pytest

from eval.comparison.ranking import rank
from eval.comparison.trainings import adaptations, verdict
from eval.report import page
from tests.eval.studies import GOOD, IDLE, TRAINED, study


@pytest.fixture(scope="module")
def paired():
    """The good one replays the trained one, and the trained one the idle one."""
    made = study()
    for each in made.about["entries"]:
        each["replay_of"] = {GOOD: TRAINED, IDLE: GOOD}.get(each["label"], "")
    return made


def test_the_difference_is_paired_and_of_logs(paired):
    found = {each.name: each for each in adaptations(paired)}
    assert {entry: each.against for entry, each in found.items()} == {TRAINED: GOOD, GOOD: IDLE}
    own, other = (paired.of(entry)["worst_sd"].to_numpy() for entry in (GOOD, IDLE))
    assert found[GOOD].figures["worst_sd"].value == pytest.approx(np.mean(np.log(own / other)))
    assert verdict(found[GOOD].figures["worst_sd"]) == "adapts" and found[GOOD].figures["worst_sd"].high < 0.0
    assert verdict(found[TRAINED].figures["worst_sd"]) == "does worse"
    same = np.array(paired.of(GOOD)["early_worst_sd"])
    assert np.isfinite(same).all() and found[GOOD].figures["early_worst_sd"].value < 0.0


def test_every_column_of_the_page_has_a_heading(paired, tmp_path):
    """A heading is a button that sorts: without words it has no name."""
    written = page.write(paired, rank(paired), tmp_path / "report.html").read_text(encoding="utf-8")
    assert "Does it adapt?" in written and not re.search(r"<th[^>]*></th>", written)
