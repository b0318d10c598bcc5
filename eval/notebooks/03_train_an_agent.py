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
# # Train and evaluate an agent
#
# A hand-made maneuver treats all patients alike. An agent sees how the patient responds, and can correct the maneuver.
# Here one is trained as `make demo` does it, by the gradient of a differentiable twin, and is compared with the
# maneuver that it corrects, on patients of whom one side is stiff.

# %%
import os
import tempfile
from pathlib import Path

import pandas as pd

import jawenv

# %matplotlib inline

PATIENTS = int(os.environ.get("JAWENV_NOTEBOOK_PATIENTS", "24"))
EPISODE_S = float(os.environ.get("JAWENV_NOTEBOOK_EPISODE_S", "10"))
QUICK = bool(int(os.environ.get("JAWENV_NOTEBOOK_QUICK", "0")))
RUN = Path(tempfile.mkdtemp()) / "agent"

# %% [markdown]
# ## The configuration
#
# Everything that decides a run is one tree. `training/configs/apg.yaml` is one; other values can be given.

# %%
from IPython.display import Markdown

from training.run.config import TrainingConfig, config_file

config = TrainingConfig.load(config_file("apg")).changed(steps=96_000)
if QUICK:  # as a test: one update of two worlds
    config = config.changed(
        steps=1,
        n_envs=2,
        env={"id": config.env.id, "kwargs": {**config.env.kwargs, "episode_s": EPISODE_S}},
        arguments={"n_steps": round(5 * EPISODE_S)},
        evaluation={"every_steps": 40, "patients": 2},
    )
Markdown(
    f"{config.algorithm} takes {config.steps:,} steps in {config.n_envs} worlds. It corrects the maneuver "
    f"`{config.residual.maneuver}` by at most {config.residual.scale:.0%} of what is comfortable, and may cost "
    f"{config.comfort.target_discomfort_s:g} s of discomfort on average."
)

# %% [markdown]
# ## The training
#
# On the command line: `python -m training train apg --output runs/my_agent`. The run's folder holds checkpoints, the
# best policy and `evaluations.csv`.

# %%
from rich.console import Console

from training.run.folder import RunFolder
from training.run.train import start

start(config, RunFolder(RUN), Console(quiet=True))
pd.read_csv(RUN / "evaluations.csv").tail().round(3)

# %%
from IPython.display import Image

from training.run.plot import draw

Image(str(draw([RUN], RUN / "curves.png")))

# %% [markdown]
# ## Does it beat what it corrects?
#
# On patients that took no part in the training, in the same control mode, with the same noise.

# %%
from eval.commands.options import terminal
from eval.comparison.ranking import rank
from eval.comparison.results import compare
from eval.kept.entries import Settings, load_entries
from eval.report import table

settings = Settings.of(PATIENTS, 300, cohort="one_sided", episode_s=EPISODE_S)
study = compare(load_entries([str(RUN), config.residual.maneuver, "hold_still"], settings.world), settings)
ranking = rank(study, config.residual.maneuver)
table.show(ranking, terminal())

# %%
(agent,) = (row for row in ranking.rows if row.trained)
gain = agent["difference"]
verdict = "more than" if gain.low > 0 else "less than" if gain.high < 0 else "not distinguishable from"
Markdown(
    f"Patient by patient, the agent's information less that of the maneuver alone is {gain.value:.2f} nats "
    f"(95 % interval {gain.low:.2f} to {gain.high:.2f}, {ranking.patients} patients): {verdict} the maneuver. "
    f"Its filter is {ranking.calibration(agent)}."
)

# %% [markdown]
# ## The agent in a loop of your own

# %%
from agents import load_agent

agent = load_agent(RUN, control="targets")
env_kwargs = {"control": "targets", "cohort": "one_sided", "episode_s": EPISODE_S}
recording = jawenv.play(agent, patients=2, seed=300, env_kwargs=env_kwargs)
jawenv.score(recording).summary()

# %% [markdown]
# ## Next
#
# - `training/README.md` lists algorithms and settings. One seed proves little: try `--seed 1` and others.
# - `python -m training export` makes a folder of the policy that anyone can play without PyTorch.
