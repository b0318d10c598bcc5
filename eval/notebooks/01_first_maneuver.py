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
#
# It needs `pip install "jawenv[render]" pandas matplotlib "imageio[ffmpeg]"`.

# %%
import os

import gymnasium as gym
import numpy as np
import pandas as pd

import jawenv

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
env = gym.make("jawenv/Jaw-v3", episode_s=EPISODE_S, render_mode="rgb_array")
names = env.unwrapped.parameter_names


def belief(info):
    columns = {"believed": np.exp(info["belief_mean"]), "sd, %": 100 * info["belief_sd"], "true": np.exp(info["truth"])}
    return pd.DataFrame(columns, index=names).round(2)


observation, info = env.reset(seed=0)
belief(info)

# %% [markdown]
# Before anything is measured every muscle is believed to be like the average patient's. Now the maneuver is played to
# its end.

# %%
agent = jawenv.Player(MANEUVER)


def _play_to_the_end(env):
    """Play an episode; yields the info after each step."""
    observation, info = env.reset(seed=0)
    agent.reset(1)
    done = False
    while not done:
        action, _ = agent.predict(observation)
        observation, reward, terminated, truncated, info = env.step(action)
        done = terminated or truncated
        yield info


*_, info = _play_to_the_end(env)
belief(info)

# %% [markdown]
# ## What the jaw does
#
# The same patient and the same noise, as a film: the jaw from the side and from the front, the device's forces, and the
# belief that becomes narrower. Until it is started it shows how it ends.

# %%
import base64
import tempfile

import imageio.v3 as iio
from IPython.display import Video

last = iio.imwrite("<bytes>", env.render(), extension=".png")
poster = "data:image/png;base64," + base64.b64encode(last).decode()
pictures = [env.render() for _ in _play_to_the_end(env)]
env.close()
film = os.path.join(tempfile.mkdtemp(), "film.mp4")
iio.imwrite(film, pictures, fps=5)
Video(film, embed=True, html_attributes=f'controls loop width="100%" poster="{poster}"')

# %% [markdown]
# ## Many patients at once
#
# One patient proves little. `jawenv.play` plays the maneuver on many at the same time, and `jawenv.score` computes
# every metric. The sds are what the filter *claims*; `NEES`, the normalised estimation error squared, says whether to
# believe it: a calibrated filter's is on average the number of parameters, and more is too sure of itself.

# %%
short = {"episode_s": EPISODE_S}
recording = jawenv.play(agent, patients=PATIENTS, seed=100, env_kwargs=short)
score = jawenv.score(recording)
score.summary()

# %% [markdown]
# ## Is it better than doing nothing?
#
# Both are played on the same patients with the same disturbances, so that the comparison is paired: one line joins what
# a patient gave to both.

# %%
import matplotlib.pyplot as plt

still = jawenv.score(jawenv.play(jawenv.Player("hold_still"), patients=PATIENTS, seed=100, env_kwargs=short))
both = pd.DataFrame({"hold still": still.information_true, MANEUVER: score.information_true}).transpose()
axes = both.plot(marker="o", color="C0", alpha=0.5, legend=False, ylabel="true information, nats", figsize=(5, 3))
plt.close(axes.figure)
axes.figure

# %%
gain = score.information_true - still.information_true
error = gain.std(ddof=1) / np.sqrt(len(gain))
print(f"{MANEUVER} tells {gain.mean():.1f} nats more (95 % interval ± {1.96 * error:.1f})")

# %% [markdown]
# How each parameter becomes known, in the median patient:

# %%
sds = np.sqrt(np.diagonal(recording.belief_cov, axis1=-2, axis2=-1))
course = pd.DataFrame(100 * np.nanmedian(sds, axis=0), index=pd.Index(recording.time, name="s"), columns=names)
axes = course.plot(logy=True, ylabel="sd, %", figsize=(8, 4))
axes.legend(fontsize="small", ncols=2)
plt.close(axes.figure)
axes.figure

# %% [markdown]
# And whether the filter may be believed: a calibrated one has errors of the size of its sds, so that 68, 95 and
# 99.7 % of them are within one, two and three.

# %%
inside = {f"within {n} sd": 100 * share.mean() for n, share in score.inside.items()}
pd.Series(inside).round(1).to_frame("of all errors, %")

# %% [markdown]
# ## How good could it get?
#
# The posterior Cramér–Rao bound is the smallest sd that any unbiased estimator could reach with this maneuver on this
# patient. Where the bound is large, no better filter helps: the maneuver has to change.

# %%
patient = jawenv.cohort("trismus").draw(np.random.default_rng(1))
bound = jawenv.information_bound(short, jawenv.Player(MANEUVER), patient)
pd.Series(100 * bound[-1], index=names).round(2).to_frame("bound, %")

# %% [markdown]
# ## Next
#
# - `02_design_your_own.ipynb` writes a maneuver and compares it.
# - `03_train_an_agent.ipynb` trains an agent.
# - In a clone, `python -m eval compare --all-maneuvers` ranks all maneuvers and writes a report.
