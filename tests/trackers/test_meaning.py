"""Columns and keys of a tracker's file that change what others mean."""

import json

import numpy as np
import pandas as pd
import pytest

from jawenv.base.errors import InputError
from jawenv.recordings.files import load_record
from jawenv.trackers.bids_motion import read_bids_motion
from jawenv.trackers.importing import ImportSettings, import_file
from jawenv.trackers.opensim import AXES
from jawenv.trackers.tracks import Tracks
from tests import tracker_files as files

ARM_MM = np.array([30.0, -5.0, 12.0])
"""From the mouthpiece to where the force acts, body axes."""


def storage(path, names, table):
    head = ["x", "version=1", f"nRows={len(table)}", "inDegrees=yes", "endheader", "\t".join(["time", *names])]
    path.write_text("\n".join([*head, *("\t".join(f"{value:.10g}" for value in row) for row in table), ""]))
    return path


def motion_and_forces(moved, torque=True):
    """Names and columns of a body in head axes, and of its wrench about a point, OpenSim's axes."""
    place, turned = moved.place(files.MOUTHPIECE_MM), moved.turned.as_matrix()
    angles = (AXES.T @ turned @ AXES).copy()
    motion = np.column_stack([place @ AXES / 1e3, files.Rotation.from_matrix(angles).as_euler("ZYX", degrees=True)])
    force = moved.wrench[:, :3]
    moment = moved.wrench[:, 3:] - np.cross(ARM_MM / 1e3, force)
    point = place + moved.turned.apply(ARM_MM)
    names = [f"jaw_{end}" for end in ("tx", "ty", "tz", "rz", "ry", "rx")]
    loads = [f"jaw_force_{kind}{axis}" for kind in "vp" for axis in "xyz"]
    load = np.column_stack([force @ AXES, point @ AXES / 1e3, moment @ AXES])
    return names, motion, [*loads, *(f"jaw_torque_{axis}" for axis in "xyz")], load


@pytest.mark.parametrize("apart", [False, True])
def test_moments_about_a_point_are_carried_to_the_mouthpiece(tmp_path, apart):
    moved = files.jaw()
    names, motion, loads, load = motion_and_forces(moved)
    time = moved.time[:, None]
    if apart:
        storage(tmp_path / "a.mot", names, np.hstack([time, motion]))
        asked = {"forces": storage(tmp_path / "f.mot", loads, np.hstack([time, load])), "offset_s": 0.0}
    else:
        storage(tmp_path / "a.mot", [*names, *loads], np.hstack([time, motion, load]))
        asked = {}
    import_file(tmp_path / "a.mot", tmp_path / "out.csv", ImportSettings(registered=True, **asked))
    np.testing.assert_allclose(load_record(tmp_path / "out.csv").samples[:, 0], moved.wrench[:-1], atol=1e-6)


def test_a_force_at_a_point_needs_no_moment_and_numbered_ones_are_known(tmp_path):
    moved = files.jaw()
    names, motion, loads, load = motion_and_forces(moved)
    own = [name.replace("jaw_force_", "ground_force_1_") for name in loads[:6]]
    storage(tmp_path / "a.mot", [*names, *own], np.hstack([moved.time[:, None], motion, load[:, :6]]))
    import_file(tmp_path / "a.mot", tmp_path / "out.csv", ImportSettings(registered=True))
    free = np.cross(ARM_MM / 1e3, moved.wrench[:-1, :3])
    np.testing.assert_allclose(load_record(tmp_path / "out.csv").samples[:, 0, 3:], free, atol=1e-6)
    storage(tmp_path / "a.mot", [*names, *own[:4]], np.hstack([moved.time[:, None], motion, load[:, :4]]))
    with pytest.raises(InputError, match="column 'ground_force_1_py' is missing; allowed: all of its group"):
        import_file(tmp_path / "a.mot", tmp_path / "out.csv", ImportSettings(registered=True))


GLOBAL = {"SpatialAxes": "ALS", "RotationOrder": "ZXY", "RotationRule": "right-hand"}
"""The example of the specification."""


def bids(folder, channels, columns, levels=None, **about):
    """The four files, written by pandas; a channel is (name, component, type, tracked point, units, frame)."""
    stem = folder / "sub-1_task-chew_tracksys-omc"
    names = ["name", "component", "type", "tracked_point", "units", "reference_frame"]
    extra = {key: values for key, values in about.items() if isinstance(values, list)}
    table = pd.DataFrame(channels, columns=names).assign(**extra)
    table.to_csv(f"{stem}_channels.tsv", sep="\t", index=False, na_rep="n/a")
    path = folder / f"{stem.name}_motion.tsv"
    pd.DataFrame(columns).to_csv(path, sep="\t", index=False, header=False, na_rep="n/a")
    words = {"TaskName": "chew", "SamplingFrequency": 60} | {k: v for k, v in about.items() if k not in extra}
    (folder / f"{stem.name}_motion.json").write_text(json.dumps(words))
    if levels is not None:
        (folder / f"{stem.name}_channels.json").write_text(json.dumps({"reference_frame": {"Levels": levels}}))
    return path


def body(point, frame, kinds=("x", "y", "z"), unit="deg"):
    rows = [(f"{point}_{axis}", axis, "POS", point, "mm", frame) for axis in "xyz"]
    return rows + [(f"{point}_{kind}", kind, "ORNT", point, unit, frame) for kind in kinds]


def turned_body(order="ZXY"):
    rng = np.random.default_rng(0)
    turned, place = files.Rotation.random(20, rng=rng), rng.normal(size=(20, 3))
    angles = dict(zip(order.lower(), turned.as_euler(order.lower(), degrees=True).T, strict=True))
    return turned, place, np.column_stack([place, *(angles[axis] for axis in "xyz")])


def test_stated_times_go_before_an_effective_rate_and_that_before_a_nominal_one(tmp_path):
    _, _, columns = turned_body()
    local = {"global": GLOBAL, "local": {"Description": "Joint angles"}}
    path = bids(tmp_path, body("jaw", "global"), columns, local, SamplingFrequencyEffective=60.00197437)
    np.testing.assert_allclose(read_bids_motion(path, None).time, np.arange(20) / 60.00197437)
    path = bids(tmp_path, body("jaw", "global"), columns, local, SamplingFrequencyEffective="n/a")
    np.testing.assert_allclose(read_bids_motion(path, None).time, np.arange(20) / 60)
    stamps = np.cumsum(np.random.default_rng(1).uniform(0.01, 0.02, 20))
    channels = [*body("jaw", "global"), ("t", "n/a", "LATENCY", "n/a", "s", "n/a")]
    path = bids(tmp_path, channels, np.column_stack([columns, stamps]), local)
    np.testing.assert_allclose(read_bids_motion(path, None).time, stamps)


@pytest.mark.parametrize("order", ["ZXY", "XYZ", "YZX"])
def test_euler_angles_follow_the_order_about_axes_at_rest(tmp_path, order):
    turned, place, columns = turned_body(order)
    path = bids(tmp_path, body("jaw", "global"), columns, {"global": GLOBAL | {"RotationOrder": order}})
    tracks = read_bids_motion(path, None)
    np.testing.assert_allclose(tracks.rotations["jaw"], turned.as_matrix(), atol=1e-9)
    np.testing.assert_allclose(tracks.places["jaw"], place, atol=1e-9)
    np.testing.assert_array_equal(tracks.axes["jaw"], np.eye(3))
    radians = np.column_stack([place, np.radians(columns[:, 3:])])
    path = bids(tmp_path, body("jaw", "global", unit="rad"), radians, {"global": GLOBAL | {"RotationOrder": order}})
    np.testing.assert_allclose(read_bids_motion(path, None).rotations["jaw"], turned.as_matrix(), atol=1e-9)


def test_left_handed_axes_and_rules_are_turned_to_the_same_motion(tmp_path):
    turned, place, _ = turned_body()
    kinds = ("quat_w", "quat_x", "quat_y", "quat_z")
    mirror = np.diag([1.0, -1.0, 1.0])  # from ALS to ARS
    for axes, rule in (("ALS", "right-hand"), ("ALS", "left-hand"), ("ARS", "right-hand"), ("ARS", "left-hand")):
        change = np.eye(3) if axes == "ALS" else mirror
        seen = files.Rotation.from_matrix(change @ turned.as_matrix() @ change)
        own = seen if (axes == "ARS") == (rule == "left-hand") else seen.inv()
        columns = np.column_stack([place @ change, own.as_quat(scalar_first=True)])
        path = bids(tmp_path, body("jaw", "g", kinds), columns, {"g": {"SpatialAxes": axes, "RotationRule": rule}})
        beside = read_bids_motion(path, None).beside("jaw")
        np.testing.assert_allclose(beside.rotations["jaw"], turned.as_matrix(), atol=1e-9)
        np.testing.assert_allclose(beside.places["jaw"], place, atol=1e-9)
    path = bids(tmp_path, body("jaw", "g", kinds), columns, {"g": {"SpatialAxes": "ARS"}})
    with pytest.raises(InputError, match="RotationRule is missing; allowed with left-handed axes"):
        read_bids_motion(path, None)


def test_each_body_is_in_the_frame_of_its_channels(tmp_path):
    turned, place, columns = turned_body()
    levels = {"global": GLOBAL, "tilted": GLOBAL | {"SpatialAxes": "SAL"}, "spoken": "as the camera sees it"}
    channels = [*body("jaw", "tilted"), *body("hand", "global")]
    tracks = read_bids_motion(bids(tmp_path, channels, np.hstack([columns, columns]), levels), None)
    assert list(tracks.beside("jaw").places) == ["jaw"]
    np.testing.assert_allclose(tracks.beside("jaw").places["jaw"], place[:, [1, 2, 0]], atol=1e-9)
    spoken = body("jaw", "spoken", ("quat_w", "quat_x", "quat_y", "quat_z"))
    quaternions = np.column_stack([place, turned.as_quat(scalar_first=True)])
    assert "jaw" not in read_bids_motion(bids(tmp_path, spoken, quaternions, levels), None).axes
    with pytest.raises(InputError, match="RotationOrder is missing; allowed with angles"):
        read_bids_motion(bids(tmp_path, body("jaw", "spoken"), columns, levels), None)


def test_missing_values_bad_channels_and_other_rates_are_heeded(tmp_path):
    _, _, columns = turned_body()
    columns[3, 0] = -999.0
    levels = {"global": GLOBAL}
    tracks = read_bids_motion(bids(tmp_path, body("jaw", "global"), columns, levels, MissingValues="-999"), None)
    assert np.isnan(tracks.places["jaw"][:, 0]).nonzero()[0].tolist() == [3]
    path = bids(tmp_path, body("jaw", "global"), columns, levels, status=["bad", *["good"] * 5])
    assert np.isnan(read_bids_motion(path, None).places["jaw"][:, 0]).all()
    with pytest.raises(InputError, match="has the sampling_frequency '30'; allowed: the file's 60 Hz"):
        read_bids_motion(
            bids(tmp_path, body("jaw", "global"), columns, levels, sampling_frequency=[60] * 5 + [30]), None
        )


def test_a_body_at_zero_that_is_not_turned_is_lost(tmp_path):
    place, turned = np.ones((5, 3)), np.tile(np.eye(3), (5, 1, 1))
    place[3] = 0.0
    seen = Tracks("here", np.arange(5.0), {"jaw": place}, {"jaw": turned}).places["jaw"]
    assert np.isnan(seen).all(axis=1).tolist() == [False, False, False, True, False]
    place[0] = 0.0  # its motion since the beginning
    assert np.isfinite(Tracks("here", np.arange(5.0), {"jaw": place}, {"jaw": turned}).places["jaw"]).all()
