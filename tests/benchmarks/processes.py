"""Steps a second that RLlib and TorchRL collect by random actions, on so many processes of Ray.

.. code-block:: sh

    python tests/benchmarks/processes.py 1 2
"""

import argparse
import time
import warnings
from functools import partial

import gymnasium as gym

WORLDS, STEPS, ROUNDS = 32, 64, 8
LOCAL = {"_node_ip_address": "127.0.0.1", "include_dashboard": False, "log_to_driver": False}
MADE = {"episode_s": 3.0}
NAME = "jawenv:jawenv/Jaw-v3"


def torchrl_worlds(seed):
    from torchrl.envs import GymWrapper

    env = GymWrapper(gym.make_vec(NAME, num_envs=WORLDS, autoreset_mode="disabled", **MADE))
    env.set_seed(seed)
    return env


def by_torchrl(processes: int) -> float:
    from torchrl.collectors.distributed import RayCollector

    batch = WORLDS * STEPS * processes
    collector = RayCollector(
        [partial(torchrl_worlds, 1000 * i) for i in range(processes)],
        None,
        frames_per_batch=batch,
        total_frames=ROUNDS * batch,
        sync=True,
        ray_init_config=LOCAL | {"num_cpus": processes},
        remote_configs={"num_cpus": 1, "num_gpus": 0},
    )
    times = [time.perf_counter() for _ in collector]
    return batch * (len(times) - 2) / (times[-1] - times[1])


def by_rllib(processes: int) -> float:
    import ray
    from ray.rllib.algorithms.ppo import PPOConfig

    ray.init(num_cpus=processes + 1, **LOCAL)
    config = PPOConfig().environment(NAME, env_config=MADE)
    config = config.env_runners(
        num_env_runners=processes, num_envs_per_env_runner=WORLDS, gym_env_vectorize_mode="vector_entry_point"
    )
    algorithm = config.build_algo()
    runners = algorithm.env_runner_group
    counts, times = [], []
    for _ in range(ROUNDS):
        sample = partial(_sampled, steps=WORLDS * STEPS)
        counts.append(sum(runners.foreach_env_runner(sample, local_env_runner=False)))
        times.append(time.perf_counter())
    algorithm.stop()
    ray.shutdown()
    return sum(counts[2:]) / (times[-1] - times[1])


def _sampled(runner, steps):
    return sum(len(episode) for episode in runner.sample(num_timesteps=steps, random_actions=True))


def main() -> None:
    parser = argparse.ArgumentParser(description="Steps a second on so many processes.")
    parser.add_argument("processes", type=int, nargs="+")
    warnings.simplefilter("ignore")
    for processes in parser.parse_args().processes:
        import ray

        print(f"{processes}: TorchRL {by_torchrl(processes):,.0f} steps/s", flush=True)
        ray.shutdown()
        print(f"{processes}: RLlib {by_rllib(processes):,.0f} steps/s", flush=True)


if __name__ == "__main__":
    main()
