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
# # The results of the thesis, drawn again
#
# Young (2016) asks how the stiffness of the closing muscles, two numbers for each, can be told from a jaw that is moved
# by a device, and tries three ways: linear least squares, nonlinear least squares and an extended Kalman filter. Its
# results are figures of simulations whose jaw, noise and motion it does not state. Here the same is done with corrected
# equations, and what the thesis says stands beside what comes out.
#
# `python -m eval study thesis` does all of it with 1,000 draws, on all cores, and writes a page. What came out of that
# is in `docs/thesis.md`.

# %%
import os
import tempfile
import textwrap
from pathlib import Path

import pandas as pd

# %% [markdown]
# Each result has a name here:
# %%
from eval.kept.parts import Run
from eval.thesis.catalogue import ITEMS
from eval.thesis.study import draw_all

DRAWS = int(os.environ.get("JAWENV_NOTEBOOK_DRAWS", "40"))
WORKERS = 1 if int(os.environ.get("JAWENV_NOTEBOOK_QUICK", "0")) else None
OUTPUT = Path(tempfile.gettempdir()) / "jawenv_thesis"


tables = {}


def look_at(key):
    """Draw a result, and print the thesis's words and ours."""
    item = ITEMS[key]
    tables[key] = draw_all([item], DRAWS, 0, OUTPUT, Run(workers=WORKERS))[key]
    judgement = item.judge(tables[key])
    for words in (
        f"{item.where}: {item.says}",
        f"We measure: {judgement.measured}",
        f"{judgement.verdict}: {judgement.why}",
    ):
        print(textwrap.fill(words, 100), end="\n\n")


pd.DataFrame({key: [item.title, item.where] for key, item in ITEMS.items()}, index=["result", "thesis"]).transpose()

# %% [markdown]
# ## Where is the condyle?
#
# The muscles' lengths follow from where the mandible is, and only the mouthpiece is measured. From its pose, six
# numbers, the condyle's place follows. From its place alone, three numbers, it does not.

# %%
look_at("kinematics")

# %% [markdown]
# ## Least squares
#
# The law of a muscle, $F = F_o \exp(b\,(l - l_o)/l_o)$, expanded about zero stretch is linear in $F_o$ and $F_o b$. It
# is also wrong:

# %%
import numpy as np

b, stretch = 8.0, 0.3
print(
    f"At b = {b:g} and a stretch of {stretch:.0%} the straight line gives {1 + b * stretch:.1f} times F_o, "
    f"and the law {np.exp(b * stretch):.1f} times."
)

# %%
look_at("linear")

# %% [markdown]
# As it is, the law can be fitted by nonlinear least squares.

# %%
look_at("nonlinear_plane")

# %% [markdown]
# Every draw is in the table, so other questions can be put to it. How often is b of the masseter estimated to within a
# tenth?

# %%
plane = tables["nonlinear_plane"]
b = plane[(plane["parameter"] == "log_b/masseter") & (plane["case"] == "sensors")]
float(((b["value"] / b["true_value"] - 1).abs() < 0.1).mean())

# %% [markdown]
# ## What decides
#
# The maneuver: openings of a few degrees tell little about b.

# %%
look_at("maneuver")

# %% [markdown]
# ## The method that failed
#
# First $F_o$ from small openings, then b by logarithms. The thesis sets it aside without saying why.

# %%
look_at("two_stage")

# %% [markdown]
# ## Next
#
# - `look_at("ekf_sides")`, `"ekf_full"`, `"ekf_noise"` and `"rates"` are about the extended Kalman filter; they take
#   longer.
# - A study's file with `results: [ekf_sides]` draws one result: `python -m eval study FILE`.
# - `04_your_own_recording.ipynb` evaluates a recording from a file by the same estimators.
