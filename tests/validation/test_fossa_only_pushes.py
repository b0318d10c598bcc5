"""What the fossa must add for MuJoCo's body to move as jawenv says: a push along its normal and no moment.

The equations hold the condyle on its path in both directions. That the needed force always presses the condyle
downward, as a bony roof can, shows that this does not glue the condyle to the fossa in therapy.
"""

import numpy as np
import pytest
from printed_equations import therapy_states

import jawenv
from jawenv.mechanics import build_jaw


@pytest.mark.parametrize("cohort", ["healthy", "trismus", "severe"])
def test_the_fossa_pushes_along_its_normal(cohort):
    jaw = build_jaw()
    for s in therapy_states(cohort):
        rate = jawenv.acceleration(jaw, s.q, s.u, s.log_parameters, s.wrench)
        reaction = s.twin.reaction(s.twin.state(s.q, s.u), rate, s.log_parameters, s.wrench)
        slope, size = s.twin.height(s.q[0])[1], np.linalg.norm(reaction[:3])
        normal = np.array([slope, 0, -1]) / np.hypot(slope, 1)
        assert reaction[:3] @ normal > 0
        np.testing.assert_allclose(reaction[:3], size * normal, atol=1e-11 * size)
        np.testing.assert_allclose(reaction[3:], 0, atol=1e-12 * size)  # N m: rounding on an arm of 0.1 m
