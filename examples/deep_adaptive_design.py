"""Deep Adaptive Design (Foster et al. 2021) and a policy of RL-BOED (Blau et al. 2022) for the hinge.

    python examples/deep_adaptive_design.py    # trains both in some minutes, and keeps them in runs/boed
    MINE=examples.deep_adaptive_design WORLD="--env JawHinge --control targets --episode-s 3"
    python -m eval compare slow_opening refined $MINE:AtOnce $MINE:DeepAdaptiveDesign $MINE:RLBOED $WORLD

Both maximise sPCE, the contrastive bound on the information that a history tells. The first goes down its gradient
through a model of the reading: the force at the angle that was reached, as eight simulated patients show it. The second
sees no gradient: increments of the bound are rewards (policy gradient, in place of the paper's REDQ).
"""

import argparse
from pathlib import Path

import gymnasium as gym
import numpy as np
import torch
from scipy.optimize import least_squares
from torch import nn

import jawenv
from jawenv.envs.observation import Parts

DECISIONS, RATE, CONTRASTS, PATIENTS = 15, 0.18, 1023, 64  # RATE: of the opening target, each 0.2 s
SIZES, WIDTH, EXPLORES = np.array([0.25, 24.0]), 32, 0.3  # rad and N of an observation's 1
NOISE_N = 0.5  # as far as the model is from the simulator; with the cell's 0.04 N 1,023 contrasts would tell nothing
FOLDER, ENV = Path("runs/boed"), "jawenv/JawHinge-v3"


class Hinge:
    """Force (N) on the mouthpiece at an angle q (rad): g(q) + k(q) F_o exp(b e(q)), cubic g, log k and e."""

    def __init__(self) -> None:
        """Fit the three to simulated patients who open slowly."""
        prior = gym.make(ENV).unwrapped.prior
        self.mean, self.sd = torch.tensor(prior.mean), torch.tensor(prior.sd)
        theta = prior.mean + prior.sd * np.random.default_rng(0).uniform(-2.0, 2.0, (8, 2))
        slow = np.outer(np.linspace(-1.0, 1.0, 60), [1.0, 0.0, 0.0, 0.0])
        made = jawenv.simulate(theta, slow, seed=0, env_id=ENV, env_kwargs={"control": "targets"})
        q, f = made.measured[:, 101::10, 3], -made.samples[:, 100::10, 1, 2]
        rows = torch.tensor(np.repeat(theta, q.shape[1], 0)), torch.tensor(q.ravel())

        def misfit(x: np.ndarray) -> np.ndarray:
            self.curves = torch.tensor(x.reshape(3, 4))
            return (self.force(*rows) - torch.tensor(f.ravel())).numpy()

        start = np.r_[0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0]
        found = least_squares(misfit, start, max_nfev=300)
        self.misfit_N = float(np.sqrt(np.mean(misfit(found.x) ** 2)))
        self.rest, self.far_N = float(np.median(q[:, 0])), float(np.median(f[:, -1]))

    def force(self, theta: torch.Tensor, q: torch.Tensor) -> torch.Tensor:
        """Force of patients (..., 2) at angles (...)."""
        g, log_k, e = (q[..., None] ** torch.arange(4) @ self.curves.T).unbind(-1)
        return g + torch.exp(log_k + theta[..., 0] + torch.exp(theta[..., 1]) * e)

    def reach(self, theta: torch.Tensor) -> torch.Tensor:
        """Angle at which the painless range of patients (N, 2) ends, as their readings have it."""
        grid = torch.linspace(self.rest, 0.3, 200, dtype=torch.float64)
        return grid[(self.force(theta[:, None], grid) < self.far_N).sum(1).clamp(1, 199)]

    def log_density(self, f: torch.Tensor, theta: torch.Tensor, q: torch.Tensor) -> torch.Tensor:
        """Nats of forces at angles, of patients."""
        at = self.force(theta, q)
        return torch.distributions.Normal(at, NOISE_N).log_prob(f)


class Policy(nn.Module):
    """The next opening target, of the sum of what each reading is encoded to: the order does not count."""

    def __init__(self) -> None:
        super().__init__()
        self.encoder = nn.Sequential(nn.Linear(3, WIDTH), nn.Tanh(), nn.Linear(WIDTH, WIDTH))
        self.head = nn.Sequential(nn.Linear(WIDTH + 1, WIDTH), nn.Tanh(), nn.Linear(WIDTH, 1))
        self.double()

    def encoded(self, q: torch.Tensor, f: torch.Tensor, t: int) -> torch.Tensor:
        """Row (N, WIDTH) of a reading, in units of the observation."""
        return self.encoder(torch.stack([q / SIZES[0], f / SIZES[1], torch.full_like(q, t / DECISIONS)], 1))

    def target(self, history: torch.Tensor, t: int) -> torch.Tensor:
        """Opening targets (N,) before they are squashed to -1 ... 1."""
        return self.head(torch.cat([history, torch.full_like(history[:, :1], t / DECISIONS)], 1))[:, 0]


def rollout(policy: Policy, hinge: Hinge, explores: float) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    """The bound after each decision (T, N), nats, log densities of what was chosen (T, N), likelihoods (L + 1, N)."""
    theta = hinge.mean + hinge.sd * torch.randn(PATIENTS, 2, dtype=torch.float64)
    others = hinge.mean + hinge.sd * torch.randn(CONTRASTS, 1, 2, dtype=torch.float64)
    everybody = torch.cat([theta[None], others.expand(-1, PATIENTS, 2)])
    span, x = hinge.reach(theta) - hinge.rest, torch.full((PATIENTS,), -1.0, dtype=torch.float64)
    history, told = torch.zeros(PATIENTS, WIDTH, dtype=torch.float64), torch.zeros(CONTRASTS + 1, PATIENTS)
    bounds, chosen = [], []
    for t in range(DECISIONS):
        law = torch.distributions.Normal(policy.target(history, t), explores or 1.0)
        wanted = law.sample() if explores else law.mean
        chosen.append(law.log_prob(wanted.detach()))
        x = x + (torch.tanh(wanted) - x).clamp(-RATE, RATE)
        q = hinge.rest + 0.5 * (x + 1.0) * span
        at = hinge.force(theta, q)
        f = at + NOISE_N * torch.randn_like(at)
        told = told + hinge.log_density(f, everybody, q)
        bounds.append(told[0] - torch.logsumexp(told, 0) + np.log(CONTRASTS + 1))
        history = history + policy.encoded(q, -f, t + 1)
    return torch.stack(bounds), torch.stack(chosen), told


def trained(hinge: Hinge, by_gradient: bool, updates: int) -> tuple[Policy, float, float]:
    """A policy, and its lower and upper bound on the information, nats, of 512 patients."""
    torch.manual_seed(0)
    policy = Policy()
    optimiser = torch.optim.Adam(policy.parameters(), lr=3e-3)
    for _ in range(updates):
        bounds, chosen, _ = rollout(policy, hinge, 0.0 if by_gradient else EXPLORES)
        gain = bounds[-1].mean()
        if not by_gradient:
            later = (bounds[-1] - torch.cat([torch.zeros_like(bounds[:1]), bounds[:-1]])).detach()
            gain = ((later - later.mean(1, keepdim=True)) / (later.std() + 1e-9) * chosen).mean()
        optimiser.zero_grad()
        (-gain).backward()
        nn.utils.clip_grad_norm_(policy.parameters(), 1.0)
        optimiser.step()
    with torch.no_grad():
        told = torch.cat([rollout(policy, hinge, 0.0)[2] for _ in range(8)], 1)
    lower, upper = jawenv.contrastive_bounds(told.T.numpy())
    return policy, lower.mean(), upper.mean()


class DeepAdaptiveDesign:
    """The trained policy as an agent of the hinge in targets control."""

    name, control, file = "deep adaptive design", "targets", "dad.pt"

    def __init__(self) -> None:
        """Load what the training kept."""
        self.policy = Policy()
        self.policy.load_state_dict(torch.load(FOLDER / self.file, weights_only=True))

    def reset(self, num_envs: int, seed: int | None = None) -> None:
        """Forget the readings."""
        self.history, self.t = torch.zeros(num_envs, WIDTH, dtype=torch.float64), 0

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        """Take the readings in, and choose the opening."""
        layout, rows = Parts(2).layout, np.atleast_2d(observation).astype(float)
        read = np.stack([rows[:, layout["pose"].start + 2], rows[:, layout["force"].start + 2]], 1) * SIZES
        with torch.no_grad():
            if self.t:
                self.history = self.history + self.policy.encoded(*torch.tensor(read).unbind(1), self.t)
            target = torch.tanh(self.policy.target(self.history, self.t))
        self.t += 1
        action = np.zeros((len(rows), 4), np.float32)
        action[:, 0] = target.numpy()
        return action.reshape(*np.shape(observation)[:-1], 4), None


class RLBOED(DeepAdaptiveDesign):
    """The same of the policy that rewards trained."""

    name, file = "RL-BOED", "rlboed.pt"


class AtOnce:
    """Opens as fast and as far as targets control does, which needs no design."""

    name, control = "opening at once", "targets"

    def reset(self, num_envs: int, seed: int | None = None) -> None:
        """Forget nothing."""

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        """The end of the painless range."""
        return np.broadcast_to(np.float32([1.0, 0.0, 0.0, 0.0]), (*np.shape(observation)[:-1], 4)), None


def main() -> None:
    """Train both, and keep their weights."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--updates", type=int, default=400)
    updates = parser.parse_args().updates
    torch.set_num_threads(1)
    hinge = Hinge()
    print(f"model of the reading: {hinge.misfit_N:.2f} N beside the simulator")
    FOLDER.mkdir(parents=True, exist_ok=True)
    for agent, by_gradient in ((DeepAdaptiveDesign, True), (RLBOED, False)):
        policy, lower, upper = trained(hinge, by_gradient, updates)
        torch.save(policy.state_dict(), FOLDER / agent.file)
        print(f"{agent.name}: {lower:.2f} to {upper:.2f} nats", flush=True)


if __name__ == "__main__":
    main()
