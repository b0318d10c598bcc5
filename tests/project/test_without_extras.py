"""The library alone: what it does without the packages of its extras, and what it says where one is needed."""

import json

from tests.processes import python

BLOCKED = (
    "matplotlib",
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
    return python("-c", blocked + code).stdout.strip()


PICTURE = 'env = gym.make("jawenv/Jaw-v3", render_mode="rgb_array")\nenv.reset(seed=0)\nenv.render()'
REFUSED = {
    'gym.make("jawenv/JawSagittal-v3")': 'JawSagittal needs pymunk: pip install "jawenv[sagittal]"',
    'gym.make_vec("jawenv/JawSagittal-v3", num_envs=2)': 'JawSagittal needs pymunk: pip install "jawenv[sagittal]"',
    "import jawenv.mechanics.sagittal": 'JawSagittal needs pymunk: pip install "jawenv[sagittal]"',
    "import jawenv.mechanics.mujoco_jaw": 'MujocoJaw needs mujoco: pip install "jawenv[mujoco]"',
    PICTURE: 'render_mode needs pygame: pip install "jawenv[render]"',
    "import jawenv.sb3": 'jawenv.sb3 needs stable_baselines3: pip install "jawenv[sb3]"',
}
REFUSALS = """
import json
import gymnasium as gym, jawenv
told = {}
for code in %r:
    try:
        exec(code, {"gym": gym})
    except jawenv.InputError as error:
        assert isinstance(error, ImportError)
        told[code] = str(error)
print(json.dumps(told))
"""


def test_the_default_environment_is_played_and_judged() -> None:
    assert in_new_process(PLAYS) == ""


def test_what_needs_an_extra_names_it() -> None:
    assert json.loads(in_new_process(REFUSALS % [*REFUSED])) == REFUSED
