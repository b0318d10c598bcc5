"""The library alone: what it does without the packages of its extras, and what it says where one is needed."""

import subprocess
import sys

BLOCKED = ("matplotlib", "filterpy", "pymunk", "pygame", "yaml", "pandas", "pyarrow", "torch", "stable_baselines3")

PLAYS = """
import gymnasium as gym, numpy as np
import jawenv

class Still:
    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        return np.zeros((len(observation), 4), dtype=np.float32), state

env = gym.make("jawenv/Jaw-v1", episode_s=0.2)
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
    ran = subprocess.run([sys.executable, "-c", blocked + code], capture_output=True, text=True)
    assert ran.returncode == 0, ran.stderr
    return ran.stdout.strip()


def refusal(code: str) -> str:
    """The message of the one-line error that the code raises."""
    lines = "".join(f"    {line}\n" for line in code.splitlines())
    return in_new_process(
        "import gymnasium as gym, jawenv\n"
        f"try:\n{lines}"
        "except jawenv.InputError as error:\n"
        "    assert isinstance(error, ImportError)\n"
        "    print(error)"
    )


def test_the_default_environment_is_played_and_judged() -> None:
    assert in_new_process(PLAYS) == ""


def test_the_jaw_in_contact_names_its_extra_when_it_is_made() -> None:
    message = 'JawSagittal needs pymunk: pip install "jawenv[sagittal]"'
    assert refusal('gym.make("jawenv/JawSagittal-v1")') == message
    assert refusal('gym.make_vec("jawenv/JawSagittal-v1", num_envs=2)') == message
    assert refusal("import jawenv.mechanics.sagittal") == message


def test_pictures_name_their_extra() -> None:
    code = 'env = gym.make("jawenv/Jaw-v1", render_mode="rgb_array")\nenv.reset(seed=0)\nenv.render()'
    assert refusal(code) == 'render_mode needs pygame: pip install "jawenv[render]"'


def test_the_reference_filters_name_their_extra() -> None:
    code = "import jawenv.estimation.references.filterpy_filters"
    assert refusal(code) == 'a reference filter needs filterpy: pip install "jawenv[reference]"'
