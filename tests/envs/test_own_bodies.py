"""An anatomy of one's own: truth and filter have its lines, mandible and fossa."""

import gymnasium as gym
import numpy as np
import pytest
from test_copies import actions

import jawenv
from jawenv.anatomy import Attachment, attachment, default_mandible, known_muscle_sets
from jawenv.ladder import MODELS
from jawenv.mechanics import build_jaw
from jawenv.recordings.of_simulation import record_of
from jawenv.recordings.record_filter import TensionFilter

ID = "jawenv/Jaw-v3"
HEAVY = {"mandible": {"mass_kg": 0.4}, "fossa": {"drop_m": 0.003, "spatial_frequency": 220.0}}


def first_steps(**arguments):
    env = gym.make(ID, control="force", **arguments).unwrapped
    env.reset(seed=5000)
    return np.array([env.step(action)[0] for (action,) in actions(1, 5)]), env


def test_the_default_given_is_the_default(tmp_path):
    (tmp_path / "anatomy.toml").write_text("[mandible]\n[fossa]\n")
    wanted, _ = first_steps()
    for given in (jawenv.Anatomy(), {}, {"attachments": {"deep_masseter": {}}}, tmp_path / "anatomy.toml"):
        np.testing.assert_array_equal(first_steps(anatomy=given)[0], wanted)


def test_all_forms_say_the_same(tmp_path):
    (tmp_path / "heavy.yaml").write_text("mandible: {mass_kg: 0.4}\nfossa: {drop_m: 0.003, spatial_frequency: 220}\n")
    anatomy = jawenv.Anatomy.from_dict(HEAVY)
    wanted, _ = first_steps(anatomy=HEAVY)
    for given in (anatomy, tmp_path / "heavy.yaml"):
        found, _ = first_steps(anatomy=given)
        np.testing.assert_array_equal(found, wanted)
    assert anatomy == jawenv.Anatomy.from_dict(HEAVY) != jawenv.Anatomy()
    assert hash(anatomy) == hash(jawenv.Anatomy.from_dict(HEAVY))
    assert not np.array_equal(wanted, first_steps()[0])


def test_truth_and_filter_have_it():
    """To the bit what ``build_jaw`` makes of the same objects; the law is told of the crest."""
    anatomy = jawenv.Anatomy.from_dict({**HEAVY, "attachments": {"deep_masseter": {"origin_m": [0.03, -0.06, -0.01]}}})
    _, env = first_steps(anatomy=anatomy)
    jaw = build_jaw(anatomy.muscle_sets()["whole"], anatomy.mandible, anatomy.fossa)
    world = env.simulation.worlds[0]
    assert world["truth"]["jaw"].tobytes() == env.simulation.models[0].tobytes() == jaw.tobytes()
    assert jaw["mass"] == 0.4 and jaw["crest"] == pytest.approx(np.pi / 220.0)
    assert world["known"]["tracker"]["crest"] == jaw["crest"]


def test_a_portion_is_mirrored_and_one_of_a_side_is_not():
    right, left = [0.03, -0.06, -0.01], [0.02, 0.05, -0.02]
    anatomy = jawenv.Anatomy.from_dict(
        {"attachments": {"deep_masseter": {"origin_m": right}, "anterior_temporalis_left": {"insertion_m": left}}}
    )
    sets, default = anatomy.muscle_sets(), known_muscle_sets()
    portions = sets["portions"]
    for name, expected in (("deep_masseter_right", right), ("deep_masseter_left", [0.03, 0.06, -0.01])):
        np.testing.assert_allclose(portions.origin_m[portions.names.index(name)], expected, rtol=1e-14)
    np.testing.assert_allclose(portions.insertion_m[portions.names.index("anterior_temporalis_left")], left, rtol=1e-14)
    unchanged = portions.names.index("anterior_temporalis_right")
    np.testing.assert_array_equal(portions.insertion_m[unchanged], default["portions"].insertion_m[unchanged])
    weights = [attachment(f"{part}_masseter", "right").strength_N for part in ("superficial", "deep")]
    other = attachment("superficial_masseter", "right").origin_m
    mean = np.average([other, right], axis=0, weights=weights)
    whole = sets["whole"]
    np.testing.assert_allclose(whole.origin_m[whole.names.index("masseter_right")], mean)
    plane = sets["pairs"]  # the mean of both sides
    lines = [whole.insertion_m[whole.names.index(f"temporalis_{side}")] for side in ("left", "right")]
    np.testing.assert_allclose(
        plane.insertion_m[plane.names.index("temporalis")], np.mean(lines, axis=0) * [1.0, 0.0, 1.0], atol=1e-12
    )
    np.testing.assert_allclose(whole.l_o_m, np.linalg.norm(whole.insertion_m - whole.origin_m, axis=1))


@pytest.mark.parametrize("model", MODELS.values(), ids=lambda model: model.name)
def test_every_model_takes_it(model):
    env = gym.make(model.env_id, anatomy=HEAVY).unwrapped
    _, info = env.reset(seed=5000)
    assert env.simulation.models[0]["mass"] == 0.4
    _, _, _, _, info = env.step(np.zeros(4, np.float32))
    assert np.isfinite(info["nees"])


def test_the_filter_is_honest_on_it_and_records_carry_it():
    """16 patients with 12 parameters each; the NEES of the default's filter is 1.0 to 1.3 per parameter."""
    env = gym.make_vec(ID, num_envs=16, anatomy=HEAVY, episode_s=10.0, record=True)
    env.reset(seed=5000)
    for action in 0.6 * actions(16, 50):
        info = env.step(action.astype(np.float32))[4]
    assert info["nees"].mean() < 1.5 * 12 and info["misfit"].max() < 1.0
    record = record_of(env.simulation, 0)
    assert record.jaw["mass"] == 0.4
    belief = TensionFilter(every=20).estimate(record)
    np.testing.assert_array_equal(belief.mean[-1], info["belief_mean"][0])


def test_inference_takes_it():
    theta = jawenv.cohort("trismus").sample(6, 0)
    made = jawenv.simulate(theta, np.zeros((2, 4)), 0, env_kwargs={"anatomy": HEAVY})
    np.testing.assert_array_equal(made.treatable, jawenv.treatable(theta, env_kwargs={"anatomy": HEAVY}))
    assert made.records[int(np.flatnonzero(made.treatable)[0])].jaw["mass"] == 0.4
    short = {"comfort": {"painless_force_N": 0.5}}
    assert jawenv.treatable(theta, env_kwargs=short).sum() < jawenv.treatable(theta).sum()


@pytest.mark.parametrize(
    "given",
    [
        {"teeth": {}},
        {"mandible": {"weight": 1.0}},
        {"mandible": {"mass_kg": 0.0}},
        {"mandible": {"mass_kg": 50.0}},
        {"mandible": {"mass_kg": "a"}},
        {"mandible": {"mouthpiece_m": [0.1, 0.0]}},
        {"mandible": {"mouthpiece_m": [90.0, 0.0, 0.0]}},
        {"mandible": {"inertia_kg_m2": np.eye(3).tolist()}},
        {"fossa": {"drop_m": float("nan")}},
        {"fossa": 3},
        {"attachments": {"masseter": {}}},
        {"attachments": {"deep_masseter": {"origin_m": [1.0]}}},
        3,
    ],
)
def test_what_is_not_allowed_is_one_line(given):
    with pytest.raises(jawenv.InputError):
        gym.make(ID, anatomy=given)


def test_a_line_without_length_is_refused():
    flat = Attachment(*(2 * [np.array([0.03, 0.06, -0.01])]), np.zeros(3), np.zeros(3), 1.0)
    lines = {f"{portion}_masseter": flat for portion in ("superficial", "deep")}
    with pytest.raises(jawenv.InputError):
        jawenv.Anatomy(lines, default_mandible())
