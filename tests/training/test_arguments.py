"""Classes of algorithms by name, those of one's own too, and their arguments."""

import pytest
from point_env import PointVectorEnv
from stable_baselines3 import PPO

from jawenv.base.errors import InputError
from jawenv.sb3 import NativeVecEnv
from training.run.algorithms import make_model
from training.run.config import TrainingConfig

NUMBER = 3.0


class Doubled(PPO):
    """A learner of the user's own."""

    def __init__(self, *given: object, factor: float = 1.0, **arguments: object) -> None:
        super().__init__(*given, **arguments)  # type: ignore[arg-type]
        self.factor = factor


def test_a_class_of_ones_own_gets_its_arguments_and_those_of_its_base() -> None:
    wanted = TrainingConfig(
        algorithm="test_arguments:Doubled",
        arguments={"factor": 2.0, "n_steps": 16, "clip_range": {"initial": 0.3, "final": 0.1}},
    )
    model = make_model(wanted, NativeVecEnv(PointVectorEnv(8, "same_step")))
    assert type(model).__name__ == "Doubled" and (model.factor, model.n_steps) == (2.0, 16)  # type: ignore[attr-defined]
    assert [model.clip_range(left) for left in (1.0, 0.5)] == pytest.approx([0.3, 0.2])  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("values", "told"),
    [
        ({"algorithm": "DQN"}, "algorithm DQN: cannot be made: AssertionError"),
        ({"algorithm": "ppq"}, "algorithm is 'ppq'; allowed: A2C, APG, "),
        ({"algorithm": "test_arguments:NUMBER"}, "allowed: a subclass of OnPolicyAlgorithm"),
        ({"algorithm": "no_such:Learner"}, "no module 'no_such'"),
        (
            {"arguments": {"gama": 0.9}},
            "key of arguments, of PPO, is 'gama'; did you mean gamma? allowed: learning_rate",
        ),
        ({"arguments": {"device": "cpu"}}, "is 'device'"),
        ({"arguments": {"gamma": "high"}}, "arguments.gamma is 'high'; allowed: a number"),
        ({"arguments": {"n_epochs": 1.5}}, "arguments.n_epochs is 1.5; allowed: an integer"),
        ({"arguments": {"use_sde": 1}}, "arguments.use_sde is 1; allowed: true or false"),
        ({"arguments": {"learning_rate": {"start": 1.0}}}, "arguments.learning_rate: unknown key 'start'"),
        ({"arguments": {"batch_size": 1000}}, "allowed: a multiple of arguments.batch_size, 1000"),
        ({"arguments": {"policy_kwargs": {"colour": 1}}}, "algorithm PPO: cannot be made: TypeError"),
        ({"algorithm": "SAC", "network": {"final_log_std": -1.0}}, "network.final_log_std is -1.0; allowed: null"),
        ({"network": {"features": "test_arguments:nothing"}}, "has no 'nothing'"),
        ({"network": {"features": "numpy:sum"}}, "network.features 'numpy:sum'"),
    ],
)
def test_unusable_algorithms_and_arguments_get_one_line(values: dict, told: str) -> None:
    with pytest.raises(InputError) as caught:
        make_model(TrainingConfig(**values), NativeVecEnv(PointVectorEnv(8, "same_step")))
    assert told in str(caught.value) and "\n" not in str(caught.value)
