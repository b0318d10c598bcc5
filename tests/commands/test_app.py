"""The command line of the library, in this process."""

import inspect
import os
import subprocess
import sys
import time
from importlib.metadata import version

import pytest
import typer

import eval.commands.app
import training.cli
from eval.commands.patient import CLINIC, as_a_clinic
from jawenv import InputError
from jawenv.anatomy import COHORTS
from jawenv.commands import live
from jawenv.commands.app import OPENS_WITH, app, main
from jawenv.commands.options import WORLD, takes_world
from jawenv.envs.configuration import Configuration
from jawenv.ladder import MODELS
from jawenv.live.session import DriveSession
from jawenv.live.setup import Setup
from jawenv.playing.excitation import BASELINES
from jawenv.playing.maneuvers import maneuver_names
from jawenv.playing.policies.card import policy_names
from tests.processes import started
from tests.recorded import BODY


@pytest.mark.parametrize(("what", "names"), [("maneuvers", maneuver_names()), ("cohorts", COHORTS), ("models", MODELS)])
def test_list_names_all_of_a_kind(what, names, capsys):
    assert main(["list", what]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == list(names)
    assert all(len(line.split()) > 3 for line in lines)  # a sentence each


def test_list_alone_names_every_kind(capsys):
    assert main(["list"]) == 0
    said = capsys.readouterr().out
    assert all(f"{kind}:\n" in said for kind in ("maneuvers", "agents", "cohorts", "models"))
    names = [line.split()[0] for line in said.splitlines() if not line.startswith(" ")]
    assert all(names.count(name) == 1 for name in maneuver_names())


@pytest.mark.parametrize("command_line", [main, eval.commands.app.main, training.cli.main])
def test_every_command_line_says_its_version_and_its_help(command_line, capsys):
    assert command_line(["--version"]) == 0
    assert capsys.readouterr().out == f"jawenv {version('jawenv')}\n"
    assert command_line(["-h"]) == 0
    assert "--version" in capsys.readouterr().out


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="a system without /dev/full")
def test_a_full_disk_behind_the_standard_output_is_one_line():
    with open("/dev/full", "w") as full:
        command = [sys.executable, "-c", "from jawenv.commands.app import main; raise SystemExit(main(['list']))"]
        ran = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, timeout=600)
    assert ran.returncode == 2
    assert ran.stderr == "error: the standard output cannot be written: No space left on device\n"


def test_list_of_agents_says_where_the_rest_is(capsys):
    assert main(["list", "agents"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines[:-1]] == [*policy_names(), *BASELINES]
    assert "from a clone" in lines[-1]
    (trismus,) = (line for line in lines if line.startswith("ppo_trismus"))
    assert "worst sd 1.9 % after 10 s, discomfort 0.01 s" in trismus and "corrects refined" in trismus
    assert all(any(cohort in line for cohort in COHORTS) for line in lines if line.startswith(("apg", "ppo")))
    assert any(line.startswith("apg_asked") and "one muscle asked" in line for line in lines)


@pytest.mark.parametrize(
    ("name", "id"), [("ppo_trismus", "Jaw-v3"), ("apg_imaged", "JawImaged-v3"), ("zero", "Jaw-v3")]
)
def test_a_policy_is_scored_in_the_world_of_its_training(name, id, capsys):
    assert main(["score", name, "--patients", "2", "--episode-s", "1"]) == 0
    out = capsys.readouterr().out
    assert out.startswith(f"{name} in jawenv/{id} on 2 patients")


def test_a_policy_is_scored_elsewhere_on_request_or_refused_in_one_line(capsys):
    assert main(["score", "ppo_trismus", "--patients", "2", "--episode-s", "1", "--control", "force"]) == 0
    assert main(["score", "ppo_trismus", "--env", "JawSides-v3"]) == 2
    assert main(["score", "ppo_trismos"]) == 2
    said = capsys.readouterr().err.splitlines()
    assert len(said) == 2 and "ppo_trismus" in said[1]


@pytest.mark.parametrize("knowledge", ["exact", "imaged"])
def test_score_prints_every_parameter_and_whether_it_can_be_believed(capsys, knowledge):
    assert main(["score", "refined", "--patients", "2", "--episode-s", "1", "--knowledge", knowledge]) == 0
    out = capsys.readouterr().out
    assert out.count("/masseter_") == 4 and "NEES" in out and "all within 10 %" in out


def test_score_takes_a_comfort_an_anatomy_and_a_force_sensor(tmp_path, capsys):
    (tmp_path / "strict.toml").write_text("force_N = 0.5\n")
    (tmp_path / "jaw.toml").write_text("mandible = {mass_kg = 0.4}\n")
    (tmp_path / "body.toml").write_text("".join(f"{name} = {value}\n" for name, value in BODY.items()))
    own = [
        ("--set", f"comfort={tmp_path / 'strict.toml'}"),
        ("--set", f"anatomy={tmp_path / 'jaw.toml'}"),
        *(
            ("--set", f"force_sensor={sensor}", "--knowledge", str(tmp_path / "body.toml"))
            for sensor in ("motors", "straps")
        ),
    ]
    said = []
    for each in [(), *own]:
        assert main(["score", "refined", "--patients", "2", "--episode-s", "1", *each]) == 0
        said.append(capsys.readouterr().out)
    assert len(set(said)) == 5
    costs = [float(line.split()[1]) for out in said for line in out.splitlines() if line.startswith("discomfort")]
    assert costs[1] > costs[0], "less is comfortable"


def commands():
    """Every command of the three command lines, by its words."""
    for name, line in (("eval", eval.commands.app.commands()), ("training", training.cli.app), ("jawenv", app)):
        for command, held in typer.main.get_command(line).commands.items():
            yield f"{name} {command}", {each.name: each for each in held.params if hasattr(each, "rich_help_panel")}


def test_a_command_s_own_options_come_first_and_the_world_s_are_in_a_panel():
    with_a_world = 0
    for _, held in commands():
        of_world = [each.rich_help_panel == WORLD for each in held.values() if each.param_type_name == "option"]
        assert of_world == sorted(of_world)
        with_a_world += any(of_world)
    assert with_a_world >= 8


@pytest.mark.parametrize(
    ("command", "cohort", "knowledge"),
    [
        ("eval patient", *CLINIC.values()),
        ("eval compare", Configuration().cohort.name, None),
        ("jawenv live", OPENS_WITH["cohort"], None),
        ("training train", None, None),
    ],
)
def test_help_states_the_defaults_that_the_command_uses(command, cohort, knowledge):
    assert CLINIC.items() <= as_a_clinic({"env": "Jaw"}).items()
    held = dict(commands())[command]
    for name, default in {"cohort": cohort, "knowledge": knowledge}.items():
        assert held[name].help.partition("[default: ")[2].strip("]") == (default or "")


def test_another_argument_of_a_world_is_set_by_its_name():
    def command(world: dict) -> dict:
        return world

    given = dict.fromkeys(inspect.signature(takes_world()(command)).parameters)
    texts = ["reward=worst", "comfort_weight=0.5", "record=true"]
    assert takes_world()(command)(**given | {"settings": texts}) == {
        "reward": "worst",
        "comfort_weight": 0.5,
        "record": True,
    }
    for text in ("rewrad=worst", "cohort=wide", "model=sides"):
        with pytest.raises(InputError, match="^--set is "):
            takes_world()(command)(**given | {"settings": [text]})


def test_a_terminated_live_page_saves_what_was_driven(tmp_path):
    code = (
        "import sys\nfrom jawenv.commands.app import main\nfrom jawenv.live.page import Page\n"
        "Page._drives = lambda page: not page.session.ended\nraise SystemExit(main(sys.argv[1:]))"
    )
    command = [sys.executable, "-c", code, "live", "--port", "0", "--output", str(tmp_path)]
    with started(command, stdout=subprocess.PIPE) as page:
        assert page.stdout.readline().startswith("the jaw is at")
        time.sleep(3.0)
        page.terminate()
        assert page.wait(60) == 0
    assert sorted(path.suffix for path in tmp_path.iterdir()) == [".csv", ".yaml"]


def test_live_drives_until_it_is_interrupted(tmp_path, capsys, monkeypatch):
    opened = []
    monkeypatch.setattr(live.webbrowser, "open", opened.append)
    monkeypatch.setattr("jawenv.live.page.Page.run", interrupt)
    assert main(["live", "--port", "0", "--output", str(tmp_path), "--driver", "refined", "--open"]) == 0
    out = capsys.readouterr().out
    assert out.startswith("the jaw is at http://127.0.0.1:") and opened[0] in out and out.count("\n") == 1


def test_live_plays_a_recording(tmp_path, capsys, monkeypatch):
    session = DriveSession(Setup.of(seed=500, episode_s=1.0))
    session.drive([0.3, 0.0, 0.0, 0.0])
    monkeypatch.setattr("jawenv.live.playback_page.PlaybackPage.run", interrupt)
    assert main(["live", str(session.save(tmp_path)[1]), "--port", "0"]) == 0
    assert "the jaw is at" in capsys.readouterr().out


def interrupt(page):
    raise KeyboardInterrupt


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["list", "birds"], "list is 'birds'; allowed: maneuvers, agents, cohorts, models"),
        (["score", "nope"], "agent is 'nope'; allowed: chirp"),
        (["score", "refined", "--env", "jaw2"], "env is 'jaw2'; did you mean jaw"),
        (["score", "refined", "--device", "cell_force=0.2"], "did you mean cell_force_N"),
        (["score", "refined", "--knowledge", "scan"], "imaged: from a scan"),
        (["identify", "nowhere.csv"], "nowhere.csv"),
        (["identify", "README.md", "--knowledge", "vague"], "README.md"),
        (["live", "--seed", "-1"], "seed is -1; allowed"),
        (["live", "--port", "70000"], "port is 70000; allowed"),
        (["live", "--port", "0", "--driver", "nope"], "driver is 'nope'; allowed: you, apg_anyone"),
        (["score", "refined", "--set", "comfort=nowhere.toml"], "nowhere.toml: no such file"),
        (["fly"], "No such command"),
    ],
)
def test_what_is_wrong_is_one_line_and_exit_2(arguments, message, capsys):
    assert main(arguments) == 2
    said = capsys.readouterr()
    assert said.err.startswith("error: ") and message in said.err and said.err.count("\n") == 1 and said.out == ""


def test_a_word_where_a_number_has_to_be_is_refused_plainly(capsys):
    assert main(["score", "chirp", "--patients", "ten"]) == 2
    assert capsys.readouterr().err == "error: Invalid value for '--patients': 'ten'; allowed: a whole number\n"
