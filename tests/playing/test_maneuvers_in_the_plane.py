"""Hand-made maneuvers on models without sides: what they ask for to the side does nothing, and does no harm."""

import numpy as np
import pytest

import jawenv
from agents import load_agent, names

ASIDE = [name for name in names() if load_agent(name, control="force").maneuver.channels.side.bounds() != (0.0, 0.0)]  # type: ignore[attr-defined]


@pytest.mark.parametrize("control", ["force", "trajectory"])
@pytest.mark.parametrize("name", ASIDE)
def test_swings_to_the_side_do_nothing_in_the_plane(name: str, control: str) -> None:
    recording = jawenv.play(
        load_agent(name, control=control, env_id="hinge"),
        patients=3,
        seed=0,
        env_kwargs={"control": control, "episode_s": 12.0},
        env_id="jawenv/JawHinge-v3",
    )
    assert recording.valid.all() and not recording.violation.any()
    used = dict(zip(recording.comfort_names, recording.comfort.max(axis=(0, 1)), strict=True))
    assert used["side"] < 1e-9 and used["condyle_side"] < 1e-9
    assert 0.2 < used["opening"] < 1.1 and used["force"] < 1.0
    assert np.median(jawenv.score(recording).worst_sd) < 0.05


def test_there_are_maneuvers_with_swings() -> None:
    assert "opening_with_swings" in ASIDE and "slow_opening" not in ASIDE
