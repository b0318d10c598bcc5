"""Model cards: what is written is read, and a wrong one gets one line."""

import json
from pathlib import Path

import pytest
from exported_folder import fields

from agents.card import CARD, ModelCard, exported_place, read_card
from jawenv.errors import InputError
from jawenv.files import validate, write_json
from jawenv.playing.maneuvers import Maneuver

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


def test_the_environment_can_be_made_of_its_arguments() -> None:
    from jawenv.envs.configuration import configure

    environment = validate(ModelCard, fields(), "card").environment.model_copy(update={"others": {"track_bound": True}})
    made = configure(environment.kwargs())
    assert (made.control, made.control_hz, made.episode_s, made.track_bound) == ("trajectory", 10.0, 12.0, True)


def test_shapes_of_the_weights_follow_the_layers() -> None:
    card = validate(ModelCard, fields(), "card")
    assert card.architecture.shapes() == {
        "layers.0.weight": (5, card.observation_size),
        "layers.0.bias": (5,),
        "layers.1.weight": (4, 5),
        "layers.1.bias": (4,),
    }


def test_an_unknown_format_is_named_before_its_fields(tmp_path: Path) -> None:
    assert "format_version is 2; this jawenv reads 1" in refusal(tmp_path, format_version=2, colour="red")


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"observation_size": 9}, "allowed: from observation_size 9 to action_size 4"),
        ({"weights_sha256": "abc"}, "weights_sha256 = 'abc'"),
        (
            {"architecture": {"layers": [9, 4], "activation": "sine", "squash": "clip"}},
            "architecture.activation = 'sine'",
        ),
        ({"colour": "red"}, "unknown key 'colour'"),
        ({"results": [RESULT]}, "nats: give either mean or median"),
        ({"results": [RESULT | {"mean": 1.0, "median": 1.0}]}, "nats: give either mean or median"),
        ({"results": [RESULT | {"median": 45.0, "low": 47.0}]}, "low 47 must not be above high 46.5"),
    ],
)
def test_mistakes_get_one_line_that_names_them(tmp_path: Path, changed: dict, message: str) -> None:
    assert message in refusal(tmp_path, **changed)


def test_half_a_policy_counts_as_one_to_be_named(tmp_path: Path) -> None:
    assert exported_place(tmp_path) is None
    (tmp_path / "policy.safetensors").write_bytes(b"")
    assert exported_place(tmp_path) == tmp_path
    with pytest.raises(InputError):
        read_card(tmp_path)
