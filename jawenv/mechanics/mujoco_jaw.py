"""A jaw that MuJoCo moves, as truth for a filter that knows only its own mechanics: ``plant=MujocoJaw()``.

It has what the midline model lacks: two condyles that press on a fossa without friction and may lift off it, ligaments,
and a masseter that wraps around the ramus. Mass, attachments, fossa, teeth and the muscles' law are the patient's.

The mandible is a free body whose frame has its origin between the condyles' centres. Each condyle is a sphere. The
fossa is a row of capsules that lie across, under which a sphere's centre follows the anatomy's path. Contacts are soft:
constraint forces of a small impedance d are those of springs, k = K / ((1 - d) w) with MuJoCo's K and inverse weight w.
Under a load several capsules are touched, whose springs together are as stiff as the anatomy's disc at ``DISC_LOAD``.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from jawenv.anatomy import load_quantities
from jawenv.base.errors import InputError
from jawenv.base.extras import needs
from jawenv.mechanics.plant import Motion, PatientJaw, body_motion

with needs("MujocoJaw", "mujoco", "mujoco"):
    import mujoco

__all__ = ["MujocoJaw"]

Array = NDArray[np.float64]

# Numerical. The path bends with a radius of 6 mm at the crest, which condyle and capsule together must not exceed.
TIMESTEP = 0.5e-3  # s
IMPEDANCE = 1e-4  # so small that the force is a spring's in motion as well
CAPSULE_RADIUS, SPACING = 1e-3, 0.8e-3  # m: the path's ripple is 30 um at most
FOSSA_SPAN = (-0.006, 0.020)  # m, of x
TOOTH_RADIUS = 1e-3
REST_SPEED, REST_KEPT, REST_STEPS = 1e-6, 0.98, 8000  # what a step leaves of a speed while the jaw comes to rest

# Grade G.
DISC_LOAD = 10.0  # N on a condyle
WRAP_RADIUS, WRAP_BULGE = 12e-3, 1.5e-3  # m, of a sphere on the ramus, beyond the masseter's straight line


class _Ligament(NamedTuple):
    """A ligament of the right side, jaw closed; grade G but for its course (R)."""

    skull_mm: tuple[float, float, float]  # its end on the skull
    mandible_mm: tuple[float, float, float]  # its end on the mandible
    slack: float  # strain at which it is taut
    stiffness_N_m: float  # beyond


LIGAMENTS = {
    "temporomandibular": _Ligament((14.0, -60.0, 2.0), (-3.0, -54.0, -12.0), 0.02, 10e3),
    "sphenomandibular": _Ligament((2.0, -32.0, 4.0), (18.0, -40.0, -28.0), 0.05, 2e3),
    "stylomandibular": _Ligament((-14.0, -40.0, -22.0), (0.0, -43.0, -50.0), 0.06, 2e3),
}


class MujocoJaw:
    """The mandible as a free body on two condyles; a ``jawenv.Plant``.

    Args:
        wraps: whether the masseter wraps around the ramus.
        ligaments: whether there are any.
    """

    step_s = 1e-3

    def __init__(self, *, wraps: bool = True, ligaments: bool = True) -> None:
        """Keep the options; the jaw is built of the patient whom ``reset`` is given."""
        self.wraps, self.ligaments = wraps, ligaments

    def reset(self, patient: PatientJaw, rng: np.random.Generator) -> Motion:
        """Put the relaxed jaw of a patient at rest; nothing is drawn by chance."""
        jaw = patient.jaw
        lines = [self.wraps and "masseter" in name for name in patient.line_names]
        self.model = mujoco.MjModel.from_xml_string(_mjcf(jaw, lines, LIGAMENTS if self.ligaments else {}))
        self.data = mujoco.MjData(self.model)
        self._soften(jaw)
        self._count = len(lines)
        self._mouthpiece = jaw["mouthpiece"].copy()
        self._swing, self._lever = _crossing(self._mouthpiece), _crossing(jaw["mouthpiece"] - jaw["centre_of_mass"])
        self._tone = float(jaw["tone"])
        self._damping = np.repeat([jaw["damping_sliding"], jaw["damping_rotation"]], 3)
        self.take_muscles(patient.F_o_N, patient.b)
        mujoco.mj_forward(self.model, self.data)  # the closed jaw
        self._closed = self.data.ten_length[: self._count].copy()
        self._come_to_rest(patient.rest)
        return self.motion

    def take_muscles(self, F_o_N: Array, b: Array) -> None:
        """Take F_o (N) and b of the lines (n,) for the coming steps."""
        self._F_o, self._b = F_o_N, b

    def advance(self, wrench: Array, dt: float) -> Motion:
        """Move the jaw on; returns its motion then."""
        steps = round(dt / TIMESTEP)
        if steps < 1 or abs(steps * TIMESTEP - dt) > 1e-9:
            raise InputError(f"dt is {dt}; allowed: multiples of {TIMESTEP}")
        for _ in range(steps):
            self._step(wrench)
        return self.motion

    @property
    def motion(self) -> Motion:
        """Place and motion of the mouthpiece."""
        qpos, qvel, R = self.data.qpos, self.data.qvel, np.empty((3, 3))
        mujoco.mju_quat2Mat(R.reshape(9), qpos[3:])
        omega = qvel[3:].copy()
        return Motion(qpos[:3] + R @ self._mouthpiece, R, qvel[:3] - R @ (self._swing @ omega), omega)

    def _step(self, wrench: Array) -> None:
        model, data = self.model, self.data
        mujoco.mj_step1(model, data)
        strain = data.ten_length[: self._count] / self._closed - 1.0
        data.ctrl[:] = -(self._F_o * np.exp(self._b * strain) + self._tone)
        data.qfrc_applied[:] = -self._damping * data.qvel
        R = data.xmat[1].reshape(3, 3)
        data.xfrc_applied[1, :3], data.xfrc_applied[1, 3:] = R @ wrench[:3], R @ (wrench[3:] + self._lever @ wrench[:3])
        mujoco.mj_step2(model, data)

    def _come_to_rest(self, near: Motion) -> None:
        (x, y, z, *_), _ = body_motion(near, self._mouthpiece)
        self.data.qpos[:3] = x, y, z
        mujoco.mju_mat2Quat(self.data.qpos[3:], near.rotation.ravel())
        nothing = np.zeros(6)
        for _ in range(REST_STEPS):
            self._step(nothing)
            self.data.qvel[:] *= REST_KEPT
            if np.abs(self.data.qvel).max() < REST_SPEED:
                break
        else:
            raise InputError("the jaw of MuJoCo comes to no rest; allowed: a patient whose jaw does")
        self.data.qvel[:] = 0.0
        self.data.time = 0.0

    def _soften(self, jaw: Any) -> None:
        """Make the contacts as stiff as discs and teeth."""
        model, radius = self.model, float(load_quantities("mandible.toml")["condyle_radius"].si()) + CAPSULE_RADIUS
        depth = DISC_LOAD / float(jaw["disc_stiffness"])
        half_width = np.sqrt(2.0 * radius * depth)
        stiffness = 0.75 * DISC_LOAD * SPACING / (half_width * depth)
        damping = jaw["disc_damping"] * SPACING / (2.0 * half_width)
        scale = (1.0 - IMPEDANCE) * model.body_invweight0[1, 0]
        for side in ("left", "right"):
            model.geom(f"condyle_{side}").solref[:] = -scale * stiffness, -scale * damping
        lag = 1e-3  # s: damping over stiffness, grade G
        model.pair_solref[:] = -scale * jaw["tooth_stiffness"] * np.array([1.0, lag])


def _crossing(a: Array) -> Array:
    """The matrix whose product with b is the vector product a x b."""
    return np.cross(a, np.eye(3)).T.copy()


def _text(numbers: Any) -> str:
    return " ".join(f"{number:.17g}" for number in np.ravel(numbers))


def _mjcf(jaw: Any, wrapping: list[bool], ligaments: dict[str, _Ligament]) -> str:
    """The patient's jaw in MuJoCo's XML; body 1 is the mandible."""
    radius = float(load_quantities("mandible.toml")["condyle_radius"].si())
    half, I = float(jaw["condyle_half_width"]), jaw["inertia"]
    skull = _roof(jaw, radius, half)
    body: list[str] = []
    pairs: list[str] = []
    muscles: list[str] = []
    tendons: list[str] = []
    for side, sign in (("left", 1.0), ("right", -1.0)):
        at = _text((0.0, sign * half, 0.0))
        body.append(f'<geom name="condyle_{side}" size="{radius:.17g}" pos="{at}" priority="1" contype="1" mass="0"/>')
        for name, ligament in ligaments.items():
            turn = np.array([1.0, -sign, 1.0]) * 1e-3
            ends = turn * ligament.skull_mm, turn * ligament.mandible_mm
            _add_line(f"{name}_{side}", *ends, skull, body, tendons, ligament=ligament)
    for k, tooth in enumerate(jaw["teeth"]):
        body.append(
            f'<geom name="tooth{k}" size="{TOOTH_RADIUS}" pos="{_text(tooth - [0, 0, TOOTH_RADIUS])}" mass="0"/>'
        )
        skull.append(f'<geom name="bite{k}" type="plane" size="1 1 1" zaxis="0 0 -1" pos="{_text(tooth)}"/>')
        pairs.append(f'<pair geom1="tooth{k}" geom2="bite{k}" condim="1" solimp="{IMPEDANCE} {IMPEDANCE}"/>')
    for k, wraps in enumerate(wrapping):
        _add_line(f"line{k}", jaw["origin"][k], jaw["insertion"][k], skull, body, muscles, wraps=wraps)
    motors = "".join(f'<motor tendon="line{k}"/>' for k in range(len(wrapping)))
    moments = _text((I[0, 0], I[1, 1], I[2, 2], I[0, 1], I[0, 2], I[1, 2]))
    return f"""<mujoco>
      <option timestep="{TIMESTEP}" gravity="{_text(jaw["gravity"])}" iterations="50" tolerance="1e-12"/>
      <default><geom contype="0" conaffinity="0" condim="1" solimp="{IMPEDANCE} {IMPEDANCE}"/></default>
      <worldbody>{"".join(skull)}
        <body><freejoint/>
          <inertial pos="{_text(jaw["centre_of_mass"])}" mass="{float(jaw["mass"]):.17g}" fullinertia="{moments}"/>
          {"".join(body)}
        </body>
      </worldbody>
      <tendon>{"".join(muscles + tendons)}</tendon>
      <contact>{"".join(pairs)}</contact>
      <actuator>{motors}</actuator>
    </mujoco>"""


def _roof(jaw: Any, radius: float, half: float) -> list[str]:
    """The fossa: capsules across the head, whose parallel surface a condyle's centre follows."""
    d, f = float(jaw["fossa_drop"]), float(jaw["fossa_frequency"])
    fine = np.linspace(*FOSSA_SPAN, 1000)
    along = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(fine), np.diff(d * np.cos(f * fine))))])
    capsules = []
    for x in np.interp(np.arange(0.0, along[-1], SPACING), along, fine):
        slope = -d * f * np.sin(f * x)
        up = np.array([-slope, 1.0]) * (radius + CAPSULE_RADIUS) / np.hypot(slope, 1.0)
        px, pz = x + up[0], d * (np.cos(f * x) - 1.0) + up[1]
        ends = _text((px, -1.5 * half, pz, px, 1.5 * half, pz))
        capsules.append(f'<geom type="capsule" size="{CAPSULE_RADIUS}" fromto="{ends}" conaffinity="1"/>')
    return capsules


def _add_line(
    name: str,
    origin: Array,
    insertion: Array,
    skull: list[str],
    body: list[str],
    tendons: list[str],
    *,
    wraps: bool = False,
    ligament: _Ligament | None = None,
) -> None:
    """A tendon from the skull to the mandible, and what it runs through."""
    skull.append(f'<site name="{name}_origin" pos="{_text(origin)}"/>')
    body.append(f'<site name="{name}_insertion" pos="{_text(insertion)}"/>')
    around, spring = "", ""
    if wraps:
        middle, outward = 0.5 * (origin + insertion), np.array([0.0, np.sign(insertion[1]), 0.0])
        centre, beside = middle - (WRAP_RADIUS - WRAP_BULGE) * outward, middle + 2.0 * WRAP_RADIUS * outward
        body.append(f'<geom name="{name}_ramus" size="{WRAP_RADIUS}" pos="{_text(centre)}" mass="0"/>')
        body.append(f'<site name="{name}_side" pos="{_text(beside)}"/>')
        around = f'<geom geom="{name}_ramus" sidesite="{name}_side"/>'
    if ligament is not None:
        taut = (1.0 + ligament.slack) * float(np.linalg.norm(origin - insertion))
        spring = f' springlength="0 {taut:.17g}" stiffness="{ligament.stiffness_N_m}"'
    tendons.append(
        f'<spatial name="{name}"{spring}><site site="{name}_origin"/>{around}<site site="{name}_insertion"/></spatial>'
    )
