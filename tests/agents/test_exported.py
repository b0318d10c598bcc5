"""Exported policies: played in NumPy alone, and refused in one line if card, weights and environment do not fit."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from exported_folder import LAYERS, fields, random_weights, write_exported
from safetensors.numpy import save

import agents
import jawenv
from agents.exported import ExportedPolicy, elu, load_exported
from jawenv.envs.observation import OBSERVATION_SIZE
from jawenv.errors import InputError
from jawenv.playing.maneuvers import Maneuver, Player
from jawenv.playing.protocol import Agent


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return write_exported(tmp_path / "shared")


def refusal(path: Path, **kwargs: str) -> str:
    with pytest.raises(InputError) as caught:
        load_exported(path, **kwargs)
    message = str(caught.value)
    assert "\n" not in message and path.name in message
    return message


def test_it_computes_the_layers_of_the_card(folder: Path) -> None:
    agent = agents.load_agent(folder, control="trajectory")
    assert isinstance(agent, ExportedPolicy) and isinstance(agent, Agent) and agent.name == "shared"
    observation = np.random.default_rng(0).normal(size=(6, OBSERVATION_SIZE)).astype(np.float32)
    weights = random_weights()
    hidden = np.tanh(observation @ weights["layers.0.weight"].T + weights["layers.0.bias"])
    expected = np.clip(hidden @ weights["layers.1.weight"].T + weights["layers.1.bias"], -1.0, 1.0)
    agent.reset(6, seed=0)
    action, state = agent.predict(observation)
    assert action.dtype == np.float32 and state is None
    np.testing.assert_allclose(action, expected, atol=1e-5)
    assert 0 < (np.abs(action) == 1.0).sum() < action.size  # clipped, but not everywhere
    np.testing.assert_array_equal(agent.predict(observation[2])[0], action[2])


def test_the_card_itself_stands_for_its_folder(folder: Path) -> None:
    assert agents.load_agent(str(folder / "card.json"), control="trajectory").name == "shared"


def test_elu_goes_on_smoothly_below_zero() -> None:
    np.testing.assert_allclose(elu(np.array([-1000.0, -1e-9, 0.0, 2.0])), [-1.0, -1e-9, 0.0, 2.0], atol=1e-15)


def test_neither_torch_nor_pickle_is_needed(folder: Path) -> None:
    code = (
        "import agents, numpy, pickle, sys\n"
        "del pickle.loads, pickle.load, pickle.Unpickler\n"
        f"agent = agents.load_agent({str(folder)!r}, control='trajectory')\n"
        f"assert agent.predict(numpy.zeros({OBSERVATION_SIZE}, dtype='f4'))[0].shape == (4,)\n"
        "assert not {'torch', 'stable_baselines3'} & set(sys.modules)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=Path(agents.__file__).parents[1], capture_output=True)
    assert done.returncode == 0, done.stderr.decode()


def test_a_card_without_weights_is_named(folder: Path) -> None:
    (folder / "policy.safetensors").unlink()
    assert "policy.safetensors: no such file, but a card without its weights" in refusal(folder)


def test_other_weights_than_the_cards_are_named(folder: Path) -> None:
    (folder / "policy.safetensors").write_bytes(save(random_weights() | {"layers.1.bias": np.ones(4, np.float32)}))
    assert "the card's weights_sha256 is" in refusal(folder)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"layers.0.bias": np.zeros(6, np.float32)}, "layers.0.bias has shape (6,) and type float32"),
        ({"layers.0.bias": np.zeros(5)}, "asks for (5,) and float32"),
        ({"layers.2.bias": np.zeros(4, np.float32)}, "layers.2.bias is in the weights or in the card's"),
        ({"layers.1.bias": np.full(4, np.nan, np.float32)}, "layers.1.bias holds a value that is not finite"),
    ],
)
def test_weights_that_do_not_fit_the_card_are_named(tmp_path: Path, changed: dict, message: str) -> None:
    path = write_exported(tmp_path / "odd", random_weights() | changed)
    assert message in refusal(path)


def test_a_policy_of_another_environment_is_refused(folder: Path, tmp_path: Path) -> None:
    assert "trained in jawenv/Jaw-v2, not in jawenv/JawBilateral-v2" in refusal(folder, env_id="bilateral")
    layers = (9, 5, 4)
    architecture = {"layers": layers, "activation": "relu", "squash": "tanh"}
    small = write_exported(tmp_path / "small", random_weights(layers), observation_size=9, architecture=architecture)
    assert f"observations of 9 values, jawenv/Jaw-v2 gives {OBSERVATION_SIZE}" in refusal(small)


def test_a_policy_on_a_maneuver_corrects_it(tmp_path: Path) -> None:
    """Without weights it is the maneuver, as its player plays it in targets control."""
    layers = (OBSERVATION_SIZE + 12, *LAYERS[1:])
    folder = write_exported(
        tmp_path / "corrects",
        {name: np.zeros_like(values) for name, values in random_weights(layers).items()},
        observation_size=layers[0],
        architecture={"layers": layers, "activation": "relu", "squash": "tanh"},
        residual={"maneuver": Maneuver.named("chirp"), "scale": 0.2},
        environment=fields()["environment"] | {"control": "targets"},
    )
    agent, player = load_exported(folder), Player("chirp", control="targets", control_hz=10.0)
    observation = np.zeros((2, OBSERVATION_SIZE), dtype=np.float32)
    for _ in range(20):
        np.testing.assert_allclose(agent.predict(observation)[0], player.predict(observation)[0], atol=1e-6)
    with pytest.raises(InputError):
        agent.predict(np.zeros((2, 4), dtype=np.float32))


def test_a_policy_of_the_motors_keeps_the_control_of_its_card(folder: Path) -> None:
    agent = agents.load_agent(folder, control="trajectory")
    assert agent.control == "trajectory"  # type: ignore[attr-defined]
    with pytest.raises(InputError):
        agents.load_agent(folder)
    with pytest.raises(InputError):
        jawenv.play(agent, patients=1, seed=0, env_kwargs={"control": "force"})
