"""An independent jaw with two condyles: its point forces in plain NumPy, its free rigid body in MuJoCo.

Nothing of jawenv's mechanics is used but the numbers in the jaw's record; coordinates and speeds are those of
``jawenv.mechanics.bilateral``. The forces accept complex numbers, as those of ``newton_euler`` do.
"""

import mujoco
import newton_euler as twin
import numpy as np
from scipy.spatial.transform import Rotation

import jawenv


def five(q):
    return q[[0, 1, 3, 4, 5]]


def path(jaw, x):
    return twin.fossa(jaw, x)[:2]


def depth(jaw, place):
    """First-order distance of a condyle's centre above its path."""
    height, slope = path(jaw, place[0])
    return (place[2] - height) / np.sqrt(1 + slope**2)


def condyles(jaw, q, u):
    """Place and velocity of the left and of the right condyle's centre (head axes)."""
    R = twin.rotation(five(q))
    arms = [np.array([0.0, side * jaw["condyle_half_width"], 0.0]) for side in (1, -1)]
    return [(q[:3] + R @ arm, u[:3] + R @ np.cross(u[3:], arm)) for arm in arms]


def gradient(jaw, place):
    """Derivative of ``depth`` by the place, by the complex step."""
    moved = [place + 1j * twin.IMAGINARY_STEP * axis for axis in np.eye(3)]
    return np.array([depth(jaw, p).imag / twin.IMAGINARY_STEP for p in moved])


def disc(jaw, place, velocity):
    """The disc's elastic force and its whole compression (N)."""
    width, inside = jaw["disc_onset"] / jaw["disc_stiffness"], depth(jaw, place)
    elastic = jaw["disc_stiffness"] * twin.ramp(inside, width)
    steepness = np.clip(inside / width, 0.0, 1.0)
    rate = gradient(jaw, place) @ velocity
    return elastic, max(0.0, elastic + jaw["disc_damping"] * steepness * rate)


def disc_force(jaw, place, velocity):
    """Force of the disc on the condyle, head axes."""
    return -disc(jaw, place, velocity)[1] * gradient(jaw, place)


def point_forces(jaw, log_parameters, q, u, disc_force=disc_force):
    """Places and forces, head axes, of everything but the device and the damping of rotation."""
    R, r = twin.rotation(five(q)), q[:3]
    places, forces = [r + R @ jaw["centre_of_mass"]], [jaw["mass"] * jaw["gravity"]]
    for i in range(len(jaw["l_o"])):
        insertion = r + R @ jaw["insertion"][i]
        line = jaw["origin"][i] - insertion
        stretch = twin.length(line) / jaw["l_o"][i] - 1
        tension = np.exp(log_parameters[2 * i] + np.exp(log_parameters[2 * i + 1]) * stretch)
        places.append(insertion)
        forces.append((tension + jaw["tone"]) * line / twin.length(line))
    for closed in jaw["teeth"]:
        tooth = r + R @ closed
        places.append(tooth)
        forces.append(-jaw["tooth_stiffness"] * twin.ramp(tooth[2] - closed[2], jaw["stop_width"]) * np.eye(3)[2])
    crest, width = np.pi / jaw["fossa_frequency"], jaw["stop_width"]
    for place, velocity in condyles(jaw, q, u):
        stop = twin.ramp(-place[0], width) - twin.ramp(place[0] - crest, width)
        force = 0.5 * jaw["condyle_stiffness"] * stop * np.eye(3)[0] - 0.5 * jaw["damping_sliding"] * velocity
        places.append(place)
        forces.append(force + disc_force(jaw, place, velocity))
    return places, forces


def loss(jaw, q, u):
    """Power (W) that damping takes from the motion."""
    total = jaw["damping_rotation"] * u[3:] @ u[3:]
    for place, velocity in condyles(jaw, q, u):
        elastic, whole = disc(jaw, place, velocity)
        total = total + 0.5 * jaw["damping_sliding"] * velocity @ velocity
        total = total + (whole - elastic) * gradient(jaw, place) @ velocity
    return total


def energy(jaw, log_parameters, q, u):
    """Kinetic energy plus the potentials of weight, muscles, teeth, capsule and discs (J)."""
    R, r, width = twin.rotation(five(q)), q[:3], jaw["stop_width"]
    velocity = u[:3] + R @ np.cross(u[3:], jaw["centre_of_mass"])
    total = 0.5 * jaw["mass"] * velocity @ velocity + 0.5 * u[3:] @ jaw["inertia"] @ u[3:]
    total = total - jaw["mass"] * jaw["gravity"] @ (r + R @ jaw["centre_of_mass"])
    for i in range(len(jaw["l_o"])):
        b = np.exp(log_parameters[2 * i + 1])
        length = twin.length(jaw["origin"][i] - r - R @ jaw["insertion"][i])
        total = total + jaw["l_o"][i] / b * np.exp(log_parameters[2 * i] + b * (length / jaw["l_o"][i] - 1))
        total = total + jaw["tone"] * length
    for closed in jaw["teeth"]:
        total = total + jaw["tooth_stiffness"] * twin.ramp_energy((r + R @ closed)[2] - closed[2], width)
    onset = jaw["disc_onset"] / jaw["disc_stiffness"]
    for place, _ in condyles(jaw, q, u):
        past = place[0] - np.pi / jaw["fossa_frequency"]
        stop = twin.ramp_energy(-place[0], width) + twin.ramp_energy(past, width)
        total = total + 0.5 * jaw["condyle_stiffness"] * stop
        total = total + jaw["disc_stiffness"] * twin.ramp_energy(depth(jaw, place), onset)
    return total


def mouthpiece(jaw, q):
    return q[:3] + twin.rotation(five(q)) @ jaw["mouthpiece"]


class FreeBody:
    """The mandible as a free body of MuJoCo, with no contact, gravity or damping of MuJoCo's own."""

    def __init__(self, jaw):
        I = jaw["inertia"]
        inertia = [I[0, 0], I[1, 1], I[2, 2], I[0, 1], I[0, 2], I[1, 2]]
        numbers = {"pos": jaw["centre_of_mass"], "mass": [jaw["mass"]], "fullinertia": inertia}
        inertial = " ".join(f'{key}="{" ".join(repr(float(v)) for v in value)}"' for key, value in numbers.items())
        self.model = mujoco.MjModel.from_xml_string(
            '<mujoco><option gravity="0 0 0"/><worldbody><body name="mandible"><freejoint/>'
            f"<inertial {inertial}/></body></worldbody></mujoco>"
        )
        self.data = mujoco.MjData(self.model)

    def acceleration(self, jaw, log_parameters, q, u, wrench):
        """(6,) acceleration of the midpoint (head axes) and angular acceleration (body axes)."""
        R, data = twin.rotation(five(q)), self.data
        data.qpos[:3], data.qpos[3:] = q[:3], Rotation.from_euler("YZX", q[3:]).as_quat(scalar_first=True)
        data.qvel[:] = u
        data.qfrc_applied[:] = 0.0
        mujoco.mj_fwdPosition(self.model, data)
        places, forces = point_forces(jaw, log_parameters, q, u)
        for place, force in zip(places, forces, strict=True):
            mujoco.mj_applyFT(self.model, data, force, np.zeros(3), place, 1, data.qfrc_applied)
        moment = R @ (wrench[3:] - jaw["damping_rotation"] * u[3:])
        mujoco.mj_applyFT(self.model, data, R @ wrench[:3], moment, mouthpiece(jaw, q), 1, data.qfrc_applied)
        mujoco.mj_forward(self.model, data)
        return data.qacc.copy()


def smooth_disc_force(jaw, place, velocity):
    """The disc's force with ``gradient`` written out, so that it can be differentiated by the complex step itself."""
    height, slope, curvature = twin.fossa(jaw, place[0])[:3]
    above, steep = place[2] - height, 1 / np.sqrt(1 + slope**2)
    along = np.array([-steep * slope * (1 + above * curvature * steep**2), 0.0, steep])
    width, inside = jaw["disc_onset"] / jaw["disc_stiffness"], above * steep
    share = inside / width if 0 < inside.real < width else float(inside.real >= width)
    whole = jaw["disc_stiffness"] * twin.ramp(inside, width) + jaw["disc_damping"] * share * (along @ velocity)
    return -whole * along if inside.real > 0 and whole.real > 0 else 0.0 * along


def acceleration(jaw, log_parameters, q, u, wrench):
    """U' from the 6 x 6 system about the midpoint, for complex arguments; neither the kernels' way nor MuJoCo's."""
    R, omega, rho, m = twin.rotation(five(q)), u[3:], jaw["centre_of_mass"], jaw["mass"]
    places, forces = point_forces(jaw, log_parameters, q, u, smooth_disc_force)
    force = sum(forces) + R @ wrench[:3]
    moment = sum(np.cross(place - q[:3], f) for place, f in zip(places, forces, strict=True))
    moment = R.T @ moment + np.cross(jaw["mouthpiece"], wrench[:3]) + wrench[3:]
    inertia = jaw["inertia"] + m * (rho @ rho * np.eye(3) - np.outer(rho, rho))
    across = np.array([np.cross(rho, axis) for axis in np.eye(3)]).T  # rho x
    matrix = np.block([[m * np.eye(3), -m * R @ across], [m * across @ R.T, inertia]])
    right = np.concatenate(
        [
            force - m * R @ np.cross(omega, np.cross(omega, rho)),
            moment - np.cross(omega, inertia @ omega) - jaw["damping_rotation"] * omega,
        ]
    )
    return np.linalg.solve(matrix, right)


def random_motion(jaw, rng):
    """Log-parameters, q, u and a wrench about the path, either condyle pressed or lifted, on the stops or off."""
    x = rng.uniform(-1e-3, jaw["crest"] + 1e-3)
    z = twin.fossa(jaw, x)[0] + rng.uniform(-0.3e-3, 0.3e-3)
    q = np.array([x, rng.uniform(-2e-3, 2e-3), z, rng.uniform(-0.05, 0.5), *rng.uniform(-0.02, 0.02, 2)])
    u = np.concatenate([rng.uniform(-0.05, 0.05, 3), rng.uniform(-2, 2, 3)])
    wrench = np.concatenate([rng.uniform(-20, 20, 3), rng.uniform(-0.5, 0.5, 3)])
    return jawenv.cohort("trismus").draw_log_parameters(rng), q, u, wrench
