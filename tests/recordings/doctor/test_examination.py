"""What a bench has wrong is named, with what mends it."""

from dataclasses import replace

import numpy as np
import pytest

from jawenv.commands.app import main
from jawenv.recordings.doctor.examination import examined
from tests.recordings.several.test_together import played, saved


def faulty(fault):
    record = played(0, "refined")
    samples, measured = record.samples.copy(), record.measured.copy()
    if fault == "zero":
        samples[..., 1] += 1.0
    if fault == "frame":
        samples = samples[..., [2, 1, 0, 5, 4, 3]] * np.array([1.0, 1.0, -1.0, 1.0, 1.0, -1.0])
    if fault == "teeth":
        measured[:, 2] -= 0.02
    changed = replace(record, samples=-samples if fault == "sign" else samples, measured=measured)
    return replace(changed, time=2.0 * changed.time) if fault == "rate" else changed


def test_what_no_jaw_can_show_is_named_too():
    record = played(0, "refined")
    forces = record.samples[np.arange(len(record.samples)) // 5 * 5, :1].repeat(3, axis=1)
    named = {check.what: check for check in examined(replace(record, samples=forces)) if not check.fine}
    assert "repeated readings" in named["force_*_N"].value and "write a reading once" in named["force_*_N"].mend


@pytest.mark.parametrize("fault", ["zero", "sign", "frame", "rate", "teeth"])
def test_a_fault_is_named_and_mended(fault):
    named = {check.what: check for check in examined(faulty(fault)) if not check.fine}
    assert fault in named and named[fault].mend


def test_less_than_a_second_is_said_and_nothing_else():
    (check,) = examined(faulty("").until(0.5))
    assert check.what == "length" and not check.fine


def test_the_command_prints_each_check(tmp_path, capsys):
    assert main(["doctor", saved(faulty(""), tmp_path / "fine.csv")]) == 0
    said = capsys.readouterr().out.splitlines()
    assert [line.split()[1] for line in said] == ["rate", "sign", "frame", "zero", "clocks", "teeth"]
    assert main(["doctor", saved(faulty("rate"), tmp_path / "rate.csv")]) == 3
    said = capsys.readouterr().out
    assert "LOOK AT rate" in said and "times of 100 Hz" in said and "mend:" in said
