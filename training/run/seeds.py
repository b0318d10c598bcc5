"""Several seeds of one training: one after the other in this process, or side by side through the engine of studies.

A run's bits do not depend on where it was made: a seed decides patients, noise and first weights, and each run sets the
threads of its own network.
"""

from __future__ import annotations

import re
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

from rich.console import Console

from jawenv.base.errors import InputError, shown
from jawenv.base.extras import needs
from jawenv.base.progress import Progress
from training.run.config import TrainingConfig
from training.run.folder import RunFolder
from training.run.train import INTERRUPTED, resume, start

_MOST_SEEDS = 1000
_SEEDS = re.compile(r"(\d+)(?:-(\d+))?")
_Plan = list[tuple[TrainingConfig, RunFolder]]


def train_seeds(
    config: TrainingConfig,
    text: str,
    stem: Path,
    console: Console,
    workers: int | None = None,
    backend: str | None = None,
) -> int:
    """Train each seed into the folder ``STEM-seedK``; finished ones are skipped, unfinished ones go on.

    Args:
        config: of all runs, but for the seed.
        text: the seeds, as ``0-4`` or ``0,1,2``.
        stem: of the folders' names.
        console: where to report.
        workers: processes side by side; all cores where only a backend is given.
        backend: see `eval.kept.parts.Run`; without it and ``workers`` runs follow each other in this process.

    Returns:
        The exit code: 0, or the code of an interrupted run, after which no other is begun.
    """
    runs = ((config.changed(seed=seed), stem.with_name(f"{stem.name}-seed{seed}")) for seed in _parsed(text))
    plan = [(config_of_seed, RunFolder(path)) for config_of_seed, path in runs]
    for config_of_seed, run in plan:
        if run.exists():
            run.check_settings(config_of_seed)
        else:
            run.check_free(overwrite=False)
    if workers is not None or backend is not None:
        return _side_by_side(plan, console, workers, backend or "loky")
    for number, (config_of_seed, run) in enumerate(plan, 1):
        console.print(f"seed {config_of_seed.seed}, {number} of {len(plan)}: {run.path}", soft_wrap=True)
        code = _begun_or_continued(config_of_seed, run, console)
        if code:
            return code
    return 0


def _begun_or_continued(config: TrainingConfig, run: RunFolder, console: Console) -> int:
    return resume(run, console, config.steps) if run.exists() else start(config, run, console)


def _side_by_side(plan: _Plan, console: Console, workers: int | None, backend: str) -> int:
    """Train in processes of the engine, named here since its room stands above; each run reports into its log."""
    with needs("--seeds side by side", "joblib", group="eval"):
        engine: Any = import_module("eval.kept.parts")
    how = engine.Run(workers=workers, backend=backend)
    parts = [
        engine.Part(f"seed {config.seed} has ended", i, config.steps, (("run", run.path),))
        for i, (config, run) in enumerate(plan)
    ]
    for config, run in plan:
        console.print(f"seed {config.seed}: {run.path}, reports in {_log(run)}", soft_wrap=True)
    whole = [(config, RunFolder(run.path.resolve())) for config, run in plan]  # a process may be in another folder
    with Progress(sum(part.number for part in parts), "steps", console) as progress:
        engine.do_parts(parts, partial(_trained, plan=whole), how, progress)
    return 0


def _trained(part: Any, progress: Progress, plan: _Plan) -> None:
    """Train the seed of a part, a function that processes can be sent."""
    config, run = plan[part.first]
    _log(run).parent.mkdir(parents=True, exist_ok=True)
    with _log(run).open("a", encoding="utf-8") as log:
        code = _begun_or_continued(config, run, Console(file=log, highlight=False, markup=False))
    if code == INTERRUPTED:
        raise InputError(f"seed {config.seed} was stopped; the same command goes on")


def _log(run: RunFolder) -> Path:
    return run.path.with_name(f"{run.path.name}.log")


def _parsed(text: str) -> list[int]:
    """Seeds from ``0-4``, ``0,1,2`` or both mixed, each once, in the order given."""
    seeds: list[int] = []
    for part in text.split(","):
        match = _SEEDS.fullmatch(part.strip())
        if match is None:
            raise InputError(f"seeds is {shown(text)}; allowed: numbers and ranges such as 0-4 or 0,1,2")
        first, last = int(match[1]), int(match[2] or match[1])
        if last < first or last - first >= _MOST_SEEDS:
            raise InputError(
                f"seeds is {shown(text)}; allowed: ranges upwards of at most {_MOST_SEEDS} seeds, unlike {part.strip()}"
            )
        seeds += range(first, last + 1)
    return list(dict.fromkeys(seeds))
