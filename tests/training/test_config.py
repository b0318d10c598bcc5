"""The settings of a run: defaults, files, and what is said about mistakes in them."""

from pathlib import Path

import pytest

from agents.residual import Residual
from jawenv.errors import InputError
from jawenv.seeds import VALIDATION
from training.run.config import DEFAULT_CONFIG, TrainingConfig, config_file


def load(tmp_path: Path, text: str) -> TrainingConfig:
    path = tmp_path / "config.yaml"
    path.write_text(text)
    return TrainingConfig.load(path)


def test_default_file_spells_out_every_default() -> None:
    """It moves the jaw by motors, and in all else by default."""
    assert TrainingConfig.load(DEFAULT_CONFIG) == TrainingConfig().with_env_kwargs(control="force")


@pytest.mark.parametrize("path", sorted(DEFAULT_CONFIG.parent.glob("*.yaml")), ids=lambda path: path.stem)
def test_shipped_files_are_valid_and_keep_cohorts_apart(path: Path) -> None:
    config = TrainingConfig.load(path)
    assert config.evaluation.seed in VALIDATION
    assert config.evaluation.every_steps <= config.steps
    assert config.section is getattr(config, config.algorithm)


def test_saved_settings_are_read_back(tmp_path: Path) -> None:
    config = TrainingConfig().changed(seed=5, n_envs=256, steps=None)
    config.save(tmp_path / "saved.yaml")
    assert TrainingConfig.load(tmp_path / "saved.yaml") == config
    assert config.seed == 5 and config.steps == TrainingConfig().steps


@pytest.mark.parametrize("path", sorted(DEFAULT_CONFIG.parent.glob("*.yaml")), ids=lambda path: path.stem)
def test_saved_settings_hold_the_section_of_their_algorithm_alone(tmp_path: Path, path: Path) -> None:
    config = TrainingConfig.load(path)
    config.save(tmp_path / "saved.yaml")
    assert TrainingConfig.load(tmp_path / "saved.yaml") == config
    assert [name for name in ("ppo", "recurrent_ppo", "sac", "tqc") if name in config.as_mapping()] == [
        config.algorithm
    ]


def test_a_residual_on_another_maneuver_keeps_its_scale() -> None:
    sac = TrainingConfig.load(config_file("sac")).changed(residual={"maneuver": "chirp", "scale": 0.3})
    assert sac.on_maneuver("prbs").residual == Residual(maneuver="prbs", scale=0.3)


def test_partial_file_keeps_the_other_defaults(tmp_path: Path) -> None:
    config = load(tmp_path, "ppo: {gamma: 0.9, learning_rate: {initial: 1e-3}}")
    assert config.ppo.gamma == 0.9 and config.ppo.learning_rate.initial == 1e-3
    assert config.ppo.n_epochs == TrainingConfig().ppo.n_epochs


@pytest.mark.parametrize(
    "text",
    [
        "stepps: 3",
        "ppo: {learning_rate: {start: 1}}",
        "ppo: {gamma: 1.5}",
        "ppo: {gamma: .nan}",
        "steps: many",
        "steps: -1",
        "ppo: {network: {activation: sine}}",
        "ppo: {batch_size: 1000}",
        "evaluation: {seed: 12}",
        "evaluation: {seed: 39990, patients: 11}",
        "env: {kwargs: {num_envs: 3}}",
        "env: {kwargs: {model: sides}}",
        "algorithm: dqn",
        "algorithm: sac\nppo: {}",
        "algorithm: sac\nsac: {gamma: 2}",
        "algorithm: tqc\ntqc: {units: 2}",
        "residual: {scale: 1}",
        "comfort: {}\nenv: {kwargs: {comfort_weight: 3}}",
        "comfort: {target_discomfort_s: 0}",
        "[1, 2]",
        "ppo: [",
    ],
)
def test_mistakes_get_one_line_that_names_them(tmp_path: Path, text: str) -> None:
    with pytest.raises(InputError) as caught:
        load(tmp_path, text)
    assert "\n" not in str(caught.value)
    assert "config.yaml" in str(caught.value)


def test_arguments_of_the_environment_that_are_none_stay() -> None:
    config = TrainingConfig.load(config_file("ppo"))
    changed = config.with_env_kwargs(cohort="one_sided", reward=None)
    assert changed.env.kwargs == {**config.env.kwargs, "cohort": "one_sided"}
    assert config.with_env_kwargs(cohort=None) == config


def test_a_limit_on_discomfort_takes_the_place_of_its_price() -> None:
    plain = TrainingConfig(env={"kwargs": {"comfort_weight": 60.0, "control": "targets"}})
    limited = plain.within_discomfort(0.07)
    assert limited.comfort is not None and limited.comfort.target_discomfort_s == 0.07
    assert limited.env.kwargs == {"comfort_weight": 0.0, "control": "targets"}
    again = limited.changed(comfort={"target_discomfort_s": 0.1, "initial_multiplier": 3.0}).within_discomfort(0.05)
    assert again.comfort is not None and (again.comfort.target_discomfort_s, again.comfort.initial_multiplier) == (
        0.05,
        3.0,
    )
    with pytest.raises(InputError):
        plain.within_discomfort(0.0)
