"""The patient's page of a recording, as ``jawenv identify RECORDING --page FILE.html`` writes it."""

from __future__ import annotations

import shlex
from math import inf
from pathlib import Path

import numpy as np

from eval.kept.tables import made_with
from eval.patient import page
from eval.patient.courses import MOMENTS
from eval.patient.treatments import Treatment
from jawenv.anatomy import PARAMETER_NAMES
from jawenv.base.errors import InputError
from jawenv.metrics import alarm_word
from jawenv.recordings.identification import Identification
from jawenv.recordings.record import Record
from jawenv.recordings.untold.learnt import Learnt


def write_page(
    record: Record, result: Identification, last: Learnt | None, recording: Path, target: Path, assumed: str
) -> Path:
    """Write the page; without a verdict where the estimates are not to be believed.

    Args:
        record: the recording.
        result: its identification.
        last: its last belief, where sizes of errors that nobody told were learnt.
        recording: its file.
        target: the page's file.
        assumed: what was assumed of patient, anatomy and head, in words.

    Returns:
        The page's file.
    """
    if record.parameter_names != PARAMETER_NAMES:
        raise InputError(f"{recording}: has other muscles; allowed: the six closing ones")
    simulated = record.truth is not None
    estimate = result.estimate
    treatment = Treatment(
        time=estimate.time,
        mean=estimate.mean,
        cov=estimate.cov,
        truth=np.full(len(PARAMETER_NAMES), np.nan) if record.truth is None else record.truth,
        violated=False,
        misfit=result.misfit if result.believable else inf,
        shown=None if last is None else last.shown,
    ).thinned(MOMENTS)
    subject = page.Subject(
        who=f"Recording “{recording.stem}”",
        account=f"{record.time[-1]:g} s at {1.0 / record.dt:.3g} Hz, {result.rows:,} rows, {result.refused:,} refused; "
        f"alarm: {alarm_word(result.misfit)}. Assumed: {assumed}",
        notice="Research, not a medical device." + (" The patient is simulated." if simulated else ""),
        prior=record.prior,
        recorded=True,
    )
    command = shlex.join(["jawenv", "identify", str(recording), "--page", str(target)])
    return page.write(page.render(subject, [treatment], made_with(command), simulated), target)
