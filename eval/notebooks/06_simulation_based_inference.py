# ---
# jupyter:
#   jupytext:
#     formats: ipynb,py:percent
#     text_representation:
#       extension: .py
#       format_name: percent
#       format_version: '1.3'
#       jupytext_version: 1.19.6
#   kernelspec:
#     display_name: Python 3
#     language: python
#     name: python3
# ---

# %% [markdown]
# # A neural posterior
#
# Three ways from one recording to the posterior of a hinge's two parameters: a neural estimator that has only seen
# simulations (NPE, of the package [sbi](https://sbi.readthedocs.io)), importance sampling with the likelihood, and
# the environment's filter. sbi comes with `.ci/setup sbi`; without it the neural one is left out.

# %%
import os

import numpy as np

import jawenv

QUICK = bool(os.environ.get("JAWENV_NOTEBOOK_QUICK"))
ENV = "jawenv/JawHinge-v3"
ROUNDS, SIMULATIONS, DRAWS, SAMPLES = (2, 100, 200, 50) if QUICK else (3, 1000, 2000, 400)

# %% [markdown]
# ## Prior, design and recording
#
# `PatientLaw` is the prior: the law of the patients whom the environment draws. In 4 s the design opens the jaw
# twice.
#
# The network sees the same design in all simulations, and so knows the motors' forces better than a load cell that
# reads them 1 % wrongly. For the same knowledge on all sides the load cell has no gain error here (`cell_gain`).

# %%
law = jawenv.PatientLaw.of("trismus", env_id=ENV, draws=1000)
seconds = np.arange(1, 81) / 20
design = np.outer(0.5 * np.sin(0.5 * np.pi * seconds) ** 2, [1.0, 1.0, 0.0, 0.0])
kwargs = {"control": "force", "device": {"cell_gain": 0.0}}


def simulate(theta, seed):
    return jawenv.simulate(theta, design, seed, env_id=ENV, env_kwargs=kwargs)


truth = law.sample(1, seed=7)
observed = simulate(truth, seed=1_000_000)
record = observed.records[0]

# %% [markdown]
# ## The neural posterior
#
# A reading every 10 ms of six encoders that move is 2,400 numbers. They are averaged over 0.1 s, projected onto 40
# principal components, and regressed on the parameters: two numbers, as in semi-automatic ABC (Fearnhead & Prangle
# 2012), beside the first four components. A normalising flow learns the parameters' law given these.
#
# The posterior is a hundred times narrower than the prior, so there are rounds: each simulates from the prior within
# a box about what the last one has found (truncated sequential estimation; Deistler et al. 2022), and trains anew.

# %%
import tempfile

from scipy.stats import truncnorm

try:
    import torch
    from sbi.inference import NPE
    from sbi.utils.tracking import TensorBoardTracker
    from torch.utils.tensorboard import SummaryWriter
except ModuleNotFoundError:
    NPE = None
    print("no sbi here: .ci/setup sbi")

MOVING = [0, 2, 3, 6, 8, 10]  # mouthpiece forward and up, pitch, and their rates


def averages(made):
    readings = made.measured[:, 1:, MOVING] / record.measurement_sd[MOVING]
    n, ticks, channels = readings.shape
    return readings.reshape(n, ticks // 10, 10, channels).mean(axis=2).reshape(n, -1)


def summary(x, theta):
    """A function from averages to six numbers, learned from simulations."""
    middle = x.mean(axis=0)
    _, size, axes = np.linalg.svd(x - middle, full_matrices=False)
    axes = axes[:40] / size[:40, None] * np.sqrt(len(x))
    with_one = np.column_stack([np.ones(len(x)), (x - middle) @ axes.T])
    weights = np.linalg.lstsq(with_one, (theta - theta.mean(axis=0)) / theta.std(axis=0), rcond=None)[0]

    def summarise(values):
        components = (values - middle) @ axes.T
        regressed = np.column_stack([np.ones(len(values)), components]) @ weights
        return torch.tensor(np.column_stack([regressed, components[:, :4]]), dtype=torch.float32)

    return summarise


def _neural_posterior(seed):
    """Draws of the posterior (DRAWS, 2)."""
    torch.manual_seed(seed)
    rng = np.random.default_rng(seed)
    median, sd = law.cohort.mean[0], law.cohort.sd[0]
    low, high = median - 2 * sd, median + 2 * sd  # where the cohort ends
    for number in range(ROUNDS):
        ends = (low - median) / sd, (high - median) / sd
        theta = median + sd * truncnorm.rvs(*ends, size=(SIMULATIONS, 2), random_state=rng)
        made = simulate(theta, seed=10_000 * (number + 1))
        usable = made.treatable & np.isfinite(made.measured).all(axis=(1, 2))
        theta, x = theta[usable], averages(made)[usable]
        summarise, middle, spread = summary(x, theta), theta.mean(axis=0), theta.std(axis=0)
        log = TensorBoardTracker(SummaryWriter(tempfile.mkdtemp()))
        trainer = NPE(prior=None, tracker=log, show_progress_bars=False)
        trainer.append_simulations(torch.tensor((theta - middle) / spread, dtype=torch.float32), summarise(x))
        flow = trainer.train(max_num_epochs=20 if QUICK else 500)
        drawn = flow.sample((DRAWS,), condition=summarise(averages(observed))).detach().numpy().reshape(-1, 2)
        draws = middle + spread * drawn
        pad = 0.25 * np.ptp(draws, axis=0)
        low, high = np.maximum(low, draws.min(axis=0) - pad), np.minimum(high, draws.max(axis=0) + pad)
        print(f" round {number + 1}: sds {100 * draws.std(axis=0).round(4)} %")
    return draws


draws = None if NPE is None else _neural_posterior(0)

# %% [markdown]
# ## The likelihood, and the filter

# %%
import pandas as pd

from examples.importance_posterior import divergence, importance_posterior
from jawenv.recordings.record_filter import TensionFilter

belief = TensionFilter().estimate(record)
believed = belief.mean[-1], belief.cov[-1]
exact = importance_posterior(record, *believed, SAMPLES, np.random.default_rng(0))[:2]
posteriors = {"importance sampling": exact, "filter": believed}
if draws is not None:
    posteriors["neural (NPE)"] = draws.mean(axis=0), np.cov(draws.T)
pd.DataFrame(
    {
        name: {
            "F_o, N": np.exp(mean[0]),
            "b": np.exp(mean[1]),
            "sd of F_o, %": 100 * np.sqrt(cov[0, 0]),
            "sd of b, %": 100 * np.sqrt(cov[1, 1]),
            "correlation": cov[0, 1] / np.sqrt(cov[0, 0] * cov[1, 1]),
            "divergence, nats": divergence(*exact, mean, cov),
        }
        for name, (mean, cov) in posteriors.items()
    }
).T.round(3)

# %% [markdown]
# The divergence is Kullback and Leibler's from importance sampling's posterior, as normal laws.

# %%
import matplotlib.pyplot as plt

# %matplotlib inline

angle = np.linspace(0.0, 2.0 * np.pi, 200)
circle = 2.4477 * np.array([np.cos(angle), np.sin(angle)])  # holds 95 %
figure, axes = plt.subplots(figsize=(5.5, 4.5))
if draws is not None:
    axes.plot(*np.exp(draws.T), ".", color="0.75", markersize=2, label="neural (NPE), draws")
for (name, (mean, cov)), style in zip(posteriors.items(), ("-", "--", ":"), strict=False):
    axes.plot(*np.exp(mean[:, None] + np.linalg.cholesky(cov) @ circle), style, label=f"{name}, 95 %")
axes.plot(*np.exp(truth[0]), "k+", markersize=12, label="truth")
axes.set(xlabel="F_o, N", ylabel="b")
axes.legend()
plt.close(figure)
figure

# %% [markdown]
# ## Next
#
# - `docs/inference.md` has the simulator, the likelihood, and bounds on what a design is expected to tell.
