"""Model cards: what is written is read, and a wrong one gets one line."""

import json
from pathlib import Path

import pytest

import jawenv
from jawenv.base.errors import InputError
from jawenv.base.files import validate, write_json
from jawenv.envs.configuration import configure
from jawenv.playing.maneuvers import Maneuver
from jawenv.playing.policies.card import CARD, Environment, ModelCard, card_of, policy_folder, read_card
from tests.plain_policies import fields

RESULT = {"cohort": "trismus", "patients": 64, "seeds": [500, 563], "metric": "nats", "low": 44.4, "high": 46.5}


def refusal(folder: Path, **changed: object) -> str:
    (folder / CARD).write_text(json.dumps(fields(**changed)))
    with pytest.raises(InputError) as caught:
        read_card(folder)
    message = str(caught.value)
    assert "\n" not in message and message.startswith(str(folder / CARD))
    return message


def test_a_written_card_is_read_back(tmp_path: Path) -> None:
    residual = {"maneuver": Maneuver.named("opening_with_swings"), "scale": 0.25}
    card = validate(ModelCard, fields(residual=residual, results=[RESULT | {"mean": 45.5}]), "card")
    write_json(tmp_path / CARD, card)
    assert read_card(tmp_path) == read_card(tmp_path / CARD) == card
    assert card.residual is not None and card.residual.maneuver.name == "opening_with_swings"
    assert json.loads((tmp_path / CARD).read_text())["residual"]["maneuver"]["channels"]["opening"]


def test_the_world_of_a_training_is_told_whole_and_read_back(tmp_path: Path) -> None:
    (tmp_path / "own.json").write_text(json.dumps(jawenv.cohort("trismus").to_dict() | {"name": "mine"}))
    changes = {"cohort": str(tmp_path / "own.json"), "knowledge": "imaged", "device": {"cell_force_N": 0.2}}
    world = configure({"control": "trajectory", "control_hz": 10.0, "episode_s": 12.0, **changes})
    told = Environment.of(world)
    assert told.cohort["name"] == "mine"  # type: ignore[index, call-overload]
    assert json.loads(told.model_dump_json())["others"]["device"] == {"cell_force_N": 0.2}
    assert told.world() == world == configure(told.kwargs())


def test_a_card_names_no_plant() -> None:
    """Its module would run where the policy's world is made."""
    told = Environment.of(configure({"plant": "my_module:MyJaw"}))
    assert told.world().plant is None
    with pytest.raises(InputError, match="plant is 'os:abort'; allowed in a card: none"):
        told.model_copy(update={"others": {"plant": "os:abort"}}).world()


def test_an_unknown_format_is_named_before_its_fields(tmp_path: Path) -> None:
    assert "format_version is 2; this jawenv reads 1" in refusal(tmp_path, format_version=2, colour="red")


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"observation_size": 9}, "allowed: from observation_size 9 to action_size 4"),
        ({"weights_sha256": "abc"}, "weights_sha256 = 'abc'"),
        (
            {"architecture": {"layers": [9, 4], "activation": "sine", "squash": "clip"}},
            "architecture.activation is 'sine'",
        ),
        ({"colour": "red"}, "unknown key 'colour'"),
        ({"results": [RESULT]}, "nats: give either mean or median"),
        ({"results": [RESULT | {"mean": 1.0, "median": 1.0}]}, "nats: give either mean or median"),
        ({"results": [RESULT | {"median": 45.0, "low": 47.0}]}, "low is 47; allowed: at most high, 46.5"),
    ],
)
def test_mistakes_get_one_line_that_names_them(tmp_path: Path, changed: dict, message: str) -> None:
    assert message in refusal(tmp_path, **changed)


def test_half_a_policy_counts_as_one_to_be_named(tmp_path: Path) -> None:
    assert policy_folder(tmp_path) is None and card_of(tmp_path) is None
    (tmp_path / "policy.safetensors").write_bytes(b"")
    assert policy_folder(tmp_path) == tmp_path
    with pytest.raises(InputError):
        card_of(tmp_path)
