"""Studies of known outcome: linear-Gaussian recordings in place of played episodes."""

import pandas as pd

from eval.comparison.results import Results
from eval.rows.outcomes import outcomes_of
from jawenv.ladder import model_of_env
from jawenv.playing.rollout import DEFAULT_ENV
from tests.metrics.linear_gaussian import linear_gaussian

GOOD, TRAINED, BOASTFUL, IDLE = "good_one", "ppo-seed0", "boastful", "hold_still"
# label -> measurement noise, what the covariance is multiplied by, cost per second of every second patient
ENTRIES = {GOOD: (0.3, 1.0, 0.0), IDLE: (20.0, 1.0, 0.0), TRAINED: (0.5, 1.0, 0.4), BOASTFUL: (0.6, 0.2, 0.0)}


def about(label: str, env: str = DEFAULT_ENV) -> dict:
    return {
        "label": label,
        "spec": label,
        "env_id": env,
        "env_kwargs": {"control": "force"},
        "note": "played with control trajectory" if label == TRAINED else "",
        "trained": label == TRAINED,
        "description": f"What {label} does.",
    }


def study(patients: int = 40, env: str = DEFAULT_ENV) -> Results:
    names = model_of_env(env).muscles.parameter_names
    parts = [
        outcomes_of(linear_gaussian(patients, noise=noise, shrink=shrink, hurt=hurt, parameters=names), 7).assign(
            entry=label
        )
        for label, (noise, shrink, hurt) in ENTRIES.items()
    ]
    settings = {
        "env": env,
        "patients": patients,
        "cohort": "trismus",
        "seed": 7,
        "control": "force",
        "sensors": "pose",
        "episode_s": 20.0,
    }
    return Results.of_rows(
        pd.concat(parts, ignore_index=True),
        {
            "command": "python -m eval compare good_one",
            "settings": settings,
            "entries": [about(label, env) for label in ENTRIES],
            "versions": {"jawenv": "0.1.0"},
            "finished": "2030-01-01 00:00 UTC",
        },
    )


def many_entries() -> Results:
    """Twelve entries, the last of which does not come with the project; all others bear a shipped maneuver's spec."""
    made = study(patients=4)
    labels = [*(f"no_{k}" for k in range(1, 12)), "my_own"]
    patients, curves = (
        pd.concat([table[table["entry"] == GOOD].assign(entry=label) for label in labels], ignore_index=True)
        for table in (made.patients, made.curves)
    )
    entries = [about(label) | {"spec": label if label == "my_own" else "chirp"} for label in labels]
    return Results(patients, curves, made.about | {"entries": entries})
