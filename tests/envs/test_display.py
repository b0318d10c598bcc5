"""A window that nobody would see is refused before anything is simulated, unless it was asked for."""

import gymnasium as gym
import pytest

import jawenv  # noqa: F401  registers the environments
from eval.commands.app import main
from jawenv.base.display import check_display
from jawenv.base.errors import InputError
from jawenv.envs import jaw

UNSEEN = [
    ({}, "neither DISPLAY nor WAYLAND_DISPLAY is set"),
    ({"SDL_VIDEODRIVER": "dummy"}, "SDL_VIDEODRIVER is dummy"),
    ({"SDL_VIDEODRIVER": "offscreen", "DISPLAY": ":0"}, "SDL_VIDEODRIVER is offscreen"),
]


@pytest.fixture(autouse=True)
def linux_without_display(monkeypatch):
    monkeypatch.setattr("sys.platform", "linux")
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "SDL_VIDEODRIVER"):
        monkeypatch.delenv(name, raising=False)


def set_all(monkeypatch, environment):
    for name, value in environment.items():
        monkeypatch.setenv(name, value)


def test_the_environment_is_not_made(monkeypatch):
    monkeypatch.setattr(jaw, "Simulation", None)
    with pytest.raises(InputError) as refused:
        gym.make("jawenv/Jaw-v3", render_mode="human")
    assert str(refused.value) == (
        "render_mode: 'human' needs a display (neither DISPLAY nor WAYLAND_DISPLAY is set); "
        "use 'rgb_array', or SDL_VIDEODRIVER=dummy to draw unseen"
    )


@pytest.mark.parametrize(("environment", "reason"), UNSEEN)
def test_play_names_the_film_in_one_line(monkeypatch, capsys, environment, reason):
    set_all(monkeypatch, environment)
    monkeypatch.setattr(jaw, "Simulation", None)
    assert main(["play", "hold_still"]) == 2
    said = f"error: a window needs a display ({reason}); use --video FILE, which writes a film\n"
    assert capsys.readouterr().err == said


def test_a_display_that_cannot_be_opened_is_refused(monkeypatch):
    monkeypatch.setenv("DISPLAY", ":4711")
    with pytest.raises(InputError):
        check_display("a window", "use another")
