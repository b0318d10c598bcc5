"""What a newcomer has to own: a trunk within its budget, and leaves that can be cut off at one place each.

Limits only fall: who brings a number down lowers its limit in the same commit. `docs/leaves.md` says what each leaf is
for and how it is cut off.
"""

import ast
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from fnmatch import fnmatch
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
ROOMS = ("jawenv", "agents", "training", "eval", "research")
LARGEST = {
    "lines of the trunk": 33_776,
    "lines of a leaf": 2_810,
    "longest chain of imports": 47,
    "public top-level names": 1_552,
    "modules that a step loads": 140,
    "lines that a step loads": 15_476,
    "lines that eval compare loads": 27_407,
}


@dataclass(frozen=True)
class Leaf:
    """A capability of its own: its files, the only files that may import it, and its tests."""

    files: tuple[str, ...]
    doors: tuple[str, ...]
    tests: tuple[str, ...]


EVAL, TRAINING, JAWENV = "eval/commands/app.py", "training/cli.py", "jawenv/commands/app.py"
LEAVES = {
    "live page": Leaf(
        ("jawenv/live/*", "jawenv/commands/live.py", "eval/commands/live.py"), (JAWENV, EVAL), ("tests/live",)
    ),
    "trackers": Leaf(("jawenv/trackers/*",), (JAWENV,), ("tests/trackers",)),
    "thesis": Leaf(("eval/thesis/*",), (EVAL,), ("tests/eval/thesis",)),
    "benchmark": Leaf(("eval/benchmark/*", "eval/commands/benchmark.py"), (EVAL,), ("tests/eval/benchmark",)),
    "calibration tables": Leaf(
        ("eval/calibration/*", "eval/commands/calibration.py"), (EVAL,), ("tests/eval/calibration",)
    ),
    "untold errors": Leaf(
        ("jawenv/recordings/untold_*",),
        ("jawenv/recordings/identification.py", "jawenv/metrics/score.py"),
        ("tests/recordings",),
    ),
    "patient's page": Leaf(
        ("eval/patient/*", "eval/commands/patient.py"), (EVAL, "jawenv/commands/recordings.py"), ("tests/eval/patient",)
    ),
    "data sets": Leaf(
        ("eval/episodes/dataset.py", "eval/episodes/croissant.py", "eval/commands/dataset.py"),
        (EVAL,),
        ("tests/eval/episodes",),
    ),
    "films": Leaf(
        ("eval/episodes/film.py", "jawenv/rendering/film.py"), (EVAL, "eval/report/films.py"), ("tests/eval/episodes",)
    ),
    "contest": Leaf(
        ("eval/comparison/contest.py", "eval/comparison/cost.py"), ("eval/commands/comparison.py",), ("tests/eval",)
    ),
    "inference": Leaf(
        ("jawenv/inference/*", "eval/*information.py", "eval/rows/gains.py"),
        (EVAL, "jawenv/__init__.py"),
        ("tests/inference",),
    ),
    "identifiability": Leaf(
        ("jawenv/analysis/identifiability.py", "jawenv/analysis/observability.py"),
        ("jawenv/__init__.py", "jawenv/inference/likelihood.py"),
        ("tests/analysis",),
    ),
    "smoothers": Leaf(
        ("jawenv/references/*", "jawenv/analysis/joint_likelihood.py"),
        ("eval/rows/*", "eval/patient/*", "eval/thesis/*", "jawenv/inference/*"),
        ("tests/references",),
    ),
    "tune": Leaf(("training/run/tune.py",), (TRAINING,), ("tests/training",)),
    "onnx": Leaf(("training/run/onnx_file.py",), (TRAINING,), ("tests/training",)),
    "maneuver search": Leaf(("training/search/*",), (TRAINING,), ("tests/training",)),
    "twin": Leaf(
        ("agents/twin/*",),
        ("agents/clairvoyant.py", "training/run/*", "training/search/*"),
        ("tests/agents/twin",),
    ),
    "clairvoyant": Leaf(("agents/clairvoyant.py",), ("agents/planners.py",), ("tests/agents",)),
    "form of stable-baselines3": Leaf(("jawenv/sb3.py",), ("training/run/worlds.py",), ("tests/training",)),
    "pymunk's rung": Leaf(
        ("jawenv/mechanics/sagittal*", "jawenv/envs/sagittal_plant.py"),
        ("jawenv/envs/simulation.py",),
        ("tests/mechanics",),
    ),
    "MuJoCo's jaw": Leaf(("jawenv/mechanics/mujoco_jaw.py",), (), ("tests/envs",)),
    "own estimators": Leaf(
        ("jawenv/envs/own_estimators.py", "jawenv/envs/world/belief_kernel.py"),
        ("jawenv/envs/configuration.py", "jawenv/envs/simulation.py"),
        ("tests/envs",),
    ),
    "research": Leaf(("research/*",), (), ("tests/project/test_research.py",)),
    "notebooks": Leaf(("eval/notebooks/*",), (), ("eval/notebooks",)),
}
EXHIBITS = ("research/*", "eval/notebooks/*", "eval/thesis/*")
"""What is read rather than used: it may import a leaf."""

MEASURED = """
import sys
from pathlib import Path
{code}
files = [getattr(module, "__file__", None) for module in list(sys.modules.values())]
own = [Path(file) for file in files if file and file.startswith({rooms!r})]
print(len(own), sum(len(file.read_text(encoding="utf-8").splitlines()) for file in own))
"""
STEP = """
import gymnasium, jawenv
env = gymnasium.make("jawenv/Jaw-v3")
env.reset(seed=0)
env.step(env.action_space.sample())
"""
COMPARE = """
from eval.commands.app import main
sys.stdout = open({output!r} + ".txt", "w")
main(["compare", "refined", "--patients", "2", "--episode-s", "1", "--output", {output!r}])
sys.stdout = sys.__stdout__
"""


@cache
def sources() -> dict[str, str]:
    files = [path.relative_to(ROOT).as_posix() for room in ROOMS for path in (ROOT / room).rglob("*.py")]
    return {file: (ROOT / file).read_text(encoding="utf-8") for file in files}


def within(file: str, patterns: tuple[str, ...]) -> bool:
    return any(fnmatch(file, pattern) for pattern in patterns)


def lines(files: list[str]) -> int:
    return sum(len(sources()[file].splitlines()) for file in files)


def imported(nodes: Iterator[ast.AST]) -> Iterator[str]:
    """Files of this project that imports among the nodes name."""
    names = {file.removesuffix(".py").removesuffix("/__init__").replace("/", "."): file for file in sources()}
    for node in nodes:
        if isinstance(node, ast.ImportFrom) and node.module:
            for alias in node.names:
                target = names.get(f"{node.module}.{alias.name}") or names.get(node.module)
                if target is not None:
                    yield target


@cache
def importers() -> dict[str, set[str]]:
    found: dict[str, set[str]] = {file: set() for file in sources()}
    for file, text in sources().items():
        for target in imported(ast.walk(ast.parse(text))):
            found[target].add(file)
    return found


def held(what: str, value: int) -> None:
    print(f"{what}: {value:,} of {LARGEST[what]:,}")
    assert value <= LARGEST[what]


@pytest.mark.parametrize("name", LEAVES)
def test_a_leaf_hangs_on_its_doors_alone(name):
    leaf = LEAVES[name]
    files = [file for file in sources() if within(file, leaf.files)]
    outside = {by for file in files for by in importers()[file] if not within(by, leaf.files)}
    assert files and not {by for by in outside if not within(by, leaf.doors) and not within(by, EXHIBITS)}
    assert lines(files) <= LARGEST["lines of a leaf"]
    assert all((ROOT / place).exists() for place in leaf.tests)
    page = (ROOT / "docs" / "leaves.md").read_text(encoding="utf-8")
    assert f"| {name} |" in page


def lines_of_the_trunk() -> int:
    return lines([file for file in sources() if not any(within(file, leaf.files) for leaf in LEAVES.values())])


def longest_chain() -> int:
    """Modules that import each other at their top, one after the other."""
    chains: dict[str, int] = {}

    def chain(file: str, above: tuple[str, ...] = ()) -> int:
        if file not in chains:
            targets = set(imported(iter(ast.parse(sources()[file]).body))) - {file, *above}
            chains[file] = 1 + max((chain(target, (*above, file)) for target in targets), default=0)
        return chains[file]

    return max(chain(file) for file in sources())


def public_names() -> int:
    """Functions and classes at the top of a module."""
    nodes = [node for text in sources().values() for node in ast.parse(text).body]
    names = [node.name for node in nodes if isinstance(node, ast.FunctionDef | ast.ClassDef)]
    return sum(not name.startswith("_") for name in names)


COUNTS = {
    "lines of the trunk": lines_of_the_trunk,
    "longest chain of imports": longest_chain,
    "public top-level names": public_names,
}


@pytest.mark.parametrize("what", COUNTS)
def test_a_count_only_falls(what):
    held(what, COUNTS[what]())


@pytest.mark.parametrize(("what", "code"), [("a step loads", STEP), ("eval compare loads", COMPARE)])
def test_what_is_loaded(what, code, tmp_path):
    rooms = tuple(str(ROOT / room) for room in ROOMS)
    program = MEASURED.format(code=code.format(output=str(tmp_path / "study")), rooms=rooms)
    ran = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, cwd=ROOT, timeout=600)
    assert ran.returncode == 0, ran.stderr
    modules, number = map(int, ran.stdout.split())
    held(f"lines that {what}", number)
    if f"modules that {what}" in LARGEST:
        held(f"modules that {what}", modules)


if __name__ == "__main__":
    print(", ".join(f"{what}: {count():,}" for what, count in COUNTS.items()))
