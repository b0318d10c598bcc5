"""No patient serves two purposes, in the code and in what the documentation reports."""

import re
from itertools import combinations
from pathlib import Path

import pytest

from eval.benchmark.tasks import TASKS
from eval.settings import Settings
from jawenv.seeds import BENCHMARK, FILTER_TUNING, REPORTS, TRAINING, TUNING, VALIDATION
from training.run.config import DEFAULT_CONFIG, TrainingConfig
from training.run.train import world_seed

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", ROOT / "Makefile", *sorted((ROOT / "docs").glob("*.md"))]
# seed=0; --seed 500; seeds 0–31; seeds 5000 and on, 10000 and on; seeds from 20000; patients 10000–10063
SEEDS = re.compile(r"\bseeds?(?: from)?[ =]((?:\d+(?:–\d+)?(?: and on)?(?:, )?)+)|\bpatients (\d+–\d+)")
PATIENTS = re.compile(r"--patients (\d+)")


def documented(paragraph: str) -> list[range]:
    """The seeds that a paragraph names; those of a command reach as far as its patients."""
    text = " ".join(paragraph.replace("\\\n", " ").split())
    counts = [int(number) for number in PATIENTS.findall(text)]
    ranges = []
    for found in SEEDS.finditer(text):
        for first, last in re.findall(r"(\d+)(?:–(\d+))?", found[1] or found[2]):
            of_command = text[found.start() - 2 : found.start()] == "--"
            number = max(counts) if of_command and counts else 1
            ranges.append(range(int(first), int(last or int(first) + number - 1) + 1))
    return ranges


def within(seeds: range, purpose: range) -> bool:
    return seeds[0] in purpose and seeds[-1] in purpose


def test_purposes_share_no_seed() -> None:
    for one, other in combinations([*REPORTS, TUNING, VALIDATION, FILTER_TUNING, BENCHMARK, TRAINING], 2):
        assert one.stop <= other.start or other.stop <= one.start


def test_what_a_paragraph_names() -> None:
    assert documented("chosen (seeds 5000 and on, 10000 and on), then") == [range(5000, 5001), range(10000, 10001)]
    assert documented("agent chosen on\npatients 10000–10063, when") == [range(10000, 10064)]
    assert documented("calibrate --patients 600 \\\n  --seed 20000 --times 10") == [range(20000, 20600)]
    assert documented("64 patients, seeds 0–63; seeds from 20000; seed=0") == [range(64), range(20000, 20001), range(1)]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_documented_results_are_of_patients_on_whom_nothing_was_chosen(page: Path) -> None:
    for paragraph in re.split(r"\n\s*\n", page.read_text(encoding="utf-8")):
        for seeds in documented(paragraph):
            reported = any(within(seeds, purpose) for purpose in (*REPORTS, BENCHMARK))
            # Choices may be documented too, with the patients on whom they were made.
            own = any(within(seeds, purpose) for purpose in (TUNING, VALIDATION, FILTER_TUNING))
            chosen = own and re.search(r"\bcho(ices|sen)\b", paragraph)
            assert reported or chosen, f"{page.name}: seeds {seeds[0]} to {seeds[-1]} are for other things"


def test_the_pages_are_read() -> None:
    named = [seeds for page in PAGES for seeds in documented(page.read_text(encoding="utf-8"))]
    assert {range(500, 564), range(20000, 20200), range(6000, 6064)} <= set(named)


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
