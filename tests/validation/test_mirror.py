"""A patient seen in a mirror moves as the mirror image: left and right are treated alike, to rounding."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from jaw_motion import mirror, motion

import jawenv
from jawenv.mechanics import build_jaw

# A step at which the stiffest jaw on its teeth is integrated stably: rounding must not be blown up.
STEP, N_STEPS = 2.5e-4, 400
COHORT = jawenv.cohort("trismus")

# From the teeth and the fossa's back to wide open, moving in every way; then force (N) and moment (N m).
LOWEST = np.array([-0.5e-3, -2e-3, -0.02, -0.1, -0.1, -0.05, -0.05, -1, -1, -1, -2, -2, -6, -0.1, -0.1, -0.1])
HIGHEST = np.array([10e-3, 2e-3, 0.4, 0.1, 0.1, 0.05, 0.05, 1, 1, 1, 2, 2, 2, 0.1, 0.1, 0.1])


def fractions(n):
    return arrays(float, n, elements=st.floats(0, 1), fill=st.nothing())


@settings(max_examples=200, deadline=None, derandomize=True, database=None)
@given(patient=fractions(12), start_and_wrench=fractions(16), head_tilt_deg=st.floats(-60, 60))
def test_the_mirrored_patient_moves_as_the_mirror_image(patient, start_and_wrench, head_tilt_deg):
    jaw = build_jaw(head_tilt_deg=head_tilt_deg)
    log_parameters = COHORT.mean[0] + COHORT.sd[0] * (4 * patient - 2)
    q, u, wrench = np.split(LOWEST + (HIGHEST - LOWEST) * start_and_wrench, [5, 10])
    in_mirror, other_q, other_u, other_wrench = mirror(log_parameters, q, u, wrench)
    states = motion(jaw, log_parameters, np.concatenate([q, u]), lambda _: wrench, STEP, N_STEPS)
    other = motion(jaw, in_mirror, np.concatenate([other_q, other_u]), lambda _: other_wrench, STEP, N_STEPS)
    _, back_q, back_u, _ = mirror(in_mirror, other[:, :5], other[:, 5:], other_wrench)
    np.testing.assert_allclose(np.hstack([back_q, back_u]), states, rtol=1e-7, atol=1e-9)
