"""Recordings as files: they come back as they were, and a bad one says where it is bad."""

import os
import sys
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import jawenv
from jawenv.anatomy import cohort
from jawenv.anatomy.knowledge import LEVELS
from jawenv.base.errors import InputError
from jawenv.envs.configuration import Configuration, configure
from jawenv.ladder import MODELS, model_named
from jawenv.recordings import defaults
from jawenv.recordings.columns import READINGS
from jawenv.recordings.files import load_record, save_record
from jawenv.recordings.parquet import read_parquet
from jawenv.recordings.record import Record

HEADER = ",".join(["time_s", "mouthpiece_x_mm", "pitch_deg", *(column.name for column in READINGS)])
ROWS = ["0,80,0,1,2,3,0.1,0.2,0.3", "0.01,81,,2,2,3,0.1,0.2,0.3", "0.02,82,2,3,2,3,0.1,0.2,0.3"]


EXACT = ("sagittal",)
"""Models whose anatomy is known and whose force a cell reads."""


def random_record(model: str, ticks: int, dt: float, seed: int, tilt: float = 0.0) -> Record:
    """A record of numbers without any meaning, some of them not read."""
    rng = np.random.default_rng(seed)
    rung, jaw = model_named(model), defaults.geometry_of(Configuration(model=model), tilt)
    size, names = 10, rung.muscles.parameter_names
    measured = rng.normal(size=(ticks + 1, 12))
    measured[rng.random(measured.shape) < 0.2] = np.nan
    measured[0, 0] = 0.1
    wrench_sd = 1e-3 + rng.random(6)
    return Record(
        time=np.arange(ticks + 1) * dt,
        measured=measured,
        samples=rng.normal(size=(ticks, 3, 6)),
        start_mean=rng.normal(size=size),
        start_sd=rng.random(size),
        measurement_sd=1e-3 + rng.random(12),
        wrench_sd=wrench_sd,
        cell_sd=rng.random(6) * wrench_sd,
        gain_sd=float(rng.random()),
        jaw=jaw,
        prior=cohort("wide", rung.muscles).prior,
        parameter_names=names,
        knowledge=jawenv.Knowledge(mass=0.1, cell_deg=0.5)
        if seed % 3 == 1 and model not in EXACT
        else jawenv.Knowledge(),
        disturbance_time_s=0.5 * (seed % 3),
        disturbance_sd=rng.random(6) * min(seed % 3, 1),
        force_sensor="motors" if seed % 4 == 3 and model not in EXACT else "cell",
        device=jawenv.Device(servo_stiffness_N_m=float(rng.uniform(100.0, 5000.0))) if seed % 2 else None,
        control="trajectory" if seed % 4 == 1 else "force",
        truth=rng.normal(size=len(names)),
        states=rng.normal(size=(ticks + 1, size)),
        wrenches=rng.normal(size=(ticks, 3, 6)),
    )


def assert_same(one: Record, other: Record) -> None:
    arrays = "time measured samples start_mean start_sd measurement_sd wrench_sd cell_sd gain_sd truth states wrenches"
    for name in f"{arrays} disturbance_sd disturbance_time_s".split():
        a, b = getattr(one, name), getattr(other, name)
        assert (a is None) == (b is None), name
        if a is not None:
            np.testing.assert_allclose(b, a, rtol=1e-10, atol=1e-15, err_msg=name)
    np.testing.assert_allclose(other.prior.mean, one.prior.mean)
    np.testing.assert_allclose(other.prior.sd, one.prior.sd)
    assert other.parameter_names == one.parameter_names
    assert other.knowledge == one.knowledge
    assert (other.device, other.control, other.force_sensor) == (one.device, one.control, one.force_sensor)
    for field in one.jaw.dtype.names:
        np.testing.assert_allclose(other.jaw[field], one.jaw[field], rtol=1e-12, atol=1e-15, err_msg=field)


@settings(max_examples=15, deadline=None)
@given(
    model=st.sampled_from(list(MODELS)),
    ticks=st.integers(1, 7),
    dt=st.sampled_from([0.005, 0.01, 0.2]),
    seed=st.integers(0, 1000),
    tilt=st.sampled_from([0.0, 12.5]),
    ending=st.sampled_from(["csv", "parquet"]),
)
def test_what_is_saved_comes_back(tmp_path_factory, model, ticks, dt, seed, tilt, ending):
    path = tmp_path_factory.mktemp("records") / f"one.{ending}"
    record = random_record(model, ticks, dt, seed, tilt)
    save_record(record, path)
    assert_same(record, load_record(path))


def test_truth_may_be_unknown_and_the_geometry_ones_own(tmp_path):
    record = random_record("jaw", 3, 0.01, 1)
    record.jaw["mass"] = 0.123
    record = replace(record, truth=None, states=None, wrenches=None)
    save_record(record, tmp_path / "one.csv")
    assert_same(record, load_record(tmp_path / "one.csv"))


def written(tmp_path, *rows, header=HEADER):
    path = tmp_path / "bench.csv"
    path.write_text("\n".join([header, *rows]) + "\n")
    return path


def test_a_file_of_ones_own_gets_the_defaults(tmp_path):
    record = load_record(written(tmp_path, *ROWS))
    assert record.parameter_names == jawenv.PARAMETER_NAMES
    assert record.dt == pytest.approx(0.01)
    np.testing.assert_allclose(record.measured[:, 0], [0.080, 0.081, 0.082])
    np.testing.assert_allclose(record.measured[:, 3], np.radians([0.0, np.nan, 2.0]))
    assert np.isnan(record.measured[:, 1]).all()
    # The middle of single readings is interpolated.
    np.testing.assert_allclose(record.samples[:, :, 0], [[1.0, 1.5, 2.0], [2.0, 2.5, 3.0]])
    assert record.samples[0, 0, 5] == 0.3
    device = jawenv.Device()
    assert record.measurement_sd[0] == pytest.approx(device.encoder_position_mm / 1e3)
    assert record.wrench_sd[0] == pytest.approx(np.hypot(device.unmodelled_force_N, device.cell_force_N / 2**0.5))
    np.testing.assert_allclose(record.cell_sd, np.repeat([device.cell_force_N, device.cell_moment_N_m], 3) / 2**0.5)
    assert record.gain_sd == device.cell_gain
    assert record.device is None and record.control == "force"
    assert record.truth is None and record.states is None


def test_an_unknown_wrench_matters_less_over_a_longer_tick():
    device = jawenv.Device(cell_force_N=0.0, cell_moment_N_m=0.0)
    np.testing.assert_allclose(defaults.wrench_sd(device, 0.04), 0.5 * defaults.wrench_sd(device, 0.01))


def test_what_is_said_comes_before_the_file_and_the_file_before_the_configuration(tmp_path):
    path = written(tmp_path, *ROWS, header='# cohort: "patchy"\n' + HEADER)
    world = configure({"cohort": "healthy", "knowledge": "imaged", "control": "trajectory"})
    priors = [load_record(path, world, cohort=said).prior.mean for said in ("one_sided", None)]
    for name, prior in zip(("one_sided", "patchy"), priors, strict=True):
        np.testing.assert_array_equal(prior, cohort(name).prior.mean)
    record = load_record(path, world)
    assert (record.knowledge, record.control, record.device) == (LEVELS["imaged"], "trajectory", jawenv.Device())
    assert load_record(path, world, knowledge="exact").knowledge.exact
    with pytest.raises(InputError, match="unexpected keyword argument 'chort'; did you mean cohort"):
        load_record(path, chort="patchy")


def test_what_moved_the_jaw_is_the_files_or_the_callers(tmp_path):
    own, given = jawenv.Device(servo_damping_N_s_m=7.0), jawenv.Device(servo_damping_N_s_m=9.0)
    record = replace(random_record("jaw", 2, 0.01, 0), device=own, control="trajectory")
    save_record(record, tmp_path / "one.csv")
    of_file = load_record(tmp_path / "one.csv")
    assert (of_file.device, of_file.control) == (own, "trajectory")
    of_caller = load_record(tmp_path / "one.csv", device=given, control="force")
    assert (of_caller.device, of_caller.control) == (given, "force")


def test_noise_of_the_load_cell_is_part_of_the_wrench_not_known():
    record = random_record("jaw", 2, 0.01, 0)
    for wrong in (1.001 * record.wrench_sd, -record.cell_sd, np.full(6, np.nan)):
        with pytest.raises(InputError, match="cell_sd is .*allowed: numbers from 0 to wrench_sd"):
            replace(record, cell_sd=wrong)
    assert replace(record, cell_sd=record.wrench_sd).cell_sd is record.wrench_sd
    with pytest.raises(InputError, match=r"cell_sd has shape \(3,\); allowed: \(6,\)"):
        replace(record, cell_sd=np.zeros(3))


@pytest.mark.parametrize("model", ["jaw", "sagittal", "hinge"])
def test_the_start_is_the_motion_that_explains_the_first_reading(model):
    from jawenv.filter.model.encoders import N_MEASUREMENTS, measure

    jaw = defaults.geometry_of(Configuration(model=model))
    size = 10
    free = defaults.start_sd(jaw) > 0.0
    truth = np.zeros(size)
    truth[free] = 1e-2 * np.random.default_rng(3).normal(size=free.sum())
    rows, reading = np.zeros((N_MEASUREMENTS, size)), np.zeros(N_MEASUREMENTS)
    measure(jaw, truth, rows, reading)
    sd = defaults.measurement_sd(jawenv.Device())
    np.testing.assert_allclose(defaults.motion_of_reading(jaw, reading, sd), truth, atol=3e-4)
    reading[3:6] = np.nan
    assert np.isfinite(defaults.motion_of_reading(jaw, reading, sd)).all()


@pytest.mark.parametrize(
    ("rows", "header", "told"),
    [
        (ROWS, HEADER.replace("time_s", "time_ms"), ["time_s", "missing"]),
        (ROWS, HEADER.replace("pitch_deg", "pitch_rad"), ["pitch_rad", "unknown", "pitch_deg"]),
        (ROWS, HEADER.replace("force_z_N", "pitch_deg"), ["pitch_deg", "twice"]),
        (ROWS, HEADER.replace("force_z_N", "yaw_deg"), ["force_z_N", "missing"]),
        ([ROWS[0], ROWS[1].replace("81", "wide open"), ROWS[2]], HEADER, ["mouthpiece_x_mm", "row 3", "wide open"]),
        ([ROWS[0], ROWS[1][4:], ROWS[2]], HEADER, ["time_s", "row 3", "missing"]),
        ([*ROWS, "0.05" + ROWS[2][4:]], HEADER, ["time_s", "row 5", "0.05", "even"]),
        ([ROWS[1], ROWS[0], ROWS[2]], HEADER, ["time_s", "row 3", "even"]),
        ([row.replace(",2,3,0.1", ",,3,0.1") for row in ROWS], HEADER, ["force_y_N", "row 2", "empty"]),
        ([ROWS[0], ROWS[1] + ",7", ROWS[2]], HEADER, ["row 3", "10 values", "9"]),
        ([ROWS[0].replace("80", "inf"), *ROWS[1:]], HEADER, ["mouthpiece_x_mm", "row 2", "infinite"]),
        ([f"0.0{k},,,1,2,3,0.1,0.2,0.3" for k in range(3)], HEADER, ["no encoder was read"]),
        (ROWS[:1], HEADER, ["1 rows", "two"]),
        ([], HEADER, ["empty"]),
        (ROWS, "# model: 7\n" + HEADER, ["model", "7"]),
        (ROWS, "# cell_sd: [9, 0, 0, 0, 0, 0]\n" + HEADER, ["cell_sd", "wrench_sd"]),
        (ROWS, '# device: {"spring": 1}\n' + HEADER, ["device", "spring", "Device"]),
        (ROWS, '# device: {"servo_stiffness_N_m": "stiff"}\n' + HEADER, ["servo_stiffness_N_m", "stiff"]),
        (ROWS, '# device: "stiff"\n' + HEADER, ["device", "stiff", "Device"]),
        (ROWS, '# control: "torque"\n' + HEADER, ["control", "torque", "trajectory"]),
        (ROWS, "# wrench_sd: some\n" + HEADER, ["wrench_sd", "row 1", "JSON"]),
    ],
)
def test_a_bad_file_is_refused_in_one_line_that_says_where(tmp_path, rows, header, told):
    path = written(tmp_path, *rows, header=header)
    with pytest.raises(InputError) as caught:
        load_record(path)
    message = str(caught.value)
    assert "\n" not in message
    for word in told:
        assert word in message, message


def test_files_that_are_no_recordings(tmp_path):
    for name, text in (("a.txt", ".csv"), ("none.csv", "no such file"), ("none.parquet", "no such file")):
        with pytest.raises(InputError, match=text):
            load_record(tmp_path / name)
    (tmp_path / "b.parquet").write_text("no parquet")
    with pytest.raises(InputError, match="allowed: a Parquet file"):
        load_record(tmp_path / "b.parquet")
    (tmp_path / "c.csv").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match="UTF-8"):
        load_record(tmp_path / "c.csv")
    with pytest.raises(InputError, match="cannot be written: No such file or directory"):
        save_record(random_record("jaw", 1, 0.01, 0), tmp_path / "nowhere" / "one.csv")


def test_parquet_without_pyarrow_says_what_to_do(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(InputError, match="pyarrow"):
        save_record(random_record("jaw", 1, 0.01, 0), tmp_path / "one.parquet")


@pytest.mark.parametrize("ending", [".csv", ".parquet"])
def test_pipes_and_large_files_are_refused_before_they_are_read(tmp_path, ending):
    os.mkfifo(tmp_path / f"pipe{ending}")
    with pytest.raises(InputError, match=f"^[^\\n]*pipe{ending}: is a pipe; allowed: a regular file$"):
        load_record(tmp_path / f"pipe{ending}")
    with (tmp_path / f"large{ending}").open("wb") as file:
        file.truncate(2**40)
    with pytest.raises(InputError, match=f"^[^\\n]*large{ending}: has 1,099,511,627,776 bytes; allowed: "):
        load_record(tmp_path / f"large{ending}")


def test_a_small_parquet_file_of_a_large_table_is_refused(tmp_path):
    import pyarrow as pa
    import pyarrow.parquet as pq

    column = pa.array(np.zeros(1_000_000))
    pq.write_table(pa.table({"time_s": column}), tmp_path / "zeros.parquet", compression="zstd")
    assert (tmp_path / "zeros.parquet").stat().st_size < 100_000
    with pytest.raises(InputError, match=r"zeros\.parquet: its table takes 8,000,000 bytes; allowed: 1,000,000 at"):
        read_parquet(tmp_path / "zeros.parquet", 1_000_000)
