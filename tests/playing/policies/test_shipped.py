"""The policies that come with the project: what their cards say, and that they are ahead of hand-made maneuvers."""

import numpy as np
import pytest

import jawenv
from agents import load_agent
from jawenv.base.seeds import REPORTS
from jawenv.playing.maneuvers import Maneuver
from jawenv.playing.policies.card import SHIPPED, policy_names, read_card


@pytest.mark.parametrize("name", policy_names())
def test_a_card_tells_what_it_corrects_how_it_was_made_and_what_it_reached(name: str) -> None:
    card = read_card(SHIPPED / name)
    assert card.residual is not None and card.residual.maneuver == Maneuver.named(card.residual.maneuver.name)
    made_by = list(dict.fromkeys(command.split()[3] for command in card.commands))  # a run may have been resumed
    assert made_by == ["train", "export"]
    assert {result.patients for result in card.results} == {200}
    for result in card.results:
        assert all(any(seed in seeds for seeds in REPORTS) for seed in result.seeds)


@pytest.mark.parametrize("name", policy_names())
def test_it_knows_more_than_a_hand_made_maneuver(name: str) -> None:
    where = read_card(SHIPPED / name).environment
    kwargs = {**where.kwargs(), "episode_s": 10.0, "track_bound": False}
    worst = {}
    for spec in (name, "opening_with_swings_and_fore_aft"):
        agent = load_agent(spec, control=where.control)
        played = jawenv.play(agent, patients=6, seed=5000, env_kwargs=kwargs, env_id=where.id)
        worst[spec] = np.log(jawenv.score(played).worst_sd).mean()
        assert not played.violation.any()
    assert worst[name] < worst["opening_with_swings_and_fore_aft"] - 0.3
