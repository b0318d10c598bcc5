"""The jaw once more, built from the anatomy's numbers alone, with MuJoCo as the rigid body.

MuJoCo knows the mandible as a free body (mass, centre of mass, inertia) with a site wherever something acts on it. From
MuJoCo come the mass matrix, the bias forces (gyroscopic terms and weight) and the Jacobians of the sites. The fossa is
a constraint on the free body's six speeds, v = S(q) u, on which the equations are projected. The forces of muscles,
teeth, capsule, damping and device are plain NumPy. Orientation is a quaternion, so that Euler angles appear nowhere in
a trajectory. Nothing of jawenv is used but numbers.
"""

from __future__ import annotations

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from jawenv.anatomy import default_fossa, default_mandible, muscle_set
from jawenv.mechanics import build_jaw


def mjcf(mandible, insertions, gravity):
    """The mandible as a free body whose frame has its origin in the contact point; 17 digits give every bit."""

    def text(numbers):
        return " ".join(f"{number:.17g}" for number in np.ravel(numbers))

    I = mandible.inertia_kg_m2
    fullinertia = text((I[0, 0], I[1, 1], I[2, 2], I[0, 1], I[0, 2], I[1, 2]))
    centre, mass = text(mandible.centre_of_mass_m), text(mandible.mass_kg)
    points = [*insertions, *mandible.teeth_m, mandible.mouthpiece_m, np.zeros(3), mandible.centre_of_mass_m]
    sites = "\n".join(f'<site name="{i}" pos="{text(point)}"/>' for i, point in enumerate(points))
    return f"""<mujoco>
      <option gravity="{text(gravity)}"/>
      <worldbody>
        <body name="mandible">
          <freejoint/>
          <inertial pos="{centre}" mass="{mass}" fullinertia="{fullinertia}"/>
          {sites}
        </body>
      </worldbody>
    </mujoco>"""


class MujocoTwin:
    """A free MuJoCo body on the fossa.

    A state is (x, y, quaternion, u) with u as in jawenv: x', y' and the angular velocity in body axes. MuJoCo's own
    speeds v of a free body are the velocity of its frame's origin, here the contact point, in head axes, and the
    angular velocity in body axes.
    """

    def __init__(self, mandible=None, fossa=None, muscles=None, head_tilt_deg=0.0):
        self.mandible = mandible or default_mandible()
        self.fossa = fossa or default_fossa()
        self.muscles = muscles or muscle_set()
        self.tone = self.mandible.closing_tone_N * self.muscles.whole_muscles_per_line
        down = np.array([0.0, 0.0, -self.mandible.gravity])
        self.gravity = Rotation.from_euler("y", head_tilt_deg, degrees=True).inv().apply(down)
        self.model = mujoco.MjModel.from_xml_string(mjcf(self.mandible, self.muscles.insertion_m, self.gravity))
        self.data = mujoco.MjData(self.model)
        n = len(self.muscles)
        self.insertions, self.teeth = range(n), range(n, n + 3)
        self.mouthpiece, self.contact, self.centre = n + 3, n + 4, n + 5
        record = build_jaw()  # only for two numbers that are no anatomy
        self.capsule_stiffness, self.stop_width = float(record["condyle_stiffness"]), float(record["stop_width"])

    def height(self, x):
        """Height, slope and curvature of the fossa."""
        d, f = self.fossa.drop_m, self.fossa.spatial_frequency
        return d * (np.cos(f * x) - 1), -d * f * np.sin(f * x), -d * f**2 * np.cos(f * x)

    def state(self, q, u):
        """The state of jawenv's coordinates (x, y, theta, psi, alpha) and speeds."""
        x, y, z, w = Rotation.from_euler("YZX", q[2:]).as_quat()
        return np.concatenate([q[:2], [w, x, y, z], u])

    def move(self, state):
        """Put MuJoCo's body there; returns S (6, 5) and S' u (6)."""
        x, u = state[0], state[6:]
        z, slope, curvature = self.height(x)
        S = np.zeros((6, 5))
        S[0, 0] = S[1, 1] = 1.0
        S[2, 0] = slope
        S[3:, 2:] = np.eye(3)
        self.data.qpos[:] = [x, state[1], z, *state[2:6]]
        self.data.qvel[:] = S @ u
        mujoco.mj_forward(self.model, self.data)
        return S, np.array([0, 0, curvature * u[0] ** 2, 0, 0, 0])

    def mass_matrix(self):
        """MuJoCo's mass matrix (6, 6) where the body is."""
        M = np.empty((6, 6))
        mujoco.mj_fullM(self.model, self.data, M)
        return M

    def place(self, site):
        return self.data.site_xpos[site].copy()

    def velocity(self, site):
        """Velocity of a site, in head axes."""
        return self.jacobians(site)[0] @ self.data.qvel

    def jacobians(self, site):
        linear, angular = np.empty((3, 6)), np.empty((3, 6))
        mujoco.mj_jacSite(self.model, self.data, linear, angular, site)
        return linear, angular

    def body_to_head(self):
        return self.data.xmat[1].reshape(3, 3).copy()

    def strains(self):
        """(l - l_o)/l_o of each muscle, and its line from insertion to origin."""
        lines = self.muscles.origin_m - self.data.site_xpos[self.insertions]
        return np.linalg.norm(lines, axis=1) / self.muscles.l_o_m - 1.0, lines

    def muscle_forces(self, log_parameters):
        """Per muscle, the force on the mandible in head axes."""
        strain, lines = self.strains()
        tension = np.exp(log_parameters[0::2] + np.exp(log_parameters[1::2]) * strain)
        return (tension + self.tone)[:, None] * lines / np.linalg.norm(lines, axis=1)[:, None]

    def stop(self, depth):
        """Depth of a stop with a quadratic beginning."""
        width = self.stop_width
        return np.where(depth <= 0, 0.0, np.where(depth < width, depth**2 / (2 * width), depth - width / 2))

    def pushes(self, log_parameters, wrench):
        """What acts where: (site, force in head axes) of everything but weight, normal force and pure moments."""
        pairs = list(zip(self.insertions, self.muscle_forces(log_parameters), strict=True))
        rise = self.data.site_xpos[self.teeth, 2] - self.mandible.teeth_m[:, 2]
        bite = -self.mandible.tooth_stiffness * self.stop(rise)
        pairs += [(site, np.array([0, 0, push])) for site, push in zip(self.teeth, bite, strict=True) if push]
        x = self.data.qpos[0]
        capsule = self.capsule_stiffness * (self.stop(-x) - self.stop(x - self.fossa.crest_m))
        friction = -self.mandible.damping_sliding * self.data.qvel[:3]
        pairs.append((self.contact, friction + [capsule, 0, 0]))
        pairs.append((self.mouthpiece, self.body_to_head() @ wrench[:3]))
        return pairs

    def applied(self, log_parameters, wrench):
        """Generalised force (6) of all pushes, of the device's moment and of the damping of rotation."""
        total = np.zeros(6)
        for site, force in self.pushes(log_parameters, wrench):
            total += self.jacobians(site)[0].T @ force
        total[3:] += wrench[3:] - self.mandible.damping_rotation * self.data.qvel[3:]
        return total

    def acceleration(self, state, log_parameters, wrench):
        """(5,) u'; MuJoCo is left at the state."""
        S, drift = self.move(state)
        M = self.mass_matrix()
        right = self.applied(log_parameters, wrench) - self.data.qfrc_bias - M @ drift
        return np.linalg.solve(S.T @ M @ S, S.T @ right)

    def reaction(self, state, rate, log_parameters, wrench):
        """Generalised force (6) that the fossa must add for the accelerations ``rate`` (5)."""
        S, drift = self.move(state)
        return self.mass_matrix() @ (S @ rate + drift) + self.data.qfrc_bias - self.applied(log_parameters, wrench)

    def state_rate(self, state, log_parameters, wrench):
        """(11,) rate of a state."""
        turning = np.empty(4)
        mujoco.mju_mulQuat(turning, state[2:6], np.concatenate([[0.0], state[8:]]))
        return np.concatenate([state[6:8], turning / 2, self.acceleration(state, log_parameters, wrench)])

    def energy(self, state, log_parameters):
        """Kinetic and potential energy (J): of weight, muscles, teeth and capsule."""
        self.move(state)
        kinetic = 0.5 * self.data.qvel @ self.mass_matrix() @ self.data.qvel
        F_o, b, strain = np.exp(log_parameters[0::2]), np.exp(log_parameters[1::2]), self.strains()[0]
        muscles = np.sum(self.muscles.l_o_m * (F_o / b * np.exp(b * strain) + self.tone * (1.0 + strain)))
        weight = -self.mandible.mass_kg * self.gravity @ self.place(self.centre)
        rise = self.data.site_xpos[self.teeth, 2] - self.mandible.teeth_m[:, 2]
        teeth = self.mandible.tooth_stiffness * sum(map(self.stop_energy, rise))
        x = state[0]
        capsule = self.capsule_stiffness * (self.stop_energy(-x) + self.stop_energy(x - self.fossa.crest_m))
        return kinetic, muscles + weight + teeth + capsule

    def stop_energy(self, depth):
        """Integral of ``stop`` from 0 to ``depth``."""
        width = self.stop_width
        if depth <= 0:
            return 0.0
        return depth**3 / (6 * width) if depth < width else depth * (depth - width) / 2 + width**2 / 6

    def powers(self, state, wrench):
        """Power of the device, and power lost to damping (W)."""
        self.move(state)
        turn = self.data.qvel[3:]
        gain = (self.body_to_head() @ wrench[:3]) @ self.velocity(self.mouthpiece) + wrench[3:] @ turn
        slide = self.velocity(self.contact)
        return gain, self.mandible.damping_sliding * slide @ slide + self.mandible.damping_rotation * turn @ turn
