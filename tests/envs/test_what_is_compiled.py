"""Which kernels a model's kernels are made of: what nobody asked for is not compiled."""

import gymnasium as gym
import numpy as np

from jawenv.envs.world.bound_kernel import track_bound
from jawenv.envs.world.reset_kernel import begin
from jawenv.envs.world.step_kernel import advance
from jawenv.filter.bound.joint_recursion import predict_covariance
from jawenv.filter.tick import filter_tick
from jawenv.kernels.cache import _function_of, _references


def reached(kernel):
    """The functions that a world kernel is made of, as its digest sees them."""
    seen, pending = set(), [kernel._function]
    while pending:
        function = pending.pop()
        if function not in seen:
            seen.add(function)
            called = (_function_of(value) for _, value in _references(function))
            pending += [each for each in called if each is not None and each.__module__.startswith("jawenv.")]
    return seen


def test_the_filter_is_part_of_one_kernel_and_the_bound_of_its_own():
    parts = {kernel: reached(kernel) for kernel in (begin, advance, track_bound)}
    having_filter = [kernel for kernel, functions in parts.items() if filter_tick.py_func in functions]
    having_bound = [kernel for kernel, functions in parts.items() if predict_covariance.py_func in functions]
    assert having_filter == [advance] and having_bound == [track_bound]


def test_the_bound_is_the_same_with_whatever_is_kept():
    """All ticks of a recorded episode, or those of the last step alone, which come round."""
    bounds = []
    for record in (False, True):
        env = gym.make("jawenv/Jaw-v3", track_bound=True, record=record, episode_s=1.0)
        env.reset(seed=2)
        steps = [env.step(np.array([0.4, 0.3, -0.2, 0.1], dtype=np.float32))[4]["bound_sd"] for _ in range(5)]
        bounds.append(steps)
    np.testing.assert_array_equal(*bounds)
    assert (bounds[0][-1] < bounds[0][0]).all()
