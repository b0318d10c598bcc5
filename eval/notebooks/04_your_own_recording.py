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
# # Identify from a recording of your own
#
# A *recording* is what a device measured: where the mouthpiece was, how it moved, what force it felt. The estimators
# get nothing else. So a table from a bench of your own is evaluated as a simulated one is. Put its path into `FILE`.
#
# It needs `pip install jawenv pandas matplotlib`.

# %%
import os

import numpy as np
import pandas as pd

import jawenv
from jawenv.recordings.files import load_record, save_record

FILE = None  # for example Path("bench.csv")
EPISODE_S = float(os.environ.get("JAWENV_NOTEBOOK_EPISODE_S", "30"))

# %% [markdown]
# Without one, a patient is simulated and written to a file, true values included.

# %%
import tempfile
from pathlib import Path

FOLDER = Path(tempfile.mkdtemp())
if FILE is None:
    FILE = FOLDER / "recording.csv"
    agent = jawenv.Player("opening_with_swings_and_fore_aft")
    played = jawenv.play(agent, patients=1, seed=7, env_kwargs={"record": True, "episode_s": EPISODE_S})
    save_record(played.records[0], FILE)
table = pd.read_csv(FILE, comment="#")
table.filter(regex="^(time|mouthpiece|pitch|force)").head()

# %% [markdown]
# ## From the file to a record
#
# Which columns there are and which units they have is in `docs/recordings.md`. The noise of the sensors decides how
# much each reading is believed: `device=jawenv.Device(...)` describes a device of your own. `cohort=...` names the
# population.

# %%
record = load_record(FILE)
truth = "not known" if record.truth is None else "in the file"
print(f"{record.time[-1]:.1f} s at {1 / record.dt:.3g} Hz, {len(record.parameter_names)} parameters")
print(f"The truth is {truth}.")

# %% [markdown]
# A file that cannot be used gets one line with the column, the row and what is allowed:

# %%
damaged = FOLDER / "damaged.csv"
damaged.write_text(Path(FILE).read_text().replace("force_x", "strength_x"))
try:
    load_record(damaged)
except jawenv.InputError as error:
    print(str(error).replace(str(damaged), damaged.name))

# %% [markdown]
# ## The estimate
#
# Estimates are of natural logarithms, so an sd of 0.05 is 5 %. `answer.believed` and `answer.doubts` say whether to
# trust them.

# %%
answer = jawenv.identify(FILE)
results = pd.DataFrame(
    {"estimate": np.exp(answer.log_mean), "sd, %": 100 * answer.log_sd}, index=record.parameter_names
)
if record.truth is not None:
    results["true"] = np.exp(record.truth)
    results["error / sd"] = (answer.log_mean - record.truth) / answer.log_sd
print("believed" if answer.believed else answer.doubts)
results.round(2)

# %% [markdown]
# How the parameters become known:

# %%
import matplotlib.pyplot as plt

estimate = answer.whole.estimate
course = pd.DataFrame(100 * estimate.sd, index=pd.Index(estimate.time, name="s"), columns=record.parameter_names)
axes = course.plot(logy=True, ylabel="sd, %", figsize=(8, 4))
axes.legend(fontsize="small", ncols=2)
plt.close(axes.figure)
axes.figure

# %% [markdown]
# ## What the recording can tell
#
# This is about the motion and the device, and not about an estimator: what no estimator can tell from this recording.
# It is computed at the estimate.

# %%
print(jawenv.identifiability(record, answer.log_mean).describe())

# %% [markdown]
# ## Next
#
# - The same on the command line: `jawenv identify bench.csv`.
# - `05_thesis.ipynb` compares estimators on the cases of Young (2016).
