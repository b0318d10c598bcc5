"""A patient of your own mechanics in the place of the environment's: a jaw that turns about a hinge, in plain NumPy.

    python examples/own_patient.py --patients 8

The jaw is opened and closed in force control. NEES/2 (about 1 on average if the filter's sds are true) is that of the
environment's filter, which knows a hinge without friction: of the environment's own hinge, of the same one written
here, and of one with dry friction, which the filter takes for stiffness.
"""

import argparse
import sys

import gymnasium as gym
import numpy as np

import jawenv


class Hinge:
    """A mandible that turns about the axis through its condyles; ``friction`` (N m) acts against its turning."""

    step_s = 0.5e-3

    def __init__(self, friction=0.0):
        """Keep the friction; each episode has a copy of the object."""
        self.friction = friction

    def reset(self, patient, rng):
        """Rest where the midline model does: with one free coordinate the equilibrium is the same."""
        self.jaw, self.F_o, self.b = patient.jaw, patient.F_o_N, patient.b
        arm = self.jaw["centre_of_mass"]
        self.inertia = self.jaw["inertia"][1, 1] + self.jaw["mass"] * (arm[0] ** 2 + arm[2] ** 2)
        self.angle, self.rate = np.arctan2(patient.rest.rotation[0, 2], patient.rest.rotation[0, 0]), 0.0
        return self.motion()

    def advance(self, wrench, dt):
        """Speed first, then place (semi-implicit Euler)."""
        device = wrench[3:] + np.cross(self.jaw["mouthpiece"], wrench[:3])  # body axes; the hinge's is that of the head
        slip = self.friction * np.tanh(self.rate / 0.01)
        moment = device[1] + self.passive() - slip - self.jaw["damping_rotation"] * self.rate
        self.rate += dt * moment / self.inertia
        self.angle += dt * self.rate
        return self.motion()

    def passive(self):
        """Pitch moment (N m) of muscles, teeth and weight; positive opens."""
        jaw, R = self.jaw, self.rotation()
        ends = jaw["insertion"] @ R.T
        lines = jaw["origin"] - ends
        lengths = np.linalg.norm(lines, axis=1)
        tension = self.F_o * np.exp(self.b * (lengths / jaw["l_o"] - 1.0)) + jaw["tone"]
        moment = np.cross(ends, tension[:, None] * lines / lengths[:, None]).sum(axis=0)
        teeth = jaw["teeth"] @ R.T
        depth, width = teeth[:, 2] - jaw["teeth"][:, 2], jaw["stop_width"]
        soft = np.where(depth < width, np.maximum(depth, 0.0) ** 2 / (2.0 * width), depth - 0.5 * width)
        moment += np.cross(teeth, -jaw["tooth_stiffness"] * soft[:, None] * [0.0, 0.0, 1.0]).sum(axis=0)
        return (moment + np.cross(R @ jaw["centre_of_mass"], jaw["mass"] * jaw["gravity"]))[1]

    def rotation(self):
        """Body to head axes."""
        s, c = np.sin(self.angle), np.cos(self.angle)
        return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])

    def motion(self):
        """Where the mouthpiece is, and how it moves."""
        R, turning = self.rotation(), np.array([0.0, self.rate, 0.0])
        place = R @ self.jaw["mouthpiece"]
        return jawenv.Motion(place, R, np.cross(turning, place), turning)


def play(patients: int, seconds: int, seed: int, plant: object = None) -> float:
    """Open and close the jaws of ``patients``; returns the mean NEES/2."""
    env = gym.make_vec("jawenv/JawHinge-v3", num_envs=patients, control="force", plant=plant)
    env.reset(seed=seed)
    for time in np.arange(1, 20 * seconds + 1) / 20:
        opened = 0.5 * np.sin(0.5 * np.pi * time) ** 2 * np.array([1.0, 1.0, 0.0, 0.0])
        *_, info = env.step(np.tile(opened.astype(np.float32), (patients, 1)))
    return float(np.mean(info["nees"]) / 2.0)


def main() -> None:
    """Read the command line, play and print."""
    parser = argparse.ArgumentParser(description="Play with a jaw of one's own.")
    parser.add_argument("--patients", type=int, default=4)
    parser.add_argument("--seconds", type=int, default=4)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    for name in ("patients", "seconds"):
        if getattr(given, name) < 1:
            raise jawenv.InputError(f"{name} is {getattr(given, name)}; allowed: 1 or more")
    plants = {"environment's hinge": None, "own hinge": Hinge(), "own hinge with friction": Hinge(friction=0.02)}
    for title, plant in plants.items():
        nees = play(given.patients, given.seconds, given.seed, plant)
        print(f"{title:24} NEES/2 {nees:8.2f}", flush=True)


if __name__ == "__main__":
    try:
        main()
    except jawenv.InputError as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(2)
