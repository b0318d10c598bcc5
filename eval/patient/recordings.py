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
from eval.report import template
from jawenv.anatomy import PARAMETER_NAMES
from jawenv.answers.answer import Answer
from jawenv.base.errors import InputError
from jawenv.metrics import alarm_word
from jawenv.metrics.verdicts import WITHHELD


def write_page(answer: Answer, target: Path) -> Path:
    """Write the page of an answer; without a verdict where the estimates are not to be believed.

    Returns:
        The page's file.
    """
    record, result, recording = answer.records[0], answer.whole, Path(answer.paths[0])
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
        misfit=inf if WITHHELD in answer.verdicts.values() else result.misfit,
        shown=None if answer.learnt is None else answer.learnt.shown,
    ).thinned(MOMENTS)
    subject = page.Subject(
        who=f"Recording “{recording.stem}”",
        account=f"{record.time[-1]:g} s at {1.0 / record.dt:.3g} Hz, {result.rows:,} rows, {result.refused:,} refused; "
        f"alarm: {alarm_word(result.misfit)}. Assumed: {answer.assumed}",
        notice="Research, not a medical device." + (" The patient is simulated." if simulated else ""),
        prior=record.prior,
        tension=answer.tension,
    )
    command = shlex.join(["jawenv", "identify", *answer.paths, "--page", str(target)])
    return template.write(page.render(subject, [treatment], made_with(command), simulated), target)
