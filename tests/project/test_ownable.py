"""What somebody has to own: the lines that README's commands load together, and all others; both only fall.

Who brings a number down lowers its limit in the same commit. A folder that no room outside it imports is a leaf.
"""

import ast
import os
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
ROOMS = ("jawenv", "agents", "training", "eval", "research")
LARGEST = {
    "lines that README's commands load": 34_738,
    "lines of everything else": 13_355,
    "lines that a step loads": 12_463,
    "lines that eval compare loads": 21_040,
    "lines": 47_974,
    "files": 439,
    "functions": 2_764,
}
STEP = """
import gymnasium, jawenv
env = gymnasium.make("jawenv/Jaw-v3")
env.reset(seed=0)
env.step(env.action_space.sample())
"""
COMPARE = """
import eval.commands.app
eval.commands.app.main(["compare", "refined", "--patients", "2", "--episode-s", "1", "--output", "compared"])
"""
CONFIG = """
algorithm: APG
steps: 10
n_envs: 2
env: {kwargs: {control: targets, reward: worst, comfort_weight: 0.0, episode_s: 1.0}}
residual: {maneuver: refined_one_sided, scale: 0.5}
comfort: {target_discomfort_s: 0.1, episodes: 2}
arguments: {n_steps: 5}
network: {policy: [8], value: [], initial_action_scale: 0.1}
evaluation: {every_steps: 1000, patients: 2}
"""
README_COMMANDS = f"""
{STEP}
{COMPARE}
import runpy
sys.argv = ["example", "--make", "recording.csv"]
runpy.run_path({str(ROOT / "examples/estimate_from_a_recording.py")!r}, run_name="__main__")
import jawenv.commands.app
import jawenv.live.server, jawenv.live.session, jawenv.live.page, jawenv.commands.live
for line in ("identify recording.csv", "list maneuvers", "score apg_anyone --patients 2"):
    jawenv.commands.app.main(line.split())
eval.commands.app.main(["patient", "refined", "--episode-s", "1", "--output", "patient"])
import training.cli
Path("apg.yaml").write_text({CONFIG!r}, encoding="utf-8")
training.cli.main(["train", "apg.yaml", "--output", "trained"])
"""
MEASURED = """
import sys
from pathlib import Path
{code}
files = [getattr(module, "__file__", None) for module in list(sys.modules.values())]
Path("loaded").write_text("\\n".join(file for file in files if file and file.endswith(".py")), encoding="utf-8")
"""


@cache
def sources() -> dict[str, str]:
    files = [path.relative_to(ROOT).as_posix() for room in ROOMS for path in (ROOT / room).rglob("*.py")]
    return {file: (ROOT / file).read_text(encoding="utf-8") for file in files}


def lines(files: set[str]) -> int:
    return sum(len(sources()[file].splitlines()) for file in files)


def loaded(code: str, folder: Path) -> int:
    """Lines of this project that a program loads, which runs in a folder of its own."""
    program = [sys.executable, "-c", MEASURED.format(code=code)]
    own = os.environ | {"PYTHONPATH": str(ROOT)}
    ran = subprocess.run(program, capture_output=True, text=True, cwd=folder, env=own, timeout=900)
    assert ran.returncode == 0, ran.stderr
    files = (folder / "loaded").read_text(encoding="utf-8").splitlines()
    return lines(sources().keys() & {Path(file).relative_to(ROOT).as_posix() for file in files if str(ROOT) in file})


def functions() -> int:
    nodes = (node for text in sources().values() for node in ast.walk(ast.parse(text)))
    return sum(isinstance(node, ast.FunctionDef) for node in nodes)


COUNTS = {
    "lines": lambda folder: lines(set(sources())),
    "files": lambda folder: len(sources()),
    "functions": lambda folder: functions(),
    "lines that a step loads": lambda folder: loaded(STEP, folder),
    "lines that eval compare loads": lambda folder: loaded(COMPARE, folder),
}


def held(what: str, value: int) -> None:
    print(f"{what}: {value:,} of {LARGEST[what]:,}")
    assert value <= LARGEST[what]


@pytest.mark.parametrize("what", COUNTS)
def test_a_count_only_falls(what, tmp_path):
    held(what, COUNTS[what](tmp_path))


def test_what_readme_loads(tmp_path):
    together = loaded(README_COMMANDS, tmp_path)
    held("lines that README's commands load", together)
    held("lines of everything else", lines(set(sources())) - together)


if __name__ == "__main__":
    print(", ".join(f"{what}: {COUNTS[what](Path()):,}" for what in list(COUNTS)[:3]))
