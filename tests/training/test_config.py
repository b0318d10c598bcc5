"""The settings of a run: defaults, files, the command line, and what is said about mistakes in them."""

from pathlib import Path

import pytest

from jawenv.base.errors import InputError
from jawenv.base.seeds import VALIDATION
from training.run.algorithms import algorithm_class, parameters_of
from training.run.config import DEFAULT_CONFIG, Residual, TrainingConfig, asked_for, config_file


def load(tmp_path: Path, text: str) -> TrainingConfig:
    path = tmp_path / "config.yaml"
    path.write_text(text)
    return TrainingConfig.load(path)


@pytest.mark.parametrize("path", sorted(DEFAULT_CONFIG.parent.glob("*.yaml")), ids=lambda path: path.stem)
def test_shipped_files_are_valid_and_name_arguments_of_their_class(tmp_path: Path, path: Path) -> None:
    config = TrainingConfig.load(path)
    assert config.evaluation.seed in VALIDATION and config.evaluation.every_steps <= config.steps
    config.save(tmp_path / "saved.yaml")
    assert TrainingConfig.load(tmp_path / "saved.yaml") == config
    assert config.arguments.keys() <= parameters_of(algorithm_class(config.algorithm)).keys()


def test_a_file_and_changes_keep_all_else() -> None:
    ppo = TrainingConfig.load(config_file("ppo"))
    changed = ppo.changed(seed=5, steps=None, network={"policy": [8]}, arguments={"gamma": 0.5})
    assert changed.network.policy == (8,) and changed.seed == 5 and changed.steps == ppo.steps
    assert changed.network.model_copy(update={"policy": ppo.network.policy}) == ppo.network
    assert changed.arguments == {**ppo.arguments, "gamma": 0.5}


def test_the_command_line_wins_over_the_file() -> None:
    ppo = TrainingConfig.load(config_file("ppo"))
    asked = {"env": "sides", "cohort": "one_sided", "reward": None}
    config, stem = asked_for("ppo", asked, residual_on="prbs", target_discomfort=0.07, steps=12, seed=None)
    assert stem == "ppo-JawSides" and config.env.id == "jawenv/JawSides-v3" and config.steps == 12
    assert config.env.kwargs == {**ppo.env.kwargs, "cohort": "one_sided"}
    assert config.residual == Residual(maneuver="prbs", scale=0.3)
    assert config.comfort is not None and ppo.comfort is not None
    assert config.comfort == ppo.comfort.model_copy(update={"target_discomfort_s": 0.07})
    assert asked_for("ppo", {}) == (ppo, "ppo")


def test_a_limit_on_discomfort_takes_the_place_of_its_price_and_a_file_that_of_another(tmp_path: Path) -> None:
    path = tmp_path / "c.yaml"
    path.write_text("env: {kwargs: {comfort_weight: 60.0, reality: {creep_share: 0.3}}}")
    config, _ = asked_for(str(path), {"reality": {"hysteresis_share": 0.1}}, target_discomfort=0.07)
    assert config.env.kwargs == {"comfort_weight": 0.0, "reality": {"hysteresis_share": 0.1}}
    assert config.comfort is not None and config.residual is None
    with pytest.raises(InputError):
        asked_for(str(path), {}, target_discomfort=0.0)


@pytest.mark.parametrize(
    "text",
    [
        "stepps: 3",
        "arguments: 3",
        "arguments: {gamma: 2020-01-01}",
        "steps: many",
        "steps: -1",
        "network: {activation: sine}",
        "network: {units: [8]}",
        "evaluation: {seed: 12}",
        "evaluation: {seed: 39990, patients: 11}",
        "env: {kwargs: {num_envs: 3}}",
        "env: {kwargs: {model: sides}}",
        "algorithm: 3",
        "ppo: {}",
        "residual: {scale: 1}",
        "comfort: {}\nenv: {kwargs: {comfort_weight: 3}}",
        "comfort: {target_discomfort_s: 0}",
        "[1, 2]",
        "arguments: [",
    ],
)
def test_mistakes_get_one_line_that_names_them(tmp_path: Path, text: str) -> None:
    for read in (TrainingConfig.load, lambda path: asked_for(str(path), {"cohort": "wide"})):
        (tmp_path / "config.yaml").write_text(text)
        with pytest.raises(InputError) as caught:
            read(tmp_path / "config.yaml")
        assert "\n" not in str(caught.value) and "config.yaml" in str(caught.value)
