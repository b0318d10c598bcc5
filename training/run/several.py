"""Several seeds of one configuration, one run after another."""

from __future__ import annotations

import re
from pathlib import Path

from rich.console import Console

from jawenv.errors import InputError, shown
from training.run import train
from training.run.config import TrainingConfig
from training.run.folder import RunFolder

_PART = re.compile(r"(\d+)(?:-(\d+))?")
MOST = 1000


def parse_seeds(text: str) -> list[int]:
    """Seeds from ``0-4``, ``0,1,2`` or both mixed, each once, in the order given.

    Raises:
        InputError: something else, a range that runs backwards, or more than `MOST` seeds.
    """
    seeds: list[int] = []
    for part in text.split(","):
        match = _PART.fullmatch(part.strip())
        if match is None:
            raise InputError(f"seeds {shown(text)}: allowed are numbers and ranges such as 0-4 or 0,1,2")
        first, last = int(match[1]), int(match[2] or match[1])
        if last < first or last - first >= MOST:
            raise InputError(f"seeds {shown(text)}: {part.strip()} must be a range upwards of at most {MOST} seeds")
        seeds += range(first, last + 1)
    return list(dict.fromkeys(seeds))


def train_seeds(config: TrainingConfig, seeds: list[int], stem: Path, console: Console) -> int:
    """Train each seed into the folder ``STEM-seedK``; finished ones are skipped, unfinished ones go on.

    Args:
        config: of all, but for the seed.
        seeds: trained in this order.
        stem: of the folders' names.
        console: where to report.

    Returns:
        The exit code: 0, or that of an interrupted run, after which no other is begun.

    Raises:
        InputError: a folder holds something else, or a run with other settings.
    """
    plan = [(config.changed(seed=seed), RunFolder(stem.with_name(f"{stem.name}-seed{seed}"))) for seed in seeds]
    for wanted, run in plan:
        if run.exists():
            run.check_settings(wanted)
        else:
            run.check_free(overwrite=False)
    for number, (wanted, run) in enumerate(plan, 1):
        console.print(f"seed {wanted.seed}, {number} of {len(plan)}: {run.path}", soft_wrap=True)
        go_on = run.exists()
        code = train.resume(run, console, wanted.steps) if go_on else train.start(wanted, run, console)
        if code:
            return code
    return 0
