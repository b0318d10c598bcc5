"""The midline model in plain NumPy by an independent formulation: the reference of the compiled kernels.

The free rigid body of Newton and Euler, held on the fossa by an explicit reaction. Where the kernels project that force
away and take moments about the contact point, the unknowns here are the acceleration of the centre of mass, the
angular acceleration and the reactions (of the fossa, and of what holds a held coordinate), and moments are taken about
the centre of mass:

    m a - sum N_i d_i = F,    I omega' - sum N_i (-rho x C d_i) = tau - omega x I omega,    d_i . a_contact = b_i

Nothing of the kernels is used but the numbers in the jaw's record. Arrays may have leading axes, one entry per state,
and may be complex, so that the complex step (Squire & Trapp 1998) gives derivatives exact to rounding; comparisons are
of real parts.
"""

import numpy as np

IMAGINARY_STEP = 1e-30

# K of the rotation 1 + sin K + (1 - cos) K^2 about the axes of theta (y), psi (z) and alpha (x).
_TURNS = np.array(
    [
        [[0.0, 0.0, 1.0], [0.0, 0.0, 0.0], [-1.0, 0.0, 0.0]],
        [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]],
        [[0.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]],
    ]
)
_TURNS_SQUARED = _TURNS @ _TURNS


def cross(a, b):
    """Vector product over the last axis (3); numpy's own takes several times as long for few vectors."""
    after, before = [1, 2, 0], [2, 0, 1]
    product = a[..., after] * b[..., before] - a[..., before] * b[..., after]
    return product


def times(matrix, vector):
    """Matrix (..., n, m) times vector (..., m)."""
    return (matrix @ vector[..., None])[..., 0]


def transposed(matrix):
    """The last two axes exchanged."""
    return np.swapaxes(matrix, -1, -2)


def length(vector):
    """Euclidean length over the last axis, continued to complex numbers: no absolute values."""
    root = np.sqrt(np.sum(vector * vector, axis=-1))
    return root


def _elementary_turns(q):
    """The rotations (..., 3, 3) by pitch theta, yaw psi and roll alpha."""
    angles = np.asarray(q)[..., 2:5, None, None]
    turns = np.eye(3) + np.sin(angles) * _TURNS + (1.0 - np.cos(angles)) * _TURNS_SQUARED
    return turns[..., 0, :, :], turns[..., 1, :, :], turns[..., 2, :, :]


def rotation(q):
    """Body to head axes (..., 3, 3) at the coordinates q (..., 5), as the product of three elementary rotations."""
    pitch, yaw, roll = _elementary_turns(q)
    return pitch @ yaw @ roll


def angle_axes(q):
    """(..., 3, 3): columns are the body-frame axes about which theta, psi and alpha turn."""
    _, yaw, roll = _elementary_turns(q)
    axes = np.empty_like(roll)
    # Rows of a rotation are head axes in body axes: the pitch turns about the second, then the yaw about the third.
    axes[..., :, 0], axes[..., :, 1], axes[..., :, 2] = (yaw @ roll)[..., 1, :], roll[..., 2, :], (1.0, 0.0, 0.0)
    return axes


def fossa(jaw, x):
    """Height (m), slope and curvature (1/m) of the condyle's path at x (m)."""
    d, f = jaw["fossa_drop"], jaw["fossa_frequency"]
    return d * np.cos(f * x) - d, -d * f * np.sin(f * x), -d * f**2 * np.cos(f * x)


def contact(jaw, q):
    """Contact point (..., 3) in head axes (m)."""
    q = np.asarray(q)
    return np.stack([q[..., 0], q[..., 1], fossa(jaw, q[..., 0])[0]], axis=-1)


def ramp(depth, width):
    """A stop's force per stiffness: quadratic over ``width``, then linear, continuous to the slope."""
    real = np.real(depth)
    linear = np.where(real < width, depth**2 / (2.0 * width), depth - 0.5 * width)
    force = np.where(real <= 0.0, 0.0 * depth, linear)
    return force


def muscle_lengths(jaw, q):
    """Lengths (..., lines) of the muscle lines, m."""
    return length(jaw["origin"] - contact(jaw, q)[..., None, :] - jaw["insertion"] @ transposed(rotation(q)))


def tensions(jaw, log_parameters, q):
    """Passive tensions (..., lines) F_o exp(b (l - l_o)/l_o), N, from natural logs (..., 2 m) of F_o (N) and b.

    The law is van Ruijven & Weijs (1990) as used by Young (2016), eq. 2.2.
    """
    return _tensions(jaw, log_parameters, muscle_lengths(jaw, q))


def _tensions(jaw, log_parameters, lengths):
    parameters = np.exp(log_parameters)
    F_o, b = parameters[..., 2 * jaw["muscle"]], parameters[..., 2 * jaw["muscle"] + 1]
    tension = F_o * np.exp(b * (lengths - jaw["l_o"]) / jaw["l_o"])
    return tension


def point_forces(jaw, log_parameters, q, u, R):
    """Arms from the contact point and forces (..., n, 3) of all but device, reactions and damping of rotation.

    Head axes; ``R`` is the rotation at q.
    """
    x, (height, slope, _) = q[..., 0], fossa(jaw, q[..., 0])
    bodies = np.concatenate([jaw["centre_of_mass"][None], jaw["insertion"], jaw["teeth"], np.zeros((1, 3))])
    arms = bodies @ transposed(R)
    lines = len(jaw["l_o"])
    pulls = jaw["origin"] - arms[..., 1 : 1 + lines, :] - contact(jaw, q)[..., None, :]
    lengths = length(pulls)
    tension = _tensions(jaw, log_parameters, lengths) + jaw["tone"]
    batch = np.broadcast_shapes(tension.shape[:-1], u.shape[:-1])
    forces = np.zeros((*batch, *arms.shape[-2:]), np.result_type(tension, u))
    forces[..., 0, :] = jaw["mass"] * jaw["gravity"]
    forces[..., 1 : 1 + lines, :] = (tension / lengths)[..., None] * pulls
    pressed, width = height[..., None] + arms[..., 1 + lines : -1, 2] - jaw["teeth"][:, 2], jaw["stop_width"]
    forces[..., 1 + lines : -1, 2] = -jaw["tooth_stiffness"] * ramp(pressed, width)
    capsule = ramp(-x, width) - ramp(x - np.pi / jaw["fossa_frequency"], width)
    forces[..., -1, 0] = jaw["condyle_stiffness"] * capsule - jaw["damping_sliding"] * u[..., 0]
    forces[..., -1, 1] = -jaw["damping_sliding"] * u[..., 1]
    forces[..., -1, 2] = -jaw["damping_sliding"] * slope * u[..., 0]
    return arms, forces


def _reaction_directions(jaw, slope):
    """Directions (..., c, 3) of the c reactions' forces on the contact point, and (c, 3) of their pure moments.

    The fossa's comes first; of the others there is one for each coordinate that is held, along it or about a body axis.
    """
    held_axes = np.eye(3)[np.flatnonzero([not jaw["free_x"], not jaw["free_y"]])]
    turns = np.eye(3)[np.flatnonzero(np.diag(jaw["inertia_contact_inverse"]) == 0.0)]
    count = 1 + len(held_axes) + len(turns)
    forces, moments = np.zeros((*np.shape(slope), count, 3), np.result_type(slope)), np.zeros((count, 3))
    forces[..., 0, 0], forces[..., 0, 2] = -slope, 1.0
    forces[..., 1 : 1 + len(held_axes), :], moments[1 + len(held_axes) :] = held_axes, turns
    return forces, moments


def acceleration(jaw, log_parameters, q, u, wrench):
    """Accelerations u' of the midline model.

    Args:
        jaw: record from ``jawenv.mechanics.build_jaw``.
        log_parameters: (..., 2 m) natural logs of F_o (N) and b of the jaw's m muscles.
        q: (..., 5) x, y (m), theta, psi, alpha (rad).
        u: (..., 5) x', y' (m/s), angular velocity in body axes (rad/s).
        wrench: (..., 6) force (N) and moment (N m) of the device on the mouthpiece, body axes.

    Returns:
        (..., 5) x'', y'' (m/s2) and angular acceleration in body axes (rad/s2).
    """
    q, u, wrench = np.asarray(q), np.asarray(u), np.asarray(wrench)
    R, omega, rho = rotation(q), u[..., 2:], jaw["centre_of_mass"]
    arms, forces = point_forces(jaw, log_parameters, q, u, R)
    about_centre = cross(arms - (R @ rho)[..., None, :], forces).sum(axis=-2)
    moment = times(transposed(R), about_centre) + wrench[..., 3:]
    moment = moment + cross(jaw["mouthpiece"] - rho, wrench[..., :3]) - jaw["damping_rotation"] * omega
    force = forces.sum(axis=-2) + times(R, wrench[..., :3])

    _, slope, curvature = fossa(jaw, q[..., 0])
    directions, moments = _reaction_directions(jaw, slope)
    back = np.array([[0, -rho[2], rho[1]], [rho[2], 0, -rho[0]], [-rho[1], rho[0], 0]])  # omega' x -rho = back omega'
    turning = directions @ R @ back + moments
    centripetal = times(R, cross(omega, cross(omega, -rho)))
    # Of what the reactions hold, only the height accelerates: as the path bends.
    constrained = -times(directions, centripetal)
    constrained[..., 0] += curvature * u[..., 0] ** 2
    right = [force, moment - cross(omega, omega @ jaw["inertia"]), constrained]
    solution = _solve(jaw, directions, turning, right)
    contact_acceleration = solution[..., :3] + times(R @ back, solution[..., 3:6]) + centripetal
    return np.concatenate([contact_acceleration[..., :2], solution[..., 3:6]], axis=-1)


def _solve(jaw, directions, turning, right):
    """Acceleration of the centre of mass, angular acceleration and reactions (..., 6 + c)."""
    size, batch = 6 + directions.shape[-2], np.broadcast_shapes(*(part.shape[:-1] for part in right))
    system = np.zeros((*batch, size, size), np.result_type(directions, turning))
    system[..., :3, :3], system[..., :3, 6:] = jaw["mass"] * np.eye(3), -transposed(directions)
    system[..., 3:6, 3:6], system[..., 3:6, 6:] = jaw["inertia"], -transposed(turning)
    system[..., 6:, :3], system[..., 6:, 3:6] = directions, turning
    sides = np.concatenate([np.broadcast_to(part, (*batch, part.shape[-1])) for part in right], axis=-1)
    solution = np.linalg.solve(system, sides[..., None])[..., 0]
    return solution


def state_rate(jaw, log_parameters, state, wrench):
    """Rates (..., 10) of the state (..., 10), which is q and u; arguments as of ``acceleration``."""
    state = np.asarray(state)
    q, u = state[..., :5], state[..., 5:]
    angles = np.linalg.solve(angle_axes(q), u[..., 2:, None])[..., 0]
    accelerations = acceleration(jaw, log_parameters, q, u, wrench)
    rate = np.empty((*accelerations.shape[:-1], 10), accelerations.dtype)
    rate[..., :2], rate[..., 2:5], rate[..., 5:] = u[..., :2], angles, accelerations
    return rate


def runge_kutta(rate, state, h):
    """One classical step of ``h``, s; ``rate(time since the start, state)``."""
    k1 = rate(0.0, state)
    k2 = rate(0.5 * h, state + 0.5 * h * k1)
    k3 = rate(0.5 * h, state + 0.5 * h * k2)
    return state + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + rate(h, state + h * k3))


def measurement(jaw, state):
    """(..., 12) mouthpiece position (m), Euler angles (rad), its velocity (m/s), body angular velocity (rad/s)."""
    state = np.asarray(state)
    q, u = state[..., :5], state[..., 5:]
    R, arm = rotation(q), jaw["mouthpiece"]
    slope = fossa(jaw, q[..., 0])[1]
    sliding = np.stack([u[..., 0], u[..., 1], slope * u[..., 0]], axis=-1)
    velocity = sliding + times(R, cross(u[..., 2:], arm))
    return np.concatenate([contact(jaw, q) + R @ arm, q[..., 2:], velocity, u[..., 2:]], axis=-1)


def derivative(function, point):
    """Jacobian (n_out, n_in) of ``function``, which takes one point, at the real array ``point``; exact to rounding."""
    columns = []
    for j in range(len(point)):
        moved = np.array(point, dtype=complex)
        moved[j] += 1j * IMAGINARY_STEP
        columns.append(np.imag(function(moved)) / IMAGINARY_STEP)
    return np.column_stack(columns)
