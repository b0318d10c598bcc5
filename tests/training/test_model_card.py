"""The README of an exported policy says what its card says, in the form that the Hugging Face Hub reads."""

from pathlib import Path

import pytest
import yaml
from markdown import markdown

from agents.card import SHIPPED, ModelCard, policy_names, read_card
from training.run.model_card import README, metadata, readme


def header_of(text: str) -> dict:
    start, header, _ = text.split("---\n", 2)
    assert start == ""
    return yaml.safe_load(header)


@pytest.mark.parametrize("name", policy_names())
def test_those_of_the_policies_that_come_along_are_of_their_cards(name: str) -> None:
    text = (SHIPPED / name / README).read_text(encoding="utf-8")
    card = read_card(SHIPPED / name)
    assert text == readme(name, card)
    header = header_of(text)
    assert header["license"] == "mit" and header["library_name"] == "jawenv"
    assert {"reinforcement-learning", "gymnasium", card.algorithm} <= set(header["tags"])
    (index,) = header["model-index"]
    assert index["name"] == name and len(index["results"]) == len(card.results) > 0
    for entry, result in zip(index["results"], card.results, strict=True):
        (metric,) = entry["metrics"]
        assert metric["name"] == result.metric
        assert metric["value"] == (result.mean if result.median is None else result.median)
        assert (metric["args"]["low"], metric["args"]["high"]) == (result.low, result.high)
        assert entry["dataset"]["args"]["patients"] == result.patients and entry["task"]["name"] == card.environment.id
        assert f"| {result.metric} |" in text


def card_with(**changed: object) -> ModelCard:
    fields = read_card(SHIPPED / "ppo_trismus").model_dump(mode="json")
    return ModelCard.model_validate(fields | changed)


def test_a_policy_without_results_has_no_index() -> None:
    text = readme("mine", card_with(results=[]))
    assert "model-index" not in header_of(text) and "## Results" not in text


@pytest.mark.parametrize(
    ("licence", "expected"),
    [
        ("CC-BY-4.0", {"license": "cc-by-4.0"}),
        ("Our own, 2030", {"license": "other", "license_name": "our-own-2030"}),
    ],
)
def test_a_licence_is_named_as_the_hub_names_it(licence: str, expected: dict) -> None:
    assert expected.items() <= metadata("mine", card_with(licence=licence)).items()


def test_what_a_card_says_cannot_break_the_page() -> None:
    told, flat = "a | b\n---\n# no: [yaml", "a | b --- # no: [yaml"
    result = read_card(SHIPPED / "ppo_trismus").results[0].model_dump(mode="json") | {"metric": told}
    text = readme('x"y', card_with(results=[result], licence=told, algorithm=told))
    header = header_of(text)
    assert header["model-index"][0]["results"][0]["metrics"][0]["name"] == flat and flat in header["tags"]
    assert "<h1>no" not in markdown(text.split("---\n", 2)[2])


def test_it_is_written_in_utf8(tmp_path: Path) -> None:
    (tmp_path / README).write_text(readme("größe", card_with()), encoding="utf-8")
    assert "größe" in header_of((tmp_path / README).read_text(encoding="utf-8"))["model-index"][0]["name"]
