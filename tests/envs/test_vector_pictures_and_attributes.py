"""The native vector form's pictures, and what ``call``, ``get_attr`` and ``set_attr`` reach in its worlds."""

import gymnasium as gym
import numpy as np
import pytest

import jawenv
from jawenv.envs.pictures import picture_size
from jawenv.envs.shown_world import build_scene, moment_of
from jawenv.rendering.renderer import Renderer

ID = "jawenv/Jaw-v3"
SHORT = {"control": "targets", "episode_s": 0.6}


def made(number, **arguments):
    return gym.make_vec(ID, num_envs=number, **{**SHORT, "render_mode": "rgb_array", **arguments})


def actions(number):
    return np.random.default_rng(1).uniform(-1, 1, (2, number, 4)).astype(np.float32)


def test_the_picture_of_one_world_is_that_of_the_single_environment():
    single, many = gym.make(ID, render_mode="rgb_array", **SHORT), made(1)
    single.reset(seed=5)
    many.reset(seed=5)
    for action in actions(1):
        single.step(action[0])
        many.step(action)
    (frame,) = many.render()
    np.testing.assert_array_equal(frame, single.render())


@pytest.mark.parametrize("number", [2, 5])
def test_each_world_has_its_own_picture(number):
    """A single environment with its seed and actions has the same, drawn at the size of many."""
    many = made(number)
    many.reset(seed=5)
    for action in actions(number):
        many.step(action)
    frames = many.render()
    assert isinstance(frames, tuple) and len(frames) == number
    for i in (0, number - 1):
        single, renderer = gym.make(ID, **SHORT).unwrapped, Renderer("rgb_array", 5.0, picture_size(number))
        single.reset(seed=5 + i)
        renderer.note(moment_of(single.simulation))
        for action in actions(number):
            single.step(action[i])
            renderer.note(moment_of(single.simulation))
        np.testing.assert_array_equal(frames[i], renderer.draw(build_scene(single.simulation)))


@pytest.mark.parametrize("mode", ["next_step", "same_step", "disabled"])
def test_a_new_episode_begins_with_an_empty_trace(mode):
    """Whichever way it begins; the other world goes on with its own."""
    env = made(2, autoreset_mode=mode)
    env.reset(seed=0)
    ended = False
    while not ended:
        ended = env.step(np.zeros((2, 4), np.float32))[3].all()
    if mode == "next_step":
        env.step(np.zeros((2, 4), np.float32))
    if mode == "disabled":
        env.reset(options={"reset_mask": np.array([True, False])})
    lengths = [len(renderer._trace) for renderer in env._pictures._renderers]
    assert lengths == ([1, 4] if mode == "disabled" else [1, 1])


def test_pictures_need_a_mode_and_a_reset():
    with pytest.raises(gym.error.ResetNeeded):
        made(2).render()
    env = made(2, render_mode=None)
    env.reset(seed=0)
    with pytest.warns(UserWarning, match="render\\(\\) without render_mode"):
        assert env.render() is None


def test_attributes_of_worlds_are_those_of_single_environments():
    native, side_by_side = (
        gym.make_vec(ID, num_envs=2, vectorization_mode=mode, **SHORT) for mode in ("vector_entry_point", "sync")
    )
    for env in (native, side_by_side):
        env.reset(seed=3)
    names = ("action_space", "observation_space", "parameter_names", "picture_title", "render_mode", "np_random_seed")
    for name in names:
        assert native.get_attr(name) == native.call(name) == side_by_side.get_attr(name)
    drawn = [[generator.random() for generator in env.get_attr("np_random")] for env in (native, side_by_side)]
    assert drawn[0] == drawn[1]
    assert [spec.id for spec in native.get_attr("spec")] == [ID, ID]


def test_attributes_that_can_be_set():
    native, side_by_side = (
        gym.make_vec(ID, num_envs=2, vectorization_mode=mode, **SHORT) for mode in ("vector_entry_point", "sync")
    )
    first = []
    for env in (native, side_by_side):
        env.set_attr("picture_title", ["left", "right"])
        assert env.get_attr("picture_title") == ("left", "right")
        env.set_attr("picture_title", "both")
        assert env.get_attr("picture_title") == ("both", "both")
        env.set_attr("np_random", [np.random.default_rng(7), np.random.default_rng(8)])
        assert env.get_attr("np_random_seed") == (-1, -1)
        first.append(env.reset()[0])
    np.testing.assert_array_equal(*first)


def test_a_title_stands_above_the_pictures():
    env = made(2)
    env.reset(seed=0)
    before = env.call("render")
    env.set_attr("picture_title", ["another", None])
    after = env.render()
    assert (after[0] != before[0]).any()
    np.testing.assert_array_equal(after[1], before[1])


NAMES = "action_space, configuration, metadata, np_random, np_random_seed, observation_space, parameter_names, "


@pytest.mark.parametrize(
    ("use", "kind", "message"),
    [
        (lambda env: env.get_attr("envs"), AttributeError, f"attribute 'envs' is unknown; allowed: {NAMES}"),
        (lambda env: env.call("truth"), AttributeError, f"attribute 'truth' is unknown; allowed: {NAMES}"),
        (lambda env: env.call(["x"]), AttributeError, f"attribute ['x'] is unknown; allowed: {NAMES}"),
        (lambda env: env.call("render", "human"), ValueError, "call('render') has the argument 'human'; allowed: none"),
        (lambda env: env.set_attr("control", "force"), AttributeError, "attribute 'control' cannot be set; allowed: "),
        (lambda env: env.set_attr("picture_title", ["one"]), ValueError, "picture_title has 1 values; allowed: one "),
        (lambda env: env.set_attr("picture_title", [None, 3]), ValueError, "picture_title[1] is 3; allowed: a text "),
        (lambda env: env.set_attr("np_random", 3), ValueError, "np_random[0] is 3; allowed: a numpy.random.Generator"),
    ],
)
def test_what_worlds_do_not_have_is_named(use, kind, message):
    env = gym.make_vec(ID, num_envs=2)
    with pytest.raises(jawenv.InputError) as caught:
        use(env)
    assert isinstance(caught.value, kind)
    assert str(caught.value).startswith(message) and "\n" not in str(caught.value)
