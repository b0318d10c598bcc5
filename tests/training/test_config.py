"""The settings of a run: defaults, files, and what is said about mistakes in them."""

from pathlib import Path

import pytest

from jawenv.errors import InputError
from jawenv.seeds import VALIDATION
from training.config import DEFAULT_CONFIG, TrainingConfig


def load(tmp_path: Path, text: str) -> TrainingConfig:
    path = tmp_path / "config.yaml"
    path.write_text(text)
    return TrainingConfig.load(path)


def test_default_file_spells_out_every_default() -> None:
    assert TrainingConfig.load(DEFAULT_CONFIG) == TrainingConfig()


@pytest.mark.parametrize("path", sorted(DEFAULT_CONFIG.parent.glob("*.yaml")), ids=lambda path: path.stem)
def test_shipped_files_are_valid_and_keep_cohorts_apart(path: Path) -> None:
    config = TrainingConfig.load(path)
    assert config.evaluation.seed in VALIDATION
    assert config.n_envs * config.ppo.n_steps <= config.steps


def test_saved_settings_are_read_back(tmp_path: Path) -> None:
    config = TrainingConfig().changed(seed=5, n_envs=256, steps=None)
    config.save(tmp_path / "saved.yaml")
    assert TrainingConfig.load(tmp_path / "saved.yaml") == config
    assert config.seed == 5 and config.steps == TrainingConfig().steps


def test_partial_file_keeps_the_other_defaults(tmp_path: Path) -> None:
    config = load(tmp_path, "ppo: {gamma: 0.9, learning_rate: {initial: 1e-3}}")
    assert config.ppo.gamma == 0.9 and config.ppo.learning_rate.initial == 1e-3
    assert config.ppo.n_epochs == TrainingConfig().ppo.n_epochs


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("stepps: 3", r"unknown key 'stepps'; allowed: algorithm, seed, steps"),
        ("ppo: {learning_rate: {start: 1}}", r"key 'ppo.learning_rate.start'; allowed: initial, final"),
        ("ppo: {gamma: 1.5}", r"ppo.gamma = 1.5 must be less than or equal to 1"),
        ("ppo: {gamma: .nan}", r"ppo.gamma = nan"),
        ("steps: many", r"steps = 'many' must be a valid integer"),
        ("steps: -1", r"steps = -1 must be greater than 0"),
        (
            "ppo: {network: {activation: sine}}",
            r"activation = 'sine' must be 'tanh', 'relu' or 'elu'",
        ),
        ("ppo: {batch_size: 1000}", r"steps per update must be a multiple of ppo.batch_size 1000"),
        ("evaluation: {seed: 12}", r"evaluation.seed = 12 must be greater than or equal to 30000"),
        (
            "evaluation: {seed: 39990, patients: 11}",
            r"evaluation: seed 39990 and 11 patients end at 40000, allowed: 39999",
        ),
        ("env: {kwargs: {num_envs: 3}}", r"env: 'num_envs' is set by the training itself"),
        ("env: {kwargs: {model: sides}}", r"env: 'model' follows from env.id"),
        ("algorithm: sac", r"algorithm = 'sac' must be 'ppo'"),
        ("[1, 2]", r"must hold a mapping of keys to values, not a list"),
        ("ppo: [", r"damaged YAML: .*line 1"),
    ],
)
def test_mistakes_get_one_line_that_names_them(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(InputError, match=message) as caught:
        load(tmp_path, text)
    assert "\n" not in str(caught.value)
    assert "config.yaml" in str(caught.value)


def test_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"nowhere.yaml: no such file"):
        TrainingConfig.load(tmp_path / "nowhere.yaml")
