"""What the twin does not know exactly, against differences of the environment's own jaw and of its filter."""

from dataclasses import replace

import gymnasium as gym
import numpy as np
import pytest
import torch
from agreement import agreement

from agents.twin.constants import Patients, Twin
from agents.twin.disturbance import Disturbance
from agents.twin.mechanics import Jaw

STEP = 1e-4
POSE = torch.tensor([[6e-3, 1e-3, 0.15, 0.05, -0.06]], dtype=torch.float64)


@pytest.fixture(scope="module")
def simulation():
    env = gym.make_vec("jawenv/JawImaged-v3", 1, autoreset_mode="disabled")
    env.reset(seed=5000)
    return env.unwrapped.simulation


def moved(jaw, nuisances, j, share):
    """The jaw with one nuisance at so many sds."""
    mass = jaw.mass + share * nuisances.mass[j]
    moment = jaw.mass * jaw.centre_of_mass + share * nuisances.first_moment[j]
    changes = {name: getattr(nuisances, name)[j] for name in ("gravity", "tone", "fossa_drop", "fossa_frequency")}
    changes |= {"l_o": nuisances.l_o[j], "mouthpiece": nuisances.mouthpiece[j]}
    changes |= {name: getattr(nuisances, name)[j].reshape(-1, 3) for name in ("origin", "insertion")}
    changed = {name: getattr(jaw, name) + share * change for name, change in changes.items()}
    return replace(jaw, mass=mass, centre_of_mass=moment / mass, **changed)


def readings(jaw, q, turn):
    """(6,) the encoders' place and angles."""
    pose = jaw.pose(q)
    place = pose.contact[0] + pose.arms(jaw.mouthpiece[None])[0, 0] - jaw.mouthpiece
    angles = q[0, [4, 2, 3]]
    return torch.cat([place, (angles - torch.linalg.cross(turn, angles))[[1, 2, 0]]])


def left_over(jaw, q, theta, device, at):
    """(5,) generalised force of the jaw at a pose, and of a device (1, 6) that pushes as at another one."""
    arm, pose = pose_and_arm(jaw, at)
    return jaw.passive(jaw.pose(q), theta).forces.force[0] + (pose.motion(arm) @ device[..., None])[0, :, 0]


def pose_and_arm(jaw, q):
    pose = jaw.pose(q)
    return pose.arms(jaw.mouthpiece[None])[:, 0], pose


def test_columns_are_the_differences_of_the_moved_jaw_at_the_same_readings(simulation):
    twin, patients = Twin(simulation), Patients.of_worlds(simulation.worlds)
    jaw, nuisances, theta = Jaw.of(simulation.models[0]), twin.nuisances, patients.theta
    device = torch.tensor([[1.0, -2.0, -8.0, 0.1, 0.2, 0.05]], dtype=torch.float64)
    arm, pose = pose_and_arm(jaw, POSE)
    columns = nuisances.columns(jaw, pose, jaw.passive(pose, theta), theta, device, twin.encoder_sd)
    J, turned = pose.motion(arm)[0], pose.turned[0]
    by_pose = torch.cat([J[:, :3], torch.eye(5, dtype=torch.float64)[:, 2:]], -1).T / twin.encoder_sd[:, None]
    for j in range(len(nuisances)):
        body = device.reshape(2, 3) @ turned
        cell = torch.linalg.cross(nuisances.cell_turn[j].expand(2, 3), body) - nuisances.offset[j, :6].reshape(2, 3)
        hidden = (cell @ turned.T).reshape(1, 6)
        ends = {share: moved(jaw, nuisances, j, share) for share in (STEP, -STEP)}
        seen = {share: readings(end, POSE, share * nuisances.turn[j]) for share, end in ends.items()}
        by_sd = (seen[STEP] - seen[-STEP]) / (2.0 * STEP) / twin.encoder_sd
        shift = torch.linalg.lstsq(by_pose, by_sd).solution
        forces = [left_over(end, POSE - s * shift, theta, device + s * hidden, POSE) for s, end in ends.items()]
        force = (forces[0] - forces[1]) / (2.0 * STEP)
        torch.testing.assert_close(columns.force[0, :, j], force, rtol=2e-2, atol=2e-3)
        torch.testing.assert_close(columns.readings[0, :, j], by_sd - by_pose @ shift, rtol=1e-3, atol=1e-5)


def test_a_disturbance_that_lasts_informs_as_all_readings_together(rng):
    readings_, parameters, decay = 4, 3, 0.8
    A = torch.tensor(rng.standard_normal((readings_, 1, 5, parameters)))
    J = torch.tensor(rng.standard_normal((readings_, 1, 5, 6)))
    variance, noise = torch.tensor(rng.uniform(0.5, 2.0, 6)), 0.3 * torch.eye(5, dtype=torch.float64)[None]
    filtered = Disturbance(variance, decay, 1, parameters)
    rows = [filtered.innovation_rows(A[k], J[k], noise)[0] for k in range(readings_)]
    found = sum(row.T @ row for row in rows)
    stacked = torch.cat(list(A[:, 0]))
    lag = np.abs(np.subtract.outer(range(readings_), range(readings_)))
    blocks = [
        [decay ** lag[i, k] * J[i, 0] @ torch.diag(variance) @ J[k, 0].T for k in range(readings_)]
        for i in range(readings_)
    ]
    whole = torch.cat([torch.cat(row, -1) for row in blocks]) + torch.block_diag(*[noise[0]] * readings_)
    torch.testing.assert_close(found, stacked.T @ torch.linalg.solve(whole, stacked))


def test_the_twin_knows_what_the_filter_of_a_scan_s_anatomy_knows():
    result = agreement({"env": "JawImaged"}, 30, 5000)
    assert result.correlation() > 0.95
    assert abs((result.worst[1] - result.worst[0]).mean()) < 0.1
    felt, of_twin = result.discomfort_s.sum(-1)
    assert np.corrcoef(felt, of_twin)[0, 1] > 0.9
    assert of_twin.mean() > 0.75 * felt.mean()
