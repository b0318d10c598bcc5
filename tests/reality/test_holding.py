"""Creep and reflex are held for a tick: how far that is from following them continuously."""

import numpy as np
import pytest
from reality_states import TICK, Tissue, tensions

FINE = 1e-3


def pose(time):
    """A jaw that opens by 11 degrees and closes again once a second, the condyle sliding along."""
    swing = 0.1 * (1.0 - np.cos(2 * np.pi * time))
    rate = 0.2 * np.pi * np.sin(2 * np.pi * time)
    return (3e-3 + 0.01 * swing, 0.0, 0.08 + swing, 0.0, 0.0), (0.01 * rate, 0.0, rate, 0.0, 0.0)


def tension_curve(jaw, tick, **options):
    """(2000, 6) tensions of 2 s in steps of 1 ms."""
    tissue = Tissue(jaw, np.tile([1.2, 7.0], (6, 1)), tick=tick, **options)
    curve = []
    for begin in np.arange(round(2.0 / tick)) * tick:
        tissue.tick(*pose(begin))
        for step in range(round(tick / FINE)):
            q, _ = pose(begin + (step + 0.5) * FINE)
            curve.append(tensions(jaw, tissue.effective, q))
    return np.array(curve)


@pytest.mark.parametrize("options", [{"reflex_gain": 1.0, "reflex_latency_ms": 10.0}, {"creep_share": 0.3}])
def test_holding_errs_by_less_than_a_twelfth_of_the_effect_and_not_in_the_mean(jaw, options):
    held, followed = tension_curve(jaw, TICK, **options), tension_curve(jaw, FINE, **options)
    effect = np.abs(followed - tension_curve(jaw, FINE)).max(axis=0)
    assert np.all(effect > 0.05)
    assert np.all(np.abs(held - followed).max(axis=0) < effect / 12)
    assert np.all(np.abs((held - followed).mean(axis=0)) < effect / 100)
