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
# # Design a maneuver of your own
#
# A maneuver is a text file: where the jaw is to be, over time, as fractions of what the patient tolerates. Here one is
# written, looked at, played on simulated patients and compared with one that comes with the project.
#
# It needs `pip install jawenv pandas matplotlib`.

# %%
import os
import tempfile
from pathlib import Path

import pandas as pd

import jawenv

PATIENTS = int(os.environ.get("JAWENV_NOTEBOOK_PATIENTS", "24"))
EPISODE_S = float(os.environ.get("JAWENV_NOTEBOOK_EPISODE_S", "30"))
FOLDER = Path(tempfile.mkdtemp())

# %% [markdown]
# ## The file
#
# `opening` is the only channel that a maneuver must have; `side`, `fore_aft` and `roll` can be added. The kinds of
# signal are `keyframes`, `harmonics`, `chirp` and `prbs`. Change numbers and run the notebook again.

# %%
MANEUVER = """
name: my_maneuver
title: My maneuver
description: Opens and closes slowly, while the jaw swings from side to side.
source: this notebook
channels:
  opening:
    kind: keyframes
    repeat: true
    points:
      - {t_s: 0, value: 0}
      - {t_s: 8, value: 0.8}
      - {t_s: 16, value: 0}
  side:
    kind: harmonics
    harmonics:
      - {amplitude: 0.5, period_s: 4}
"""
file = FOLDER / "my_maneuver.yaml"
file.write_text(MANEUVER)
maneuver = jawenv.Maneuver.load(file)

# %% [markdown]
# A mistake gets one line that names the key:

# %%
wrong = FOLDER / "wrong.yaml"
wrong.write_text(MANEUVER.replace("value: 0.8", "value: 8"))
try:
    jawenv.Maneuver.load(wrong)
except jawenv.InputError as error:
    print(str(error).replace(str(FOLDER), ""))

# %% [markdown]
# ## What it asks for

# %%
import matplotlib.pyplot as plt

times = pd.RangeIndex(int(20 * EPISODE_S), name="s") / 20
channels = ["opening", "side", "fore-aft", "roll"]
targets = pd.DataFrame(maneuver.targets(times.to_numpy()).value, index=times, columns=channels)
axes = targets.plot(figsize=(8, 3), ylabel="fraction of what is comfortable")
plt.close(axes.figure)
axes.figure

# %% [markdown]
# ## Is it any good?
#
# It is played on the same patients, with the same disturbances, as two others: a straight opening, and holding still.

# %%
short = {"episode_s": EPISODE_S}
played = {"mine": maneuver, "slow opening": "slow_opening", "hold still": "hold_still"}
scores = {
    name: jawenv.score(jawenv.play(jawenv.Player(candidate), patients=PATIENTS, seed=200, env_kwargs=short))
    for name, candidate in played.items()
}
scores["mine"].summary()

# %%
table = pd.DataFrame({name: score.summary() for name, score in scores.items()}).transpose()
table[["information_true", "worst_sd_median", "nees"]].round(3)

# %% [markdown]
# NEES is the number of parameters, 12, where the stated sds are right. Patient by patient, mine less the slow opening:

# %%
gain = scores["mine"].information_true - scores["slow opening"].information_true
print(f"{gain.mean():.1f} nats more (95 % interval ± {1.96 * gain.std(ddof=1) / len(gain) ** 0.5:.1f})")

# %% [markdown]
# Does it hurt? The cost of a comfort limit is 0 up to the soft limit and 1 at the hard one:

# %%
table[["discomfort_s", "largest_fraction_max", "violation_share"]].round(3)

# %% [markdown]
# ## What is still missing
#
# The combination of parameters that is known least after the maneuver, in words. It says which motion to add.

# %%
agent = jawenv.Player(maneuver)
played = jawenv.play(agent, patients=1, seed=200, env_kwargs={"episode_s": EPISODE_S, "record": True})
print(jawenv.identifiability(played.records[0]).describe())

# %% [markdown]
# ## Next
#
# - `agents/README.md` lists every key of a maneuver file.
# - `python -m eval compare my_maneuver.yaml --all-maneuvers` compares it with every other one.
# - `python -m training refine` searches a maneuver by gradient, in minutes.
