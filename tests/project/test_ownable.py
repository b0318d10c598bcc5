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
    "lines of the trunk": 26_451,
    "lines of a leaf": 2_810,
    "doors of a leaf": 2,
    "longest chain of imports": 31,
    "public top-level names": 1_554,
    "modules that a step loads": 104,
    "lines that a step loads": 12_792,
    "lines that eval compare loads": 22_931,
}


@dataclass(frozen=True)
class Leaf:
    """A capability of its own: its files, the files of the trunk that may import it, its tests, leaves on top of it."""

    files: tuple[str, ...]
    doors: tuple[str, ...]
    tests: tuple[str, ...]
    users: tuple[str, ...] = ()


EVAL, TRAINING, JAWENV = "eval/commands/app.py", "training/cli.py", "jawenv/commands/app.py"
COMPARE, PUBLIC, SIMULATION = "eval/commands/comparison.py", "jawenv/__init__.py", "jawenv/envs/simulation.py"
FORMS = ("jawenv/envs/jaw.py", "jawenv/envs/vector.py")
LEAVES = {
    "live page": Leaf(
        ("jawenv/live/*", "jawenv/commands/live.py", "eval/commands/live.py"), (JAWENV, EVAL), ("tests/live",)
    ),
    "pictures": Leaf(
        ("jawenv/rendering/*", "jawenv/envs/pictures.py", "jawenv/envs/shown_world.py"),
        FORMS,
        ("tests/rendering", "tests/envs/test_vector_pictures_and_attributes.py"),
        ("live page", "films", "report", "patient's page", "motion in the report", "suggest"),
    ),
    "trackers": Leaf(("jawenv/trackers/*",), (JAWENV,), ("tests/trackers",)),
    "files as they are": Leaf(
        ("jawenv/recordings/mapping.py", "jawenv/recordings/dialects.py", "jawenv/recordings/resampling.py"),
        ("jawenv/recordings/files.py", "jawenv/recordings/table.py"),
        ("tests/recordings/test_dialects.py",),
        ("trackers", "stretcher's logs"),
    ),
    "answer": Leaf(
        ("jawenv/commands/answer.py",),
        ("jawenv/commands/recordings.py",),
        ("tests/commands/test_answer.py",),
        ("suggest", "several recordings", "doctor"),
    ),
    "plausibility": Leaf(
        ("jawenv/recordings/plausibility.py",),
        ("jawenv/commands/recordings.py", "jawenv/recordings/identification.py"),
        ("tests/recordings/test_identification.py",),
        ("trackers", "doctor"),
    ),
    "thesis": Leaf(("eval/thesis/*",), (EVAL,), ("tests/eval/thesis",)),
    "benchmark": Leaf(
        ("eval/benchmark/*", "eval/commands/benchmark.py", "eval/rows/times.py"), (EVAL,), ("tests/eval/benchmark",)
    ),
    "studies": Leaf(("eval/studies/*",), (EVAL,), ("tests/eval/studies",)),
    "calibration tables": Leaf(
        (
            *("eval/calibration/*", "eval/commands/calibration.py"),
            *("eval/rows/beliefs.py", "eval/rows/filters.py", "eval/rows/nuisances.py"),
        ),
        (EVAL,),
        ("tests/eval/calibration",),
    ),
    "untold errors": Leaf(
        ("jawenv/recordings/untold/*",),
        ("jawenv/commands/recordings.py", "jawenv/metrics/score.py"),
        ("tests/recordings/untold",),
        ("patient's page", "suggest", "several recordings", "clocks"),
    ),
    "several recordings": Leaf(
        ("jawenv/recordings/several/*", "jawenv/commands/several.py"),
        (JAWENV,),
        ("tests/recordings/several",),
        ("patient's page",),
    ),
    "clocks": Leaf(
        ("jawenv/recordings/clocks/*",),
        ("jawenv/commands/recordings.py",),
        ("tests/recordings/clocks",),
        ("several recordings", "doctor"),
    ),
    "doctor": Leaf(
        ("jawenv/recordings/doctor/*", "jawenv/commands/doctor.py"), (JAWENV,), ("tests/recordings/doctor",)
    ),
    "stretcher's logs": Leaf(
        ("jawenv/recordings/stretcher/*", "jawenv/commands/stretcher.py"),
        ("jawenv/commands/recordings.py",),
        ("tests/recordings/stretcher", "tests/commands/test_stretcher.py"),
    ),
    "patient's page": Leaf(
        ("eval/patient/*", "eval/commands/patient.py"), (EVAL, "jawenv/commands/recordings.py"), ("tests/eval/patient",)
    ),
    "report": Leaf(
        (
            *("eval/report/page.py", "eval/report/films.py", "eval/report/charts.py", "eval/report/learning.py"),
            *("eval/report/overview.py",),
        ),
        (COMPARE,),
        ("tests/eval/report",),
    ),
    "motion in the report": Leaf(("eval/comparison/motion.py",), (COMPARE,), ("tests/eval/comparison/test_motion.py",)),
    "written maneuvers": Leaf(
        ("jawenv/playing/maneuvers/written.py",),
        (),
        ("tests/playing/test_written_maneuvers.py",),
        ("recorded actions", "replays of averages", "maneuver search", "suggest", "live page"),
    ),
    "recorded actions": Leaf(
        ("agents/replay.py",),
        ("agents/registry.py",),
        ("tests/agents/test_replay.py",),
        ("replays of averages",),
    ),
    "replays of averages": Leaf(("eval/episodes/replays.py",), (COMPARE,), ("tests/eval/episodes/test_replays.py",)),
    "results of a card": Leaf(
        ("eval/comparison/card_results.py",), (COMPARE,), ("tests/eval/comparison/test_card_results.py",)
    ),
    "films": Leaf(
        ("eval/episodes/film.py", "eval/episodes/video.py", "jawenv/rendering/film.py"),
        (EVAL,),
        ("tests/eval/episodes/test_film.py",),
        ("report", "suggest"),
    ),
    "suggest": Leaf(
        ("jawenv/suggesting/*", "jawenv/commands/suggest.py", "eval/report/suggested.py"),
        (JAWENV,),
        ("tests/suggesting",),
    ),
    "design environments": Leaf(("jawenv/design/*",), (), ("tests/design",)),
    "inference": Leaf(
        ("jawenv/inference/*", "eval/*information.py", "eval/rows/gains.py"),
        (EVAL, PUBLIC),
        ("tests/inference",),
        ("design environments", "suggest"),
    ),
    "bound": Leaf(
        ("jawenv/filter/bound/*", "jawenv/envs/world/bound_kernel.py", "jawenv/analysis/bound.py")
        + ("jawenv/analysis/path.py",),
        (PUBLIC, SIMULATION),
        ("tests/analysis/test_bound.py", "tests/envs/test_bound_within_sds.py"),
        ("inference", "identifiability", "references"),
    ),
    "identifiability": Leaf(
        ("jawenv/analysis/identifiability.py", "jawenv/analysis/observability.py"),
        (PUBLIC,),
        ("tests/analysis/test_identifiability.py",),
        ("inference", "answer"),
    ),
    "references": Leaf(
        ("jawenv/references/*", "jawenv/analysis/joint_likelihood.py", "jawenv/mechanics/newton_euler.py"),
        (),
        ("tests/references",),
        ("calibration tables", "patient's page", "inference"),
    ),
    "seeds side by side": Leaf(("training/run/seeds.py",), (TRAINING,), ("tests/training/test_seeds_side_by_side.py",)),
    "tune": Leaf(("training/run/tune.py",), (TRAINING,), ("tests/training/test_tune.py",)),
    "onnx": Leaf(("training/run/onnx_file.py",), (TRAINING,), ("tests/training/test_onnx_file.py",)),
    "learning curves": Leaf(("training/run/plot.py",), (TRAINING,), ("tests/training/test_plot.py",)),
    "maneuver search": Leaf(("training/search/*",), (TRAINING,), ("tests/training/test_refine.py",)),
    "apg": Leaf(
        ("training/run/pathwise.py",),
        ("training/run/algorithms.py", "training/run/train.py"),
        ("tests/training/test_pathwise.py",),
    ),
    "features of one's own": Leaf(
        ("training/run/features.py",), ("training/run/algorithms.py",), ("tests/training/test_own_parts.py",)
    ),
    "networks without a card": Leaf(
        ("agents/without_card.py",),
        ("agents/policies.py", "training/run/train.py"),
        ("tests/training/test_own_parts.py",),
    ),
    "arguments of an algorithm": Leaf(
        ("training/run/arguments.py",),
        ("training/run/algorithms.py",),
        ("tests/training/test_arguments.py",),
        ("tune",),
    ),
    "twin": Leaf(("agents/twin/*",), (), ("tests/agents/twin",), ("clairvoyant", "apg", "maneuver search")),
    "planning": Leaf(
        ("agents/planning.py",),
        ("agents/planners.py",),
        ("tests/agents/test_planning.py",),
        ("clairvoyant",),
    ),
    "clairvoyant": Leaf(("agents/clairvoyant.py",), ("agents/planners.py",), ("tests/agents/test_planning.py",)),
    "agents of one's own": Leaf(("agents/own.py",), ("agents/registry.py",), ("tests/agents/test_own.py",)),
    "form of stable-baselines3": Leaf(
        ("jawenv/sb3.py",), ("training/run/worlds.py",), ("tests/training/test_worlds.py",)
    ),
    "attributes of worlds": Leaf(
        ("jawenv/envs/world_attributes.py",),
        ("jawenv/envs/vector.py",),
        ("tests/envs/test_vector_pictures_and_attributes.py",),
    ),
    "snapshots": Leaf(("jawenv/envs/snapshots.py",), FORMS, ("tests/envs/test_snapshots.py",)),
    "pymunk's rung": Leaf(
        ("jawenv/mechanics/sagittal*", "jawenv/envs/sagittal_plant.py"),
        (SIMULATION,),
        ("tests/mechanics/test_sagittal.py",),
    ),
    "two condyles": Leaf(
        ("jawenv/mechanics/bilateral*", "jawenv/filter/model/body_step.py", "jawenv/envs/world/two_condyles.py"),
        (),
        ("tests/mechanics/test_bilateral.py", "tests/validation/test_bilateral_against_midline.py"),
    ),
    "nuisances in the filter": Leaf(
        ("jawenv/filter/nuisances/changes.py", "jawenv/filter/nuisances/changed_jaw.py"),
        ("jawenv/filter/nuisances/known_within.py",),
        ("tests/filter/test_nuisances.py",),
        ("bound", "untold errors"),
    ),
    "forces without a cell": Leaf(
        ("jawenv/filter/nuisances/without_cell.py",),
        ("jawenv/filter/nuisances/changes.py",),
        ("tests/envs/test_without_load_cell.py",),
    ),
    "MuJoCo's jaw": Leaf(("jawenv/mechanics/mujoco_jaw.py",), (), ("tests/mechanics/test_mujoco_jaw.py",)),
    "own estimators": Leaf(
        ("jawenv/envs/own_estimators.py", "jawenv/envs/world/belief_kernel.py"),
        ("jawenv/envs/configuration.py", SIMULATION),
        ("tests/envs/test_own_estimators.py",),
    ),
    "openings of patients": Leaf(
        ("jawenv/mechanics/passive_opening.py",), (), ("tests/mechanics/test_equilibrium.py",), ("stretcher's logs",)
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
    on_top = {user: {by for by in outside if within(by, LEAVES[user].files)} for user in leaf.users}
    doors = {by for by in outside.difference(*on_top.values()) if not within(by, EXHIBITS)}
    assert files and doors <= set(leaf.doors) and all(on_top.values())
    assert len(leaf.doors) <= LARGEST["doors of a leaf"]
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
