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
# # A first maneuver
#
# A device moves the jaw of a patient and feels its resistance. How stiff each of the six closing muscles is, left and
# right, two numbers each, has to be told from that: 12 parameters. How well this works depends on the *maneuver*.
# This notebook plays one on simulated patients, next to holding still, and looks at what each has told us.

# %%
import os
import tempfile
from pathlib import Path

import gymnasium as gym
import numpy as np
import pandas as pd
from IPython.display import Markdown, Video
from rich.console import Console

import jawenv
from agents import registry
from eval.comparison.compare import compare
from eval.comparison.ranking import rank
from eval.entries import load_entries
from eval.film import Film, write
from eval.report import figures
from eval.settings import Settings

# %matplotlib inline

PATIENTS = int(os.environ.get("JAWENV_NOTEBOOK_PATIENTS", "24"))
EPISODE_S = float(os.environ.get("JAWENV_NOTEBOOK_EPISODE_S", "30"))
MANEUVER = "opening_with_swings_and_fore_aft"

# %% [markdown]
# ## The environment
#
# One step is one command to the device: where the jaw is to be 0.2 s later. `info` holds what the filter believes about
# the 12 parameters (natural logs: F_o is a muscle's force at closed jaw, b how steeply it grows with stretch) and,
# because this is a simulation, the truth.

# %%
env = gym.make("jawenv/Jaw-v2", episode_s=EPISODE_S)
observation, info = env.reset(seed=0)
pd.DataFrame(
    {"believed": np.exp(info["belief_mean"]), "sd, %": 100 * info["belief_sd"], "true": np.exp(info["truth"])},
    index=env.unwrapped.parameter_names,
).round(2)

# %%
F_o, b = (
    np.array([name.startswith(kind) for name in env.unwrapped.parameter_names]) for kind in ("log_F_o/", "log_b/")
)
prior_sd = 100 * info["belief_sd"]
Markdown(
    f"Before anything is measured every muscle is believed to be like the average patient's, give or take "
    f"{prior_sd[F_o].mean():.0f} % in F_o and {prior_sd[b].mean():.0f} % in b."
)

# %% [markdown]
# Now the maneuver is played to its end.

# %%
agent = registry.load_agent(MANEUVER)
agent.reset(1, seed=0)
done = False
while not done:
    action, _ = agent.predict(observation)
    observation, reward, terminated, truncated, info = env.step(action)
    done = terminated or truncated
env.close()
pd.DataFrame(
    {"believed": np.exp(info["belief_mean"]), "sd, %": 100 * info["belief_sd"], "true": np.exp(info["truth"])},
    index=env.unwrapped.parameter_names,
).round(2)

# %% [markdown]
# ## What the jaw does
#
# The same patient and the same noise, as a film: the jaw from the side and from the front, the device's forces, and the
# belief that becomes narrower.

# %%
(entry,) = load_entries([MANEUVER], Settings(episode_s=EPISODE_S).env_kwargs)
film = Path(tempfile.mkdtemp()) / "jaw.mp4"
print(write(Film(entry, seed=0, width=640, every=2), film, Console(quiet=True)))
Video(str(film), embed=True, html_attributes="controls loop")

# %% [markdown]
# ## Many patients at once
#
# One patient proves little. `jawenv.play` plays the maneuver on many at the same time, and `jawenv.score` computes
# every metric. The sd are what the filter *claims*; `nees`, the normalised estimation error squared, says whether to
# believe it: an honest filter's is on average the number of parameters, and more is too sure of itself.

# %%
recording = jawenv.play(agent, patients=PATIENTS, seed=100, env_kwargs={"episode_s": EPISODE_S})
score = jawenv.score(recording)
pd.Series(score.summary()).round(3)

# %% [markdown]
# ## Is it better than doing nothing?
#
# Both are played on the same patients with the same disturbances, so that the comparison is paired. The dots are
# patients, the bars 95 % intervals over them.

# %%
settings = Settings(patients=PATIENTS, seed=100, episode_s=EPISODE_S)
study = compare(load_entries([MANEUVER, "hold_still"], settings.env_kwargs), settings)
ranking = rank(study)
figures.overview(study, ranking)

# %%
best, other = ranking.rows
print(
    f"{best.entry} tells {-other.difference.value:.1f} nats more than {other.entry} "
    f"(95 % interval {-other.difference.high:.1f} to {-other.difference.low:.1f})"
)

# %% [markdown]
# How each parameter becomes known, in the median patient:

# %%
figures.sd_over_time(study, ranking)

# %% [markdown]
# And whether the filter may be believed. In the green band it is honest:

# %%
figures.calibration(study, ranking)

# %% [markdown]
# ## How good could it get?
#
# The posterior Cramér–Rao bound is the smallest sd that any unbiased estimator could reach with this maneuver on this
# patient. Where the bound is large, no better filter helps: the maneuver has to change.

# %%
patient = jawenv.cohort("trismus").draw(np.random.default_rng(1))
bound = jawenv.information_bound({"episode_s": EPISODE_S}, registry.load_agent(MANEUVER), patient)
pd.Series(100 * bound[-1], index=recording.parameter_names, name="bound, %").round(2)

# %% [markdown]
# ## Next
#
# - `python -m eval compare --all-maneuvers` ranks all hand-made maneuvers and writes a report.
# - `02_design_your_own.ipynb` writes a maneuver and compares it.
# - `03_train_an_agent.ipynb` trains an agent.
