"""A neural posterior of a hinge's two parameters by sbi, trained on simulations, and whether it is calibrated.

    .ci/setup sbi
    python examples/sbi_posterior.py --simulations 1000

The jaw is opened and closed in force control. Patients who cannot be treated are rows of NaN, which training and
diagnostics of sbi leave out with a warning. A calibrated posterior has p-values above 0.05 and covers as it says. After
these two minutes of a core it is not yet: its ranks are not uniform.
"""

import argparse
import sys
import tempfile

import numpy as np
import torch
from sbi.diagnostics import run_sbc, run_tarp
from sbi.inference import NPE
from sbi.utils.tracking import TensorBoardTracker
from scipy.stats import kstest
from torch.utils.tensorboard import SummaryWriter

import jawenv
from jawenv.ladder import model_named

ENV = "jawenv/JawHinge-v3"
MOVING = [0, 2, 3, 6, 8, 10]  # mouthpiece forward and up, pitch, and their rates
COMPONENTS, DRAWS = 8, 500
COHORT = jawenv.cohort("wide", model_named("hinge").muscles)


def simulated(patients: int, seed: int) -> tuple[torch.Tensor, torch.Tensor]:
    """Log-parameters (n, 2) of a cohort, and readings averaged over 0.1 s (n, 240); NaN of the untreatable."""
    theta, time = COHORT.sample(patients, seed), np.arange(1, 81) / 20
    actions = np.outer(0.5 * np.sin(0.5 * np.pi * time) ** 2, [1.0, 1.0, 0.0, 0.0])
    made = jawenv.simulate(theta, actions, seed, env_id=ENV, env_kwargs={"control": "force"})
    means = made.measured[:, 1:, MOVING].reshape(patients, -1, 10, len(MOVING)).mean(axis=2)
    return torch.tensor(theta, dtype=torch.float32), torch.tensor(means.reshape(patients, -1), dtype=torch.float32)


def main() -> None:
    """Read the command line, train and judge."""
    parser = argparse.ArgumentParser(description="Train a neural posterior on simulations, and judge it.")
    parser.add_argument("--simulations", type=int, default=1000)
    parser.add_argument("--tests", type=int, default=300, help="other patients, for the diagnostics")
    parser.add_argument("--epochs", type=int, default=100, help="at most")
    given = parser.parse_args()
    for name, least in (("simulations", 100), ("tests", 100), ("epochs", 1)):
        if getattr(given, name) < least:
            raise jawenv.InputError(f"{name} is {getattr(given, name)}; allowed: {least} or more")
    torch.manual_seed(0)
    theta, x = simulated(given.simulations, seed=0)
    treated = x[torch.isfinite(x).all(dim=1)]
    middle, spread = treated.mean(dim=0), treated.std(dim=0)
    axes = torch.linalg.svd((treated - middle) / spread, full_matrices=False)[2][:COMPONENTS].T
    log = TensorBoardTracker(SummaryWriter(tempfile.mkdtemp()))
    trainer = NPE(tracker=log, show_progress_bars=False)
    trainer.append_simulations(theta, (x - middle) / spread @ axes).train(max_num_epochs=given.epochs)
    mean, cov = (torch.tensor(v, dtype=torch.float32) for v in (COHORT.mean[0], np.diag(COHORT.sd[0] ** 2)))
    posterior = trainer.build_posterior(prior=torch.distributions.MultivariateNormal(mean, cov))

    theta, x = simulated(given.tests, seed=1_000_000)
    tests = theta, (x - middle) / spread @ axes, posterior
    ranks, _ = run_sbc(*tests, num_posterior_samples=DRAWS, show_progress_bar=False)
    coverage, level = run_tarp(*tests, num_posterior_samples=DRAWS, show_progress_bar=False)
    print(f"{len(ranks)} of {given.tests} patients can be treated")
    print("uniform ranks, p-values:", *(f"{kstest(row / DRAWS, 'uniform').pvalue:.3f}" for row in ranks.numpy().T))
    for wanted in (0.5, 0.8, 0.95):
        print(f"coverage of {wanted:.0%}: {np.interp(wanted, level, coverage):.0%}")


if __name__ == "__main__":
    try:
        main()
    except jawenv.InputError as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(2)
