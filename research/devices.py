"""The differentiable twin on a processor and on a graphics card: updates of a policy and plans a second.

An update differentiates an episode of 10 s through the policy, a plan is one of its 60 steps of a clairvoyant. Prints a
table in Markdown:

    python -m research.devices cpu cuda
"""

import argparse
import time
from collections.abc import Callable
from typing import Any

import gymnasium as gym
import torch

import jawenv  # noqa: F401  its environments
from agents.twin.constants import Patients, Twin
from agents.twin.objective import log_worst
from agents.twin.worlds import Worlds

DECISIONS, UPDATES = 50, 60


def episode(simulation, device: torch.device, policy: torch.nn.Module | None) -> Callable[[], None]:
    """An episode of all worlds forth and back: of a policy, or of targets of each world's own."""
    with device:
        twin, patients = Twin(simulation), Patients.of_worlds(simulation.worlds)
        generator = torch.Generator(device).manual_seed(0)
        targets = torch.zeros(DECISIONS, len(patients), 4, dtype=torch.float64, requires_grad=True)

    def play():
        worlds = Worlds(twin, patients, generator if policy else None)
        cost = worlds.discomfort
        for target in targets:
            moved = policy(torch.cat([worlds.belief.mean, worlds.target], -1)) if policy else 0.0
            cost = cost + worlds.step(target + moved)
        (log_worst(worlds) + cost).mean().backward()

    return play


def seconds(play: Callable[[], None], device: torch.device, rounds: int = 3) -> float:
    """Seconds of the quickest of ``rounds`` plays, after an untimed one."""
    times = []
    for _ in range(rounds + 1):
        begin = time.perf_counter()
        play()
        if device.type == "cuda":
            torch.cuda.synchronize(device)
        times.append(time.perf_counter() - begin)
    return min(times[1:])


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description="Time the differentiable twin on devices.")
    parser.add_argument("devices", nargs="*", default=["cpu"])
    parser.add_argument("--patients", type=int, nargs="+", default=[96, 1024, 4096])
    options = parser.parse_args()
    print("| device | patients | s an update | episodes a second | plans a second |\n|---|--:|--:|--:|--:|", flush=True)
    for patients in options.patients:
        env = gym.make_vec("jawenv/Jaw-v3", patients, cohort="one_sided", control="targets", episode_s=10.0)
        env.reset(seed=0)
        worlds: Any = env.unwrapped
        for name in options.devices:
            device = torch.device(name)
            policy = torch.nn.Sequential(torch.nn.Linear(16, 64), torch.nn.Tanh(), torch.nn.Linear(64, 4))
            policy = policy.double().to(device)
            update = seconds(episode(worlds.simulation, device, policy), device)
            step = seconds(episode(worlds.simulation, device, None), device)
            plans = patients / (UPDATES * step)
            print(f"| {name} | {patients} | {update:.2f} | {patients / update:.0f} | {plans:.1f} |", flush=True)


if __name__ == "__main__":
    main()
