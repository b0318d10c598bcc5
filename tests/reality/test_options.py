"""The options: everything off by default, units, and what a faulty one is answered."""

from dataclasses import fields

import numpy as np
import pytest
from scipy.stats import norm

from jawenv.errors import InputError
from jawenv.reality import REALITY, Reality

SHAPES = {"reflex_latency_ms", "reflex_lag_ms", "creep_time_s", "articular_onset"}  # of effects that may be off


def test_every_effect_is_off_by_default():
    for field in fields(Reality):
        assert (field.default == 0.0) != (field.name in SHAPES)


def test_the_record_is_in_SI_units():
    options = {field.name: 0.05 + 0.01 * i for i, field in enumerate(fields(Reality))}
    record = Reality(**options).records()[0]
    assert record.dtype == REALITY
    for kernel_name, name, factor in [
        ("reflex_gain", "reflex_gain", 1.0),
        ("reflex_latency", "reflex_latency_ms", 1e-3),
        ("reflex_lag", "reflex_lag_ms", 1e-3),
        ("creep_share", "creep_share", 1.0),
        ("creep_time", "creep_time_s", 1.0),
        ("articular_stiffness", "articular_stiffness_N_m", 1.0),
        ("articular_onset", "articular_onset", 1.0),
        ("cell_bias_force", "cell_bias_N", 1.0),
        ("cell_bias_moment", "cell_bias_N_m", 1.0),
        ("play_position", "encoder_play_mm", 1e-3),
        ("play_angle", "encoder_play_deg", np.pi / 180),
    ]:
        assert record[kernel_name] == pytest.approx(options[name] * factor, rel=1e-15)
    assert norm.cdf(record["lost_below"]) == pytest.approx(options["lost_share"], rel=1e-12)
    assert norm.sf(record["frozen_above"]) == pytest.approx(options["frozen_share"], rel=1e-12)


def test_no_normal_is_so_far_out_that_a_sensor_without_faults_fails():
    record = Reality().records()[0]
    assert (record["lost_below"], record["frozen_above"]) == (-np.inf, np.inf)


@pytest.mark.parametrize("name", [field.name for field in fields(Reality)])
@pytest.mark.parametrize("value", [-0.1, 1e9, float("nan"), float("inf"), True, "1", None, [0.1]])
def test_faulty_fields_are_refused_in_one_line_that_names_them(name, value):
    with pytest.raises(InputError, match=rf"^reality\.{name} is .*; allowed: a finite number, .*, at most [^\n]*$"):
        Reality(**{name: value})
