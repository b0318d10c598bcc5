"""No patient serves two purposes, in the code and in what the documentation reports."""

from itertools import combinations

from eval.benchmark.tasks import TASKS
from eval.kept.entries import Settings
from jawenv.base.seeds import BENCHMARK, FILTER_TUNING, REPORTS, TRAINING, TUNING, VALIDATION
from training.run.config import DEFAULT_CONFIG, TrainingConfig
from training.run.worlds import world_seed


def within(seeds: range, purpose: range) -> bool:
    return seeds[0] in purpose and seeds[-1] in purpose


def test_purposes_share_no_seed() -> None:
    for one, other in combinations([*REPORTS, TUNING, VALIDATION, FILTER_TUNING, BENCHMARK, TRAINING], 2):
        assert one.stop <= other.start or other.stop <= one.start


def test_every_task_of_the_benchmark_has_patients_of_its_own() -> None:
    seeds = [task.seeds for task in TASKS.values()]
    assert all(within(each, BENCHMARK) for each in seeds)
    for one, other in combinations(seeds, 2):
        assert one.stop <= other.start or other.stop <= one.start


def test_commands_keep_to_their_seeds() -> None:
    assert Settings().seed in REPORTS[0]
    for path in DEFAULT_CONFIG.parent.glob("*.yaml"):
        config = TrainingConfig.load(path).evaluation
        assert within(range(config.seed, config.seed + config.patients), VALIDATION)
    assert all(world_seed(seed, step) in TRAINING for seed in range(5) for step in (0, 10**6))
