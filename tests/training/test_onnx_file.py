"""A policy written as ONNX decides as the policy does, and its file says what goes in and out."""

import json

import gymnasium as gym
import numpy as np
import pytest

from agents import load_agent
from jawenv.envs.observation import OBSERVATION_LAYOUT
from jawenv.playing.policies.card import policy_names
from training.cli import main

pytest.importorskip("onnx")
onnxruntime = pytest.importorskip("onnxruntime")
PARITY = 1e-6


@pytest.mark.parametrize("name", policy_names())
def test_it_decides_as_the_policy(name, tmp_path):
    file = tmp_path / "policy.onnx"
    assert main(["export", name, "--output", str(file)]) == 0
    session = onnxruntime.InferenceSession(file, providers=["CPUExecutionProvider"])
    contract = session.get_modelmeta().custom_metadata_map
    kwargs = json.loads(contract["environment"]) | {"control": "targets", "control_hz": 5.0, "episode_s": 6.0}
    env = gym.make_vec(kwargs.pop("id"), num_envs=4, **kwargs)
    agent = load_agent(name, control="targets")
    agent.reset(4)
    observation, _ = env.reset(seed=1)
    rng = np.random.default_rng(0)
    for step in range(29):
        expected, _ = agent.predict(observation)
        steps = np.full(4, step)
        found = session.run(None, {"observation": observation, "step": steps})[0]
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=PARITY)
        observation = (
            env.step(expected)[0] if step % 2 else rng.uniform(-3.0, 3.0, observation.shape).astype(np.float32)
        )
    assert np.ptp(expected) > 0.1


def test_the_file_says_what_goes_in_and_out(tmp_path):
    file = tmp_path / "policy.onnx"
    assert main(["export", "ppo_trismus", "--output", str(file)]) == 0
    session = onnxruntime.InferenceSession(file, providers=["CPUExecutionProvider"])
    contract = session.get_modelmeta().custom_metadata_map
    parts = json.loads(contract["observation"])
    assert {name: slice(*ends) for name, ends in parts.items()} == OBSERVATION_LAYOUT
    assert contract["decision_hz"] == "5" and "opening, side, fore_aft, roll" in contract["action"]
    shapes = {given.name: given.shape for given in (*session.get_inputs(), *session.get_outputs())}
    assert shapes == {"observation": ["N", 63], "step": ["N"], "action": ["N", 4]}


def test_what_is_no_policy_is_refused(tmp_path, capsys):
    assert main(["export", "slow_opening", "--output", str(tmp_path / "policy.onnx")]) == 2
    assert "policy is 'slow_opening'; allowed: a shipped" in capsys.readouterr().err
    assert main(["export", "ppo_trismus", "--output", str(tmp_path / "policy.onxx")]) == 2
    assert "policy.onxx; allowed: a folder, or a file that ends in .onnx" in capsys.readouterr().err
