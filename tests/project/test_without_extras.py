"""The library alone: what it does without the packages of its extras, and what it says where one is needed."""

import json
import subprocess
import sys

import pytest

BLOCKED = (
    "matplotlib",
    "filterpy",
    "pymunk",
    "mujoco",
    "pygame",
    "yaml",
    "pandas",
    "pyarrow",
    "torch",
    "viser",
    "ezc3d",
    "h5py",
    "stable_baselines3",
)

PLAYS = """
import gymnasium as gym, numpy as np
import jawenv

class Still:
    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        return np.zeros((len(observation), 4), dtype=np.float32), state

env = gym.make("jawenv/Jaw-v3", episode_s=0.2)
env.reset(seed=0)
ended = False
while not ended:
    *_, ended, info = env.step(env.action_space.sample())
played = jawenv.play(Still(), patients=2, seed=0, env_kwargs={"episode_s": 1.2, "record": True})
jawenv.score(played), jawenv.identifiability(played.records[0]), jawenv.bound_along(played.records[0])
"""


def in_new_process(code: str) -> str:
    """What the code prints where the packages cannot be imported."""
    blocked = f"import sys; sys.modules.update(dict.fromkeys({BLOCKED!r}))\n"
    ran = subprocess.run([sys.executable, "-c", blocked + code], capture_output=True, text=True, timeout=600)
    assert ran.returncode == 0, ran.stderr
    return ran.stdout.strip()


REFUSED = {
    "contact": 'gym.make("jawenv/JawSagittal-v3")',
    "contact, several worlds": 'gym.make_vec("jawenv/JawSagittal-v3", num_envs=2)',
    "contact, mechanics": "import jawenv.mechanics.sagittal",
    "MuJoCo": 'gym.make("jawenv/Jaw-v3", plant="jawenv.mechanics.mujoco_jaw:MujocoJaw")',
    "pictures": 'env = gym.make("jawenv/Jaw-v3", render_mode="rgb_array")\nenv.reset(seed=0)\nenv.render()',
    "stable-baselines3": "import jawenv.sb3",
    "filters": "import jawenv.references.filterpy_filters",
}
REFUSALS = f"""
import json
import gymnasium as gym, jawenv
told = {{}}
for name, code in {REFUSED!r}.items():
    try:
        exec(code, {{"gym": gym}})
    except jawenv.InputError as error:
        assert isinstance(error, ImportError)
        told[name] = str(error)
print(json.dumps(told))
"""


@pytest.fixture(scope="module")
def told() -> dict[str, str]:
    """The messages of the one-line errors that the codes of ``REFUSED`` raise, one after the other in one process."""
    messages: dict[str, str] = json.loads(in_new_process(REFUSALS))
    return messages


def test_the_default_environment_is_played_and_judged() -> None:
    assert in_new_process(PLAYS) == ""


@pytest.mark.parametrize(
    ("code", "message"),
    [
        ("contact", 'JawSagittal needs pymunk: pip install "jawenv[sagittal]"'),
        ("contact, several worlds", 'JawSagittal needs pymunk: pip install "jawenv[sagittal]"'),
        ("contact, mechanics", 'JawSagittal needs pymunk: pip install "jawenv[sagittal]"'),
        ("MuJoCo", 'MujocoJaw needs mujoco: pip install "jawenv[mujoco]"'),
        ("pictures", 'render_mode needs pygame: pip install "jawenv[render]"'),
        ("stable-baselines3", 'jawenv.sb3 needs stable_baselines3: pip install "jawenv[sb3]"'),
        ("filters", 'a reference filter needs filterpy: pip install "jawenv[reference]"'),
    ],
)
def test_what_needs_an_extra_names_it(told: dict[str, str], code: str, message: str) -> None:
    assert told[code] == message
