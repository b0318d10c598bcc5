"""Worlds of the twin: the device's law follows targets, the jaw follows the device, and the filter learns.

As in targets control the law sets the motors' rates from what it feels, the jaw makes one Newton step to its new
equilibrium, the guard shrinks the targets, and the readings since then inform about the muscles.
"""

from __future__ import annotations

from math import exp, pi, sqrt

import torch
from torch import Tensor
from torch.nn.functional import pad

from agents.twin.belief import Belief, Held
from agents.twin.constants import LAWS_PER_DECISION, Patients, Twin
from agents.twin.mechanics import Forces, Passive, Pose, forces, norm, ramp, wrenches
from jawenv.device import laws
from jawenv.device.channels import FASTEST_TARGET, HIGHEST, LOWEST, N_CHANNELS, ROLL_FULL_SCALE_RAD
from jawenv.device.device import TICK
from jawenv.device.guard import (
    ASKED_MARGIN,
    BRAKE,
    FASTEST,
    FASTEST_BRAKE,
    GIVING_WAY,
    RECOVERY,
    REGROW,
    RELEASE,
    SHRINK_S,
)
from jawenv.device.motors import STOP_ONSET_WIDTH
from jawenv.filter.readings.teeth import LEAST_GAP

FURTHEST = torch.tensor([2e-3, 2e-3, 0.05, 0.05, 0.05], dtype=torch.float64)
"""m and rad of a Newton step, at most: beyond that a jaw that is nearly free is off its linearisation."""
SMALLEST_GUARD = 1e-3


class Worlds:
    """P worlds of a twin, from rest on.

    Args:
        twin: constants.
        patients: P.
        generator: of the readings' noise; without one the belief goes to the truth as far as information reaches.
        asked: (P, 6) the muscles that are asked for; all by default.
        prior: (P, 12) means and sds that beliefs begin with; the environment's by default.

    Attributes:
        asked: as given.
        discomfort: (P,) since the start, s.
        by_limit: (P, 8) the same of each limit.
        pose: of the jaw.
        target: (P, 4) of the channels.
        size: (P, 4) what the guard multiplies them by, for the limits; ``kept``: for the budget.
        fractions: (P, 8) of the limits that are used.
        belief: the filter's.
    """

    def __init__(
        self,
        twin: Twin,
        patients: Patients,
        generator: torch.Generator | None = None,
        asked: Tensor | None = None,
        prior: tuple[Tensor, Tensor] | None = None,
    ) -> None:
        self.twin, self.patients = twin, patients
        self.asked = patients.theta.new_ones(len(patients), 6) if asked is None else asked
        self.by_limit = patients.theta.new_zeros(len(patients), len(twin.cost_sd))
        self.target = patients.rest.new_zeros(len(patients), N_CHANNELS)
        self.size, self.kept, self.thrust = self.target + 1.0, self.target + 1.0, self.target
        self._margin, self._release = self.by_limit + 1.0, self.target
        self.belief = Belief(twin, patients, generator, prior)
        # The device takes the mouthpiece for where the nominal anatomy has it; the limits are of where it is.
        self._misplaced = patients.jaw.mouthpiece - twin.jaw.mouthpiece
        self._end_strain = patients.jaw.passive(patients.jaw.pose(patients.end), patients.theta).strain
        self.begin_at(patients.rest)

    @property
    def discomfort(self) -> Tensor:
        """(P,) since the start, s."""
        return self.by_limit.sum(-1)

    def begin_at(self, q: Tensor) -> None:
        """Put the jaws at poses (P, 5), with motors that push as they did."""
        self._look(q)
        self.motor = self._position() + self.thrust / self.twin.servo
        self.speeds, self.velocity = torch.zeros_like(q), torch.zeros_like(self.place)
        self._feel()

    def step(self, action: Tensor) -> Tensor:
        """Follow targets (P, 4) for one decision; returns the discomfort (P,), s."""
        twin = self.twin
        goal = torch.maximum(action.clamp(max=HIGHEST), action.new_tensor(LOWEST))
        rate = (goal - self.target) / twin.decision_s
        fastest = action.new_tensor(FASTEST_TARGET)
        rate = torch.maximum(torch.minimum(rate, fastest), -fastest)
        before = self.discomfort
        for _ in range(LAWS_PER_DECISION):
            self._command(rate)
            self._move()
            self.belief.learn(self.held(), self.seen() * (twin.dt / TICK))
            self._feel()
            self.target = self.target + twin.dt * rate
        self.belief.learn_from_shaking(self.held())
        self.belief.renew()
        return self.discomfort - before

    def seen(self) -> Tensor:
        """Share (P,) of the readings from which the filter learns: it sees the gap within the encoders' noise."""
        share: Tensor = ((self.passive.gap - LEAST_GAP) / self.twin.encoder_sd[0]).sigmoid()
        return share

    def held(self) -> Held:
        """The jaws as the device holds them."""
        push = self.thrust[..., None] * self.twin.directions
        moment = torch.linalg.cross(self.motor_arms - self.arm[:, None, :], push).sum(1)
        device = torch.cat([push.sum(1), moment], -1)
        servos = wrenches(self.motor_arms, self.twin.directions)
        return Held(self.pose, self.passive, self.arm, device, servos, self._stiffness, self.speeds)

    def _look(self, q: Tensor) -> None:
        jaw = self.patients.jaw
        self.pose: Pose = jaw.pose(q)
        self.passive: Passive = jaw.passive(self.pose, self.patients.theta)
        mouthpiece = jaw.mouthpiece[..., None, :]
        arms = self.pose.arms(torch.cat([mouthpiece + self.twin.arms, mouthpiece], -2))
        self.motor_arms, self.arm = arms[:, :-1], arms[:, -1]
        self.place = self.pose.contact + self.arm

    def _position(self) -> Tensor:
        """(P, 4) of the motors along their axes, m from the closed jaw."""
        closed = self.patients.jaw.mouthpiece[..., None, :] + self.twin.arms
        moved = self.pose.contact[:, None, :] + self.motor_arms - closed
        return (moved * self.twin.directions).sum(-1)

    def _command(self, rate: Tensor) -> None:
        """The motors' targets after ``jawenv.device.laws.servo_rates``, in m and s; ``rate`` (P, 4) of the targets."""
        twin, p = self.twin, self.patients
        q, fastest = self.pose.q, 1e-3 * laws.FASTEST
        correction = twin.gain(laws.CORRECTION)
        opening, side = self.felt()[:2]
        full = torch.stack(
            [p.opening, p.side, torch.full_like(side, twin.force), torch.full_like(side, ROLL_FULL_SCALE_RAD)], -1
        )
        felt = torch.stack([opening, side, self.thrust[:, 2:].sum(-1), q[:, 4] - p.rest[:, 4]], -1)
        size = self.size * self.kept
        error = size * self.target * full - felt
        wanted = size * rate * full + correction * error
        down, across = wanted[:, 0].clamp(-fastest, fastest), wanted[:, 1].clamp(-fastest, fastest)
        back = -self.arm[:, 2] / self.arm[:, 0] * down  # the jaw swings back as it opens
        # Half of the servos' stiffness: jaw and servos yield to each other.
        admittance = 1e-3 * laws.ADMITTANCE
        forward = (twin.gain(admittance * twin.servo) / twin.servo * error[:, 2] - back).clamp(-fastest, fastest)
        twist = twin.arms[0, 1].abs() * wanted[:, 3]
        yaw = across * twin.arms[2, 1].abs() / (1e-3 * laws.SIDE_LEVER)
        rates = torch.stack([down - twist, down + twist, forward - yaw, forward + yaw], -1)
        opening, side, fore_aft, roll = self._release.unbind(-1)
        let_go = torch.stack([torch.maximum(opening, roll), torch.maximum(side, fore_aft)], -1)
        rates = rates - let_go.repeat_interleave(2, -1) * self.thrust / twin.servo
        self.motor = self.motor + twin.dt * rates.clamp(-twin.max_rate, twin.max_rate)

    def _move(self) -> None:
        """One Newton step to where jaw and servos are in equilibrium."""
        twin, before, q = self.twin, self.place, self.pose.q
        position = self._position()
        lead = (self.motor - position).clamp(-twin.reach, twin.reach)
        self.motor, thrust = position + lead, twin.servo * lead
        units = wrenches(self.motor_arms, twin.directions)
        k = torch.full_like(thrust, twin.servo)
        servos = forces(self.pose, self.motor_arms, thrust[..., None] * twin.directions, units, k)
        whole = self.passive.forces + servos + self._stops()
        step = torch.linalg.solve(whole.stiffness, whole.force)
        furthest = FURTHEST.to(step.device)
        step = torch.maximum(torch.minimum(step, furthest), -furthest)
        self._look(q + step)
        self.thrust = twin.servo * (self.motor - self._position())
        self._stiffness = whole.stiffness
        self.speeds, self.velocity = step / twin.dt, (self.place - before) / twin.dt

    def _stops(self) -> Forces:
        """The governor's end stops on the mouthpiece and on the condyles' slide, inside of the hard limits."""
        twin, p, q, width = self.twin, self.patients, self.pose.q, STOP_ONSET_WIDTH
        opening, side, fore_aft = self.excursions()
        travel = torch.stack([fore_aft, side, -opening, q[:, 0] - p.condyle_middle, q[:, 1] - p.rest_condyle_side], -1)
        limit = torch.stack([p.fore_aft, p.side, p.opening, p.condyle_half, 0.0 * side + twin.condyle_side], -1)
        limit = limit * twin.onset
        depth, slope = ramp(travel.abs() - limit, width)
        push, k = -twin.stop * depth * travel.sign(), twin.stop * slope
        push = torch.cat([push[:, :2], push[:, 2:3].clamp(min=0.0), push[:, 3:]], -1)  # nothing stops a jaw that closes
        arm, axes = self.arm[:, None, :].expand(-1, 3, -1), torch.eye(3, dtype=push.dtype, device=push.device)
        on_teeth = forces(self.pose, arm, torch.diag_embed(push[:, :3]), wrenches(arm, axes), k[:, :3])
        on_slide = Forces(pad(push[:, 3:], (0, 3)), torch.diag_embed(pad(k[:, 3:], (0, 3))))
        return on_teeth + on_slide

    def excursions(self) -> tuple[Tensor, Tensor, Tensor]:
        """Opening above rest, side and fore-aft excursion (P,) of the mouthpiece, m."""
        p, place = self.patients, self.place
        opening = p.jaw.mouthpiece[..., 2] - place[:, 2] - p.rest_opening
        s = opening / p.opening
        path = p.path[:, 0] + (p.path[:, 1] + p.path[:, 2] * s) * s
        return opening, place[:, 1] - p.rest_side, place[:, 0] - path

    def felt(self) -> tuple[Tensor, Tensor, Tensor]:
        """The same as the device takes them to be."""
        opening, side, fore_aft = self.excursions()
        return opening, side - self._misplaced[..., 1], fore_aft - self._misplaced[..., 0]

    def _feel(self) -> None:
        """Add the discomfort of the used fractions; the guard shrinks the targets by what is left."""
        twin, p, q = self.twin, self.patients, self.pose.q
        opening, side, fore_aft = self.excursions()
        used = (
            norm(self.thrust @ twin.directions) / twin.force,
            opening.clamp(min=0.0) / p.opening,
            side.abs() / p.side,
            fore_aft.abs() / p.fore_aft,
            (q[:, 0] - p.condyle_middle).abs() / p.condyle_half,
            (q[:, 1] - p.rest_condyle_side).abs() / twin.condyle_side,
            norm(self.velocity) / twin.speed,
            (self.passive.tension / p.tension).amax(-1),
        )
        self.fractions = torch.stack(used, -1)
        # The guard knows where the painless range ends, and the exponents as they are believed.
        exponents = self.belief.mean[:, 1::2].exp()
        _, felt_side, felt_fore_aft = self.felt()
        felt = torch.stack([felt_side.abs() / p.side, felt_fore_aft.abs() / p.fore_aft], -1)
        believed = (exponents * (self.passive.strain - self._end_strain)).exp() / twin.tension_margin
        seen = torch.cat([self.fractions[:, :2], felt, self.fractions[:, 4:-1], believed.amax(-1, keepdim=True)], -1)
        self.margin = 1.0 - seen
        margin = torch.cat([self.margin, 1.0 - q[:, :1] / twin.crest], -1)
        self.by_limit = self.by_limit + twin.dt * self._costs()
        self._shrink(margin)
        if twin.budget > 0.0:
            self._keep_budget()

    def _costs(self) -> Tensor:
        """Cost (P, 8) to be expected of used fractions that shake by ``Twin.cost_sd``.

        It is smooth, so that there is a gradient before a limit.
        """
        costs: Tensor = above(self.fractions - 1.0, self.twin.cost_sd) / (self.twin.hard - 1.0)
        return costs

    def _keep_budget(self) -> None:
        """``jawenv.device.guard.keep_budget`` as it acts on average on margins that shake."""
        twin, sd = self.twin, self.twin.cost_sd
        asked = (ASKED_MARGIN[0] * (self.discomfort / twin.budget).square()).clamp(max=ASKED_MARGIN[1])
        left = self.margin + twin.look_ahead_s / twin.dt * (self.margin - self._margin).clamp(max=0.0)
        missing = asked[:, None] - left
        lack, lacking = _share(missing, sd), torch.special.ndtr(missing / sd)
        lack, lacking = ((values[..., None] * twin.drives).amax(-2) for values in (lack, lacking))
        passed = (_share(asked[:, None] - self.margin, sd)[..., None] * twin.lets_go).amax(-2)
        self._release = twin.gain(RELEASE) * passed
        fastest = FASTEST_BRAKE * twin.dt * lack.new_tensor(FASTEST)
        less = torch.minimum(self.kept * (1.0 - (-BRAKE * twin.dt * lack).exp()), fastest)
        self.kept = (self.kept - less + (1.0 - lacking) * RECOVERY * twin.dt).clamp(max=1.0)
        self._margin = self.margin

    def _shrink(self, margin: Tensor) -> None:
        """``jawenv.device.guard.shrink`` by what is left (P, 9) of all limits and of the way to the crest."""
        twin = self.twin
        share = margin.clamp(min=0.0)[..., None] / twin.guard.clamp(min=SMALLEST_GUARD)
        allowed = torch.where(twin.guard > 0.0, share, 1.0).amin(-2).clamp(max=1.0)
        fastest = margin.new_tensor(FASTEST) * twin.dt
        less = torch.minimum((self.size - allowed) * (1.0 - exp(-twin.dt / SHRINK_S)), fastest)
        more = (self.size + REGROW * twin.dt).clamp(max=1.0)
        self.size = torch.where(allowed < self.size, self.size - less, more)


def _share(missing: Tensor, sd: Tensor) -> Tensor:
    """Expectation of ``missing`` margin that shakes, over ``GIVING_WAY`` and within 0 and 1."""
    return (above(missing, sd) - above(missing - GIVING_WAY, sd)) / GIVING_WAY


def above(x: Tensor, sd: Tensor) -> Tensor:
    """Expectation of max(0, x + sd e) with e from N(0, 1): sd (phi(z) + z Phi(z)), z = x / sd."""
    z = x / sd
    expected: Tensor = sd * ((-0.5 * z.square()).exp() / sqrt(2.0 * pi) + z * torch.special.ndtr(z))
    return expected
