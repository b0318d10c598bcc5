"""Maneuver files: those that come along, the README's example, and what a wrong one is told."""

import re
from pathlib import Path

import numpy as np
import pytest
import yaml

from agents.registry import load_agent
from jawenv.base.errors import InputError
from jawenv.device.channels import HIGHEST, LOWEST
from jawenv.playing.maneuvers import maneuver_names
from jawenv.playing.maneuvers.maneuver import FOLDER, Maneuver

README = Path(__file__).parents[2] / "agents" / "README.md"
SPEEDS_MM = np.array([25.0, 6.0])  # opening and side range of a typical patient


def example() -> dict:
    """The example of the README, as a user would copy it."""
    found = re.search(r"```yaml\n(.*?)```", README.read_text(encoding="utf-8"), re.DOTALL)
    assert found is not None
    return yaml.safe_load(found.group(1))


@pytest.mark.parametrize("name", maneuver_names())
def test_every_file_loads_under_its_own_name(name: str) -> None:
    maneuver = Maneuver.load(FOLDER / f"{name}.yaml")
    assert maneuver.name == name and maneuver.title and maneuver.description and maneuver.source
    t = np.arange(0.0, 60.0, 0.05)
    targets = maneuver.targets(t)
    assert targets.value.shape == targets.rate.shape == (len(t), 4)
    low, high = np.array(LOWEST), HIGHEST
    assert (targets.value >= low - 1e-9).all() and (targets.value <= high + 1e-9).all()
    np.testing.assert_allclose(targets.value[0], 0.0, atol=1e-12)
    between = maneuver.targets(t[:-1] + 0.025).rate
    np.testing.assert_allclose(np.diff(targets.value, axis=0) / 0.05, between, atol=0.15)
    speed = np.linalg.norm(between[:, :2] * SPEEDS_MM, axis=1)
    assert speed.max() < 30.0, "mm/s, below the soft limit of 40"


def refusal(tmp_path: Path, text: str) -> str:
    path = tmp_path / "mine.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as caught:
        load_agent(path)
    message = str(caught.value)
    assert message.startswith(str(path)) and "\n" not in message
    return message


def changed(place: str, value: object) -> str:
    """The example with one entry replaced, or removed where the value is None."""
    content = example()
    *parents, last = place.split(".")
    node = content
    for key in parents:
        node = node[key]
    if value is None:
        del node[last]
    else:
        node[last] = value
    return yaml.safe_dump(content)


@pytest.mark.parametrize(
    ("place", "value", "expected"),
    [
        ("title", None, "title is missing"),
        ("channels.opening", None, "channels.opening is missing"),
        ("channels.side.kind", None, "channels.side"),
        ("name", "My maneuver", "name = 'My maneuver'"),
        ("channels.sideways", {"kind": "keyframes", "points": []}, "unknown key 'channels.sideways'"),
        ("channels.side.harmonics", [{"amplitude": 1.5, "period_s": 4}], "side runs from -1.5 to 1.5; allowed: -1"),
        ("channels.opening.points", [{"t_s": 0, "value": -0.2}], "opening runs from -0.2 to -0.2; allowed: 0 to 1"),
        ("channels.side.harmonics", [{"amplitude": "big", "period_s": 4}], "amplitude is 'big'; allowed: a number"),
        ("fade_in_s", 0, "fade_in_s is 0"),
        (
            "channels.side.harmonics",
            [{"amplitude": 0.9, "frequency_hz": 5}],
            "channels: side moves at 28.27 per second; allowed: 10 at most",
        ),
        ("fade_in_s", 1e-9, "fade_in_s is 1e-09; allowed: greater than or equal to 0.001"),
    ],
)
def test_a_wrong_file_is_told_what_is_wrong(tmp_path: Path, place: str, value: object, expected: str) -> None:
    assert expected in refusal(tmp_path, changed(place, value))


def test_a_target_that_begins_away_from_rest_fades_in_slowly(tmp_path: Path) -> None:
    content = example()
    content["channels"]["side"]["harmonics"] = [{"amplitude": 0.6, "period_s": 4, "phase_deg": 90}]
    content["fade_in_s"] = 0.01
    expected = "fade_in_s = 0.01 takes side to 0.6 at 60 per second; allowed: 10 at most"
    assert expected in refusal(tmp_path, yaml.safe_dump(content))


def test_what_is_no_maneuver_is_named(tmp_path: Path) -> None:
    assert "damaged YAML" in refusal(tmp_path, "name: [unclosed")
    assert "mapping" in refusal(tmp_path, "- just\n- a list\n")
