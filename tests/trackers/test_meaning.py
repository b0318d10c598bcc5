"""Columns and keys of a tracker's file that change what others mean."""

import numpy as np
import pytest

from jawenv.base.errors import InputError
from jawenv.recordings.files import load_record
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


def test_a_body_at_zero_that_is_not_turned_is_lost(tmp_path):
    place, turned = np.ones((5, 3)), np.tile(np.eye(3), (5, 1, 1))
    place[3] = 0.0
    seen = Tracks("here", np.arange(5.0), {"jaw": place}, {"jaw": turned}).places["jaw"]
    assert np.isnan(seen).all(axis=1).tolist() == [False, False, False, True, False]
    place[0] = 0.0  # its motion since the beginning
    assert np.isfinite(Tracks("here", np.arange(5.0), {"jaw": place}, {"jaw": turned}).places["jaw"]).all()
