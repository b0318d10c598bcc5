"""What the documentation shows can be done: Python blocks run, files load, commands are taken.

Blocks run in the order of their page, in one namespace, with short episodes.
"""

import functools
import re
import shlex
import shutil
import tomllib
from pathlib import Path

import click
import gymnasium as gym
import pytest
import typer
import yaml
from documented import PAGES, ROOT, Block, blocks
from stable_baselines3 import PPO

import eval.commands.app
import jawenv
import jawenv.commands.app
import jawenv.playing.rollout
import training.cli
from jawenv.recordings.files import load_record
from training.run.algorithms import algorithm_class, parameters_of
from training.run.config import TrainingConfig

EPISODE_S = 2.0
COMMANDS = {"eval": eval.commands.app.commands(), "training": training.cli.app}


@pytest.fixture
def short(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """Short episodes and trainings, and a folder of the example's own to write in."""
    monkeypatch.chdir(tmp_path)
    for name in ("make", "make_vec"):
        make = getattr(gym, name)
        monkeypatch.setattr(gym, name, functools.partial(make, episode_s=EPISODE_S))
    play = jawenv.playing.rollout.play
    monkeypatch.setattr(PPO, "learn", lambda model, steps, learn=PPO.learn: learn(model, 1))
    shortened = {"episode_s": EPISODE_S}
    monkeypatch.setattr(
        jawenv,
        "play",
        lambda *given, env_kwargs=None, **rest: play(*given, env_kwargs=shortened | (env_kwargs or {}), **rest),
    )
    return tmp_path


def pages_with(*languages: str) -> list[Path]:
    return [page for page in PAGES if blocks(page, *languages)]


def run(found: list[Block]) -> dict[str, object]:
    names: dict[str, object] = {"__name__": "example"}
    for block in found:
        exec(compile(block.text, block.place, "exec"), names)
    return names


@pytest.mark.parametrize("page", pages_with("python"), ids=lambda page: str(page.relative_to(ROOT)))
def test_python_examples_run(page: Path, short: Path) -> None:
    if page.name == "recordings.md":  # a bench's file, of which the page speaks after it has made one of its own
        first, *rest = blocks(page, "python")
        names = run([first])
        shutil.copy("recording.csv", "bench.csv")
        for block in rest:
            exec(compile(block.text, block.place, "exec"), names)
    else:
        run(blocks(page, "python"))


def test_the_readmes_first_block_prints_what_stands_below_it(capsys: pytest.CaptureFixture[str]) -> None:
    (block,), (said,) = blocks(ROOT / "README.md", "python"), blocks(ROOT / "README.md", "text")
    exec(compile(block.text, "README.md", "exec"), {"__name__": "example"})
    printed, stated = ([line.split() for line in text.splitlines()] for text in (capsys.readouterr().out, said.text))
    assert printed[:2] == stated[:2], "the headings"
    for (entry, *figures), (name, *shown) in zip(printed[2:], stated[2:], strict=True):
        assert entry == name and [float(x) for x in figures] == pytest.approx([float(x) for x in shown], rel=0.02), name


def test_a_maneuver_file_is_one(tmp_path: Path) -> None:
    example, *_ = blocks(ROOT / "agents" / "README.md", "yaml")
    file = tmp_path / "maneuver.yaml"
    file.write_text(example.text, encoding="utf-8")
    assert jawenv.Maneuver.load(file).name == "open_and_swing"


def test_a_configuration_is_one() -> None:
    (example,) = blocks(ROOT / "training" / "README.md", "yaml")
    config = TrainingConfig(**yaml.safe_load(example.text))
    known = parameters_of(algorithm_class(config.algorithm))
    assert config.arguments.keys() <= known.keys() and config.network.features is not None


def test_a_recording_is_one(tmp_path: Path) -> None:
    (text,) = (block for block in blocks(ROOT / "docs" / "recordings.md", "") if block.text.startswith("time_s"))
    file = tmp_path / "recording.csv"
    file.write_text(text.text, encoding="utf-8")
    assert len(load_record(file).time) == len(text.text.splitlines()) - 1


def commands() -> list[tuple[str, str]]:
    """(place, command line) of every shell block, comments left out, continued lines joined."""
    found = []
    for page in PAGES:
        for block in blocks(page, "sh", "bash"):
            lines = block.text.replace("\\\n", " ").splitlines()
            found += [(block.place, line) for line in lines if shlex.split(line, comments=True)]
    return found


@pytest.mark.parametrize(("place", "line"), commands(), ids=lambda value: value[:60])
def test_a_command_is_taken(place: str, line: str) -> None:
    program, *words = shlex.split(line, comments=True)
    while "=" in program:  # a variable of the environment
        program, *words = words
    if program == "make":
        assert re.search(rf"^{words[0]}:", (ROOT / "Makefile").read_text(), re.M), place
    elif Path(program).name == "pip":
        project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
        assert set(re.findall(r"\[(\w+)\]", words[-1])) <= set(project["optional-dependencies"]), place
    elif Path(program).name == "jawenv":
        taken(jawenv.commands.app.app, words)
    elif words[:1] == ["-m"] and words[1] in COMMANDS:
        taken(COMMANDS[words[1]], words[2:])
    elif words[:1] == ["-m"]:
        source = (ROOT / f"{words[1].replace('.', '/')}.py").read_text(encoding="utf-8")
        assert all(f'"{word}"' in source for word in words[2:] if word.startswith("--")), place
    elif program.endswith("python") and words[0] != "-c":
        source = (ROOT / words[0]).read_text(encoding="utf-8")
        for option in (word for word in words if word.startswith("--")):
            assert f'"{option}"' in source, f"{place}: {words[0]} has no {option}"
    elif program == ".ci/setup":
        groups = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["dependency-groups"]
        assert set(words) <= groups.keys(), place
    else:
        assert words[:1] in (["-c"], [".venv/bin/activate"]) or program.endswith("tensorboard"), f"{place}: {line}"


def taken(app: typer.Typer, words: list[str]) -> None:
    """Parse the words as the program does, without doing what they say.

    Raises:
        click.UsageError: an unknown command, option or value.
    """
    group = typer.main.get_command(app)
    assert isinstance(group, click.Group | typer.core.TyperGroup)
    name, command, rest = group.resolve_command(group.make_context("", list(words)), list(words))
    assert command is not None
    command.make_context(name, rest)
