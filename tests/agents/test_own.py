"""Agents of one's own: found in the current folder, made with what they take, and refused in one line."""

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import agents
from agents.own import source_of
from jawenv.base.errors import InputError
from jawenv.base.named_objects import is_named

SOURCE = '''
import numpy as np

class Still:
    """Holds still."""

    name = "still"

    def __init__(self, control, control_hz=1.0):
        self.given = control, control_hz

    def reset(self, num_envs, seed=None):
        pass

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        return np.zeros((*np.shape(observation)[:-1], 4), dtype=np.float32), None


def all_of_them(**settings):
    agent = Still(settings["control"])
    agent.given = settings
    return agent


def bare():
    return Still("force")


class Broken(Still):
    def __init__(self):
        raise RuntimeError("no motor\\nfound")


class Half:
    name = "half"

    def reset(self, num_envs, seed=None):
        pass


class Nameless(Still):
    name = None


NUMBER = 3
'''


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A current folder with modules, forgotten afterwards."""
    (tmp_path / "own_agents.py").write_text(SOURCE)
    (tmp_path / "own_broken.py").write_text("def oops(:\n")
    (tmp_path / "own_needy.py").write_text("import no_such_library\n")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [entry for entry in sys.path if entry])
    yield
    for name in ("own_agents", "own_broken", "own_needy"):
        sys.modules.pop(name, None)


def test_a_class_in_the_current_folder_is_given_the_settings_that_it_takes() -> None:
    agent = agents.load_agent("own_agents:Still", control="trajectory", control_hz=10.0)
    assert agent.name == "still" and agent.given == ("trajectory", 10.0)  # type: ignore[attr-defined]
    agent = agents.load_agent("own_agents:all_of_them", control="targets")
    assert agent.given == {"control": "targets", "control_hz": 5.0}  # type: ignore[attr-defined]
    assert agents.load_agent("own_agents:bare").name == "still"


def test_an_installed_class_is_found() -> None:
    assert agents.load_agent("agents.clairvoyant:Clairvoyant").name == "clairvoyant"


def test_files_in_the_current_folder_do_not_stand_in_for_installed_ones(tmp_path: Path) -> None:
    (tmp_path / "agents.py").write_text("raise RuntimeError")
    agents.load_agent("own_agents:Still")
    assert sys.path[-1] == str(tmp_path) and sys.path.count(str(tmp_path)) == 1


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        ("nowhere_at_all:Still", "no module 'nowhere_at_all'"),
        ("own_agents.deeper:Still", "no module 'own_agents.deeper'"),
        ("own_needy:Still", "module 'own_needy' cannot be imported: ModuleNotFoundError: No module named 'no_such"),
        ("own_broken:Still", "module 'own_broken' cannot be imported: SyntaxError"),
        ("own_agents:Stil", "module 'own_agents' has no 'Stil'"),
        ("own_agents:NUMBER", "is of type int; allowed: a class or function"),
        ("own_agents:Broken", "cannot be made: RuntimeError: no motor found"),
        ("own_agents:Half", "makes a Half without predict; an agent has name, reset, predict"),
        ("own_agents:Nameless", "its name is None"),
        ("own agents:Still", "; allowed: "),
    ],
)
def test_mistakes_get_one_line_that_names_them(spec: str, message: str) -> None:
    with pytest.raises(InputError) as caught:
        agents.load_agent(spec)
    assert str(caught.value).startswith("agent ") and f"'{spec}'" in str(caught.value) and "\n" not in str(caught.value)
    assert message in str(caught.value)


def test_the_form_of_a_name() -> None:
    assert is_named("a:B") and is_named("a.b_2:c")
    for other in ("a", "a:", ":b", "a/b:c", "C:\\b.zip", "a.:b", "2a:b", "a:b:c"):
        assert not is_named(other)


def test_the_source_is_the_modules_file(tmp_path: Path) -> None:
    assert source_of("own_agents:Still") == tmp_path / "own_agents.py"
    assert source_of("slow_opening") is None
