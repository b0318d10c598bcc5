"""From a run to a policy that can be shared: plain weights and a model card, ``python -m training export RUN``."""

from __future__ import annotations

import hashlib
import json
import zipfile
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from safetensors.numpy import save

import jawenv
from agents.card import (
    CARD,
    FORMAT_VERSION,
    WEIGHTS,
    Architecture,
    CorrectedManeuver,
    Environment,
    ModelCard,
    Result,
    ResultsFile,
)
from agents.checkpoints import read_data
from agents.exported import ExportedPolicy
from agents.policies import TrainedPolicy, load_policy
from agents.residual import Residual, ResidualPolicy
from jawenv.envs.configuration import Configuration, configure
from jawenv.errors import InputError
from jawenv.files import FILE_TYPES, atomic_write, read_mapping, read_model, write_json, write_text
from jawenv.ladder import model_of_env
from jawenv.locks import alone
from training.run.config import EnvConfig, TrainingConfig
from training.run.folder import RunFolder
from training.run.model_card import README, readme
from training.run.network import Network, network_of

if TYPE_CHECKING:
    from stable_baselines3.common.policies import BasePolicy

TOLERANCE = 1e-5
"""By how much an exported policy's action may differ from the run's, which is computed in single precision."""


def export(
    run: RunFolder,
    output: Path,
    *,
    results: Path | None = None,
    licence: str = "MIT",
    command: str = "",
    overwrite: bool = False,
) -> ModelCard:
    """Write the actor of a run's best policy, else its final one, and its model card.

    Args:
        run: the run.
        output: the new folder.
        results: file with what the policy reached, as a list under ``results``.
        licence: under which the weights are given.
        command: how the user asked for it.
        overwrite: replace an exported policy in the folder.

    Returns:
        The card as written.

    Raises:
        InputError: no run or no policy in it, a policy that is no multilayer perceptron, damaged results, or a folder
            that is taken, in use or cannot be written.
    """
    config = run.open()
    reached = () if results is None else read_model(results, ResultsFile).results
    with alone(output):
        _check_free(output, overwrite)
        loaded = load_policy(run.path)
        trained = loaded.agent if isinstance(loaded, ResidualPolicy) else loaded
        assert isinstance(trained, TrainedPolicy)
        network = network_of(trained.policy, str(trained.path))
        weights = save(network.weights)
        card = _card(run, config, network, trained, weights, reached, licence, command)
        _check_same_actions(ExportedPolicy(output.name, card, network.weights), trained.policy, str(trained.path))
        _write(output, weights, card)
        return card


def _card(
    run: RunFolder,
    config: TrainingConfig,
    network: Network,
    trained: TrainedPolicy,
    weights: bytes,
    results: tuple[Result, ...],
    licence: str,
    command: str,
) -> ModelCard:
    return ModelCard(
        format_version=FORMAT_VERSION,
        environment=_environment(config.env),
        observation_size=trained.observation_size,
        architecture=Architecture(layers=network.layers, activation=network.activation, squash=network.squash),
        algorithm=_algorithm(run, config),
        seed=config.seed,
        steps=_steps(trained.path),
        residual=_residual(config.residual, run.path),
        results=results,
        jawenv_version=jawenv.__version__,
        config_sha256=config_sha256(run.config_file),
        weights_sha256=hashlib.sha256(weights).hexdigest(),
        licence=licence,
        date=datetime.now(UTC).date(),
        commands=(*_commands(run), command),
    )


def config_sha256(path: Path) -> str:
    """The hash of a configuration file's content, however it is laid out.

    Raises:
        InputError: no such file, or a damaged one.
    """
    canonical = json.dumps(read_mapping(path), sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(canonical.encode()).hexdigest()


def _environment(env: EnvConfig) -> Environment:
    """Where a run was trained, with the defaults that it left unsaid and the content of the files that it names."""
    model = model_of_env(env.id)
    given = {key: _content(value) for key, value in env.kwargs.items()}
    complete = configure({**given, "model": model.name})
    assert complete.control_hz is not None
    cohort = given.pop("cohort", Configuration.cohort)
    fields = ("control", "control_hz", "sensors", "reward", "episode_s")
    others = {key: value for key, value in given.items() if key not in fields}
    stated: dict[str, Any] = {name: getattr(complete, name) for name in fields}
    return Environment(id=env.id, cohort=cohort, others=others, **stated)


def _content(value: Any) -> Any:
    """What is in a file, if the value is the name of one; else the value."""
    is_file_name = isinstance(value, str) and Path(value).suffix.lower() in FILE_TYPES
    return read_mapping(value) if is_file_name else value


def _residual(setting: Residual | None, folder: Path) -> CorrectedManeuver | None:
    """The maneuver that a run's policies correct, whole."""
    if setting is None:
        return None
    return CorrectedManeuver(maneuver=setting.load_maneuver(folder), scale=setting.scale)


def _algorithm(run: RunFolder, config: TrainingConfig) -> str:
    """What trained a run's policies."""
    if not run.distillation_file.exists():
        return config.algorithm
    distilled = f"distillation of {read_mapping(run.distillation_file).get('planner')}"
    return f"{distilled}, then {config.algorithm}" if len(_commands(run)) > 1 else distilled


def _steps(checkpoint: Path) -> int:
    """Steps that the policy of a checkpoint had learned from."""
    try:
        return int(read_data(checkpoint)["num_timesteps"])
    except InputError:
        raise
    except (OSError, ValueError, KeyError, TypeError, zipfile.BadZipFile) as error:
        raise InputError(f"{checkpoint}: does not say its steps: {' '.join(str(error).split())[:120]}") from None


def _commands(run: RunFolder) -> list[str]:
    """The commands that made a run; none if it does not say."""
    if not run.repeat_file.exists():
        return []
    try:
        return [str(session["command"]) for session in read_mapping(run.repeat_file)["sessions"]]
    except (KeyError, TypeError):
        raise InputError(f"{run.repeat_file} is damaged: sessions must be a list, each with its command") from None


def _check_same_actions(exported: ExportedPolicy, policy: BasePolicy, source: str) -> None:
    """Make sure that nothing of the policy was left behind."""
    stream = np.random.default_rng(0)
    observations = stream.normal(size=(64, exported.card.observation_size)).astype(np.float32)
    wanted = policy.predict(observations, deterministic=True)[0]
    error = float(np.abs(exported.predict(observations)[0] - wanted).max())
    if not error <= TOLERANCE:
        raise InputError(f"{source}: its actions differ by {error:.2g} from those of its layers alone; not exported")


def _check_free(output: Path, overwrite: bool) -> None:
    """Make sure that the folder is new, empty, or an exported policy that may be replaced."""
    try:
        if output.exists() and not output.is_dir():
            raise InputError(f"output {output} is a file; name a folder")
        present = {path.name for path in output.iterdir()} if output.exists() else set()
    except OSError as error:
        raise InputError(f"output {output}: cannot be read: {error.strerror}") from None
    if present - {CARD, WEIGHTS, README}:
        raise InputError(f"output {output} is a folder that holds something other than an exported policy")
    if CARD in present and not overwrite:  # weights alone were left by an export that was stopped
        raise InputError(f"output {output} already holds an exported policy; replace it with --overwrite")


def _write(output: Path, weights: bytes, card: ModelCard) -> None:
    """Write weights and README, then the card: without its card a folder is no policy."""
    try:
        output.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"output {output}: cannot be made: {error.strerror}") from None
    with atomic_write(output / WEIGHTS) as unfinished:
        unfinished.write_bytes(weights)
    write_text(output / README, readme(output.resolve().name, card))
    write_json(output / CARD, card)
