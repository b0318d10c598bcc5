"""An independent jaw: the free rigid body of Newton and Euler, held on the fossa by an explicit normal force.

Nothing of jawenv's mechanics is used but the numbers in the jaw's record. Where jawenv projects the normal force away
and takes moments about the contact point, the unknowns here are the acceleration of the centre of mass, the angular
acceleration and the normal force (7), and moments are taken about the centre of mass. Every function accepts complex
numbers, so that complex-step differentiation (Squire & Trapp 1998) gives derivatives exact to rounding.
"""

import numpy as np

DOWN_TO = 1e-30  # imaginary step


def rotation(q):
    """Body to head axes as the product of three elementary rotations."""
    _, _, theta, psi, alpha = q
    zero, one = 0.0 * theta, 1.0 + 0.0 * theta
    pitch = [[np.cos(theta), zero, np.sin(theta)], [zero, one, zero], [-np.sin(theta), zero, np.cos(theta)]]
    yaw = [[np.cos(psi), -np.sin(psi), zero], [np.sin(psi), np.cos(psi), zero], [zero, zero, one]]
    roll = [[one, zero, zero], [zero, np.cos(alpha), -np.sin(alpha)], [zero, np.sin(alpha), np.cos(alpha)]]
    return np.array(pitch) @ np.array(yaw) @ np.array(roll)


def angle_axes(q):
    """(3, 3): columns are the body-frame axes about which theta, psi and alpha turn."""
    still_yaw = rotation(np.array([0, 0, 0 * q[2], q[3], q[4]]))
    still_roll = rotation(np.array([0, 0, 0 * q[2], 0 * q[3], q[4]]))
    return np.column_stack([still_yaw.T @ [0, 1, 0], still_roll.T @ [0, 0, 1], [1, 0, 0] + 0 * q[2:5]])


def fossa(jaw, x):
    """Height, slope and curvature of the path."""
    d, f = jaw["fossa_drop"], jaw["fossa_frequency"]
    return d * np.cos(f * x) - d, -d * f * np.sin(f * x), -d * f**2 * np.cos(f * x)


def contact(jaw, q):
    return np.array([q[0], q[1], fossa(jaw, q[0])[0]])


def length(vector):
    return np.sqrt(np.sum(vector * vector))


def ramp(depth, width):
    """A stop's force per stiffness: quadratic over ``width``, then linear, continuous to the slope."""
    if depth.real <= 0.0:
        return 0.0 * depth
    return depth**2 / (2 * width) if depth.real < width else depth - width / 2


def ramp_energy(depth, width):
    """Integral of ``ramp``."""
    if depth.real <= 0.0:
        return 0.0 * depth
    return depth**3 / (6 * width) if depth.real < width else depth**2 / 2 - width * depth / 2 + width**2 / 6


def muscle_lengths(jaw, q):
    R, r = rotation(q), contact(jaw, q)
    return np.array([length(jaw["origin"][i] - r - R @ jaw["insertion"][i]) for i in range(6)])


def tensions(jaw, log_parameters, q):
    F_o, b = np.exp(log_parameters[0::2]), np.exp(log_parameters[1::2])
    return F_o * np.exp(b * (muscle_lengths(jaw, q) - jaw["l_o"]) / jaw["l_o"])


def point_forces(jaw, log_parameters, q, u):
    """Places (head axes) and forces of everything but the device, the normal force and the damping of rotation."""
    R, r = rotation(q), contact(jaw, q)
    places, forces = [r + R @ jaw["centre_of_mass"]], [jaw["mass"] * jaw["gravity"]]
    for i, tension in enumerate(tensions(jaw, log_parameters, q)):
        insertion = r + R @ jaw["insertion"][i]
        line = jaw["origin"][i] - insertion
        places.append(insertion)
        forces.append(tension * line / length(line))
    for closed in jaw["teeth"]:
        tooth = r + R @ closed
        places.append(tooth)
        push = jaw["tooth_stiffness"] * ramp(tooth[2] - closed[2], jaw["stop_width"])
        forces.append(np.array([0, 0, -1]) * push)
    slope, width = fossa(jaw, q[0])[1], jaw["stop_width"]
    capsule = ramp(-q[0], width) - ramp(q[0] - np.pi / jaw["fossa_frequency"], width)
    places.append(r)
    forces.append(np.array([1, 0, 0]) * jaw["condyle_stiffness"] * capsule)
    places.append(r)
    forces.append(-jaw["damping_sliding"] * np.array([u[0], u[1], slope * u[0]]))
    return places, forces


def acceleration(jaw, log_parameters, q, u, wrench):
    """(5,) x'', y'', angular acceleration in body axes; ``wrench`` (6) at the mouthpiece in body axes."""
    R, r = rotation(q), contact(jaw, q)
    rho, omega, I, m = jaw["centre_of_mass"], u[2:], jaw["inertia"], jaw["mass"]
    places, forces = point_forces(jaw, log_parameters, q, u)
    places, forces = [*places, r + R @ jaw["mouthpiece"]], [*forces, R @ wrench[:3]]
    centre = r + R @ rho
    moment = sum(np.cross(p - centre, F) for p, F in zip(places, forces, strict=True))
    moment = R.T @ moment + wrench[3:] - jaw["damping_rotation"] * omega
    _, slope, curvature = fossa(jaw, q[0])
    normal = np.array([-slope, 0 * slope, 1]) / np.sqrt(1 + slope**2)
    back = np.array([[0, -rho[2], rho[1]], [rho[2], 0, -rho[0]], [-rho[1], rho[0], 0]])  # omega' x -rho = back omega'
    system = np.zeros((7, 7), dtype=complex)
    system[:3, :3], system[:3, 6] = m * np.eye(3), -normal
    system[3:6, 3:6], system[3:6, 6] = I, -np.cross(-rho, R.T @ normal)
    along = np.array([-slope, 0 * slope, 1])  # the contact point's acceleration along it is curvature x'^2
    system[6, :3], system[6, 3:6] = along, along @ R @ back
    centripetal = R @ np.cross(omega, np.cross(omega, -rho))
    right = np.concatenate(
        [sum(forces), moment - np.cross(omega, I @ omega), [curvature * u[0] ** 2 - along @ centripetal]]
    )
    solution = np.linalg.solve(system, right)
    of_contact = solution[:3] + R @ back @ solution[3:6] + centripetal
    return np.concatenate([of_contact[:2], solution[3:6]])


def state_rate(jaw, log_parameters, state, wrench):
    """(10,) rates of (q, u)."""
    q, u = state[:5], state[5:]
    angles = np.linalg.solve(angle_axes(q), u[2:])
    return np.concatenate([u[:2], angles, acceleration(jaw, log_parameters, q, u, wrench)])


def runge_kutta(rate, state, h):
    """One classical step; ``rate(time since the start, state)``. Returns the new state and the last stage's."""
    k1 = rate(0.0, state)
    k2 = rate(0.5 * h, state + 0.5 * h * k1)
    k3 = rate(0.5 * h, state + 0.5 * h * k2)
    last = state + h * k3
    return state + h / 6 * (k1 + 2 * k2 + 2 * k3 + rate(h, last)), last


def energy(jaw, log_parameters, q, u):
    """Kinetic energy plus the potentials of weight, muscles, teeth and capsule (J)."""
    R, r = rotation(q), contact(jaw, q)
    rho, omega = jaw["centre_of_mass"], u[2:]
    slope = fossa(jaw, q[0])[1]
    velocity = np.array([u[0], u[1], slope * u[0]]) + R @ np.cross(omega, rho)
    total = 0.5 * jaw["mass"] * velocity @ velocity + 0.5 * omega @ jaw["inertia"] @ omega
    total = total - jaw["mass"] * jaw["gravity"] @ (r + R @ rho)
    total = total + np.sum(tensions(jaw, log_parameters, q) * jaw["l_o"] / np.exp(log_parameters[1::2]))
    width = jaw["stop_width"]
    for closed in jaw["teeth"]:
        total = total + jaw["tooth_stiffness"] * ramp_energy((r + R @ closed)[2] - closed[2], width)
    capsule = ramp_energy(-q[0], width) + ramp_energy(q[0] - np.pi / jaw["fossa_frequency"], width)
    return total + jaw["condyle_stiffness"] * capsule


def measurement(jaw, state):
    """(12,) mouthpiece position, Euler angles, mouthpiece velocity, body angular velocity."""
    q, u = state[:5], state[5:]
    R, arm = rotation(q), jaw["mouthpiece"]
    slope = fossa(jaw, q[0])[1]
    velocity = np.array([u[0], u[1], slope * u[0]]) + R @ np.cross(u[2:], arm)
    return np.concatenate([contact(jaw, q) + R @ arm, q[2:], velocity, u[2:]])


def derivative(function, point):
    """Jacobian (n_out, n_in) of ``function`` at the real array ``point``, exact to rounding."""
    columns = []
    for j in range(len(point)):
        moved = np.array(point, dtype=complex)
        moved[j] += 1j * DOWN_TO
        columns.append(np.imag(function(moved)) / DOWN_TO)
    return np.column_stack(columns)
