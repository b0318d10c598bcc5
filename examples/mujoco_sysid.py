"""mujoco.sysid on the jaw of MuJoCo: a dictionary of its parameters, fitted to one pulled jaw's places.

pip install "jawenv[mujoco]" "mujoco[sysid]"
python examples/mujoco_sysid.py --seconds 1  # a minute; intervals count no prior
"""

import argparse

import gymnasium as gym
import numpy as np
from mujoco import sysid

import jawenv
from jawenv.mechanics.mujoco_jaw import MujocoJaw

STEP_S, EVERY, NOISE_M = 1e-3, 20, 5e-5
PULL_N = np.array([1.5, 1.5, -8.0, 0.0, 0.0, 0.0])


class KnownPatient(MujocoJaw):
    """The jaw of MuJoCo; the class remembers the latest patient."""

    def reset(self, patient, rng):
        """Put the jaw at rest."""
        type(self).patient = patient
        return super().reset(patient, rng)


def places(patient: jawenv.PatientJaw, theta: np.ndarray, seconds: float) -> np.ndarray:
    """Places (K, 3) m of the mouthpiece of a patient with parameters (12,) under a swelling pull."""
    jaw, (F_o, b) = MujocoJaw(), np.exp(theta).reshape(-1, 2).T
    jaw.reset(jawenv.PatientJaw(patient.jaw, patient.line_names, F_o, b, patient.rest), np.random.default_rng(0))
    swell = np.sin(np.pi * np.arange(0.0, seconds, STEP_S) / seconds) ** 2
    return np.array([jaw.advance(part * PULL_N, STEP_S).place_m for part in swell])[::EVERY]


def main() -> None:
    """Fit one patient, and print each parameter with its interval beside the truth."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=1.0)
    seconds = parser.parse_args().seconds
    env = gym.make("jawenv/Jaw-v3", plant=KnownPatient()).unwrapped
    truth = env.reset(seed=0)[1]["truth"]
    read = np.random.default_rng(1).normal(places(KnownPatient.patient, truth, seconds), NOISE_M)
    params = sysid.ParameterDict()
    for name, mean, sd in zip(env.parameter_names, env.prior.mean, env.prior.sd, strict=True):
        params.add(sysid.Parameter(name, mean, mean - 3.0 * sd, mean + 3.0 * sd))

    def residual(x, params):
        return [(places(KnownPatient.patient, np.ravel(x), seconds) - read).ravel() / NOISE_M], None, None

    found, result = sysid.optimize(params, residual, optimizer="scipy", verbose=False)
    _, wide = sysid.calculate_intervals(rest := residual(result.x, found)[0], result.jac)
    print(f"misfit {np.mean(rest[0] ** 2):.2f}")
    for name, at, half, true in zip(found.keys(), found.as_vector(), np.ravel(wide), truth, strict=True):
        print(f"{name:24}{at:6.2f} ± {half:5.2f}  truth {true:5.2f}")


if __name__ == "__main__":
    main()
