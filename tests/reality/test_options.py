"""The options: everything is off by default, and an effect that is off changes nothing."""

import numpy as np
import pytest
from scipy.stats import norm

from jawenv.reality import Reality


def test_shares_are_thresholds_of_a_normal():
    record = Reality(lost_share=0.05, frozen_share=0.1).records()[0]
    assert norm.cdf(record["lost_below"]) == pytest.approx(0.05, rel=1e-12)
    assert norm.sf(record["frozen_above"]) == pytest.approx(0.1, rel=1e-12)


def test_no_normal_is_so_far_out_that_a_sensor_without_faults_fails():
    record = Reality().records()[0]
    assert (record["lost_below"], record["frozen_above"]) == (-np.inf, np.inf)
