"""Files as the libraries and programs write them that people write them with."""

import os
import struct

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

from jawenv.base.errors import InputError
from jawenv.recordings.columns import READINGS
from jawenv.recordings.files import load_record
from jawenv.trackers.c3d import read_c3d
from jawenv.trackers.importing import ImportSettings, import_file
from tests import tracker_files as files
from tests.tracker_imports import MARKERS, assert_same_motion, imported

ezc3d = pytest.importorskip("ezc3d")
h5py = pytest.importorskip("h5py")

ANALOG = ("Fx", "Fy", "Fz", "Mx", "My", "Mz")


def with_channels(path, names, units, scale, hz=1000.0):
    """A C3D file whose analog channels are the load cell's."""
    moved = files.jaw()
    file = ezc3d.c3d(str(files.write_c3d(path, moved)))
    parameters = file["parameters"]["ANALOG"]
    parameters["RATE"]["value"], parameters["LABELS"]["value"], parameters["UNITS"]["value"] = [hz], names, units
    at = np.arange(int(len(moved.time) * hz / files.HZ)) / hz
    wrench = np.column_stack([np.interp(at, moved.time, column) for column in moved.wrench.T])
    file["data"]["analogs"] = (wrench * scale).T[None]
    file.write(str(path))
    return moved


def test_forces_are_read_of_channels_that_are_named(tmp_path):
    named = [column.name for column in READINGS]
    moved = with_channels(tmp_path / "a.c3d", named, ["N"] * 3 + ["N m"] * 3, 1.0)
    asked = {"landmarks": files.write_landmarks(tmp_path / "l.toml"), **MARKERS}
    lines = import_file(tmp_path / "a.c3d", tmp_path / "out.csv", ImportSettings(**asked))
    assert "forces: of the file's own channels, 1000 Hz" in lines
    assert_same_motion(load_record(tmp_path / "out.csv"), moved, 1e-2)

    with_channels(tmp_path / "b.c3d", ANALOG, ["N"] * 3 + ["Nmm"] * 3, [1, 1, 1, 1e3, 1e3, 1e3])
    with pytest.raises(InputError, match=r"has the channels Fx, .*; allowed: --columns FILE .* or --forces FILE"):
        import_file(tmp_path / "b.c3d", tmp_path / "b.csv", ImportSettings(**asked))
    rows = [
        f'{name} = {{name = "{own}", unit = "{"N" if i < 3 else "N mm"}"}}'
        for i, (name, own) in enumerate(zip(named, ANALOG, strict=True))
    ]
    (tmp_path / "map.toml").write_text("\n".join(rows))
    import_file(tmp_path / "b.c3d", tmp_path / "b.csv", ImportSettings(**asked, columns=tmp_path / "map.toml"))
    np.testing.assert_allclose(load_record(tmp_path / "b.csv").samples[:, 0], moved.wrench[:-1], atol=1e-5)


def test_more_frames_than_a_header_counts_are_read(tmp_path):
    file = ezc3d.c3d()
    parameters = file["parameters"]["POINT"]
    parameters["RATE"]["value"], parameters["LABELS"]["value"], parameters["UNITS"]["value"] = [240.0], ("A",), ["MM"]
    file["data"]["points"] = np.arange(4.0 * 70_001).reshape(4, 1, -1) + 1.0
    file.write(str(tmp_path / "long.c3d"))
    tracks = read_c3d(tmp_path / "long.c3d", None)
    assert len(tracks.time) == 70_001 and tracks.places["A"][-1, 0] == 70_001.0


def test_markers_of_one_name_are_told_apart(tmp_path):
    file = ezc3d.c3d(str(files.write_c3d(tmp_path / "a.c3d", files.jaw())))
    file["parameters"]["POINT"]["LABELS"]["value"] = ("J0", "J1", "J0", "H0", "H1", "H2")
    file.write(str(tmp_path / "a.c3d"))
    assert list(read_c3d(tmp_path / "a.c3d", None).places)[:3] == ["J0 (1)", "J1", "J0 (2)"]


def dec(values):
    """Floats as a VAX writes them."""
    halves = np.asarray(4.0 * np.asarray(values), "<f4").view("<u2").reshape(-1, 2)
    return halves[:, ::-1].tobytes()


FLOATS = {
    84: lambda values: np.asarray(values, "<f4").tobytes(),
    85: dec,
    86: lambda values: np.asarray(values, ">f4").tobytes(),
}


def by_hand(path, processor, scale, points):
    """A C3D file (T, n, 3) of another processor, or of integers where ``scale`` is positive."""
    order, floats = ">" if processor == 86 else "<", FLOATS[processor]
    frames, count = points.shape[:2]

    def parameter(name, kind, sizes, data):
        body = struct.pack("bB", kind, len(sizes)) + bytes(sizes) + data + b"\0"
        return struct.pack("bb", len(name), 1) + name + struct.pack(order + "H", 2 + len(body)) + body

    group = struct.pack("bb", 5, -1) + b"POINT" + struct.pack(order + "H", 3) + b"\0"
    named = [
        parameter(b"SCALE", 4, [], floats([scale])),
        parameter(b"RATE", 4, [], floats([100.0])),
        parameter(b"UNITS", -1, [2], b"mm"),
        parameter(b"LABELS", -1, [4, count], b"".join(f"P{i}  ".encode() for i in range(count))),
    ]
    section = (bytes([1, 80, 1, processor]) + group + b"".join(named)).ljust(512, b"\0")
    header = bytes([2, 80]) + struct.pack(order + "5H", count, 0, 1, frames, 0) + floats([scale])
    header += struct.pack(order + "2H", 3, 0) + floats([100.0])
    rows = np.dstack([points / (scale if scale > 0.0 else 1.0), np.zeros((frames, count))])
    data = floats(rows.ravel()) if scale < 0.0 else np.asarray(np.round(rows), order + "i2").tobytes()
    path.write_bytes(header.ljust(512, b"\0") + section + data)


@pytest.mark.parametrize("processor", FLOATS)
@pytest.mark.parametrize("scale", [-1.0, 0.05])
def test_c3d_of_all_processors_and_of_integers(tmp_path, processor, scale):
    points = np.random.default_rng(0).uniform(-900.0, 900.0, (20, 3, 3))
    by_hand(tmp_path / "a.c3d", processor, scale, points)
    places = read_c3d(tmp_path / "a.c3d", None).places
    np.testing.assert_allclose(np.stack([*places.values()], axis=1), points, atol=1e-4 if scale < 0 else 0.026)


def test_hdf5_with_texts_as_bytes_arrays_of_one_and_other_things_beside(tmp_path):
    def write(path, moved):
        files.write_hdf5(path, moved)
        with h5py.File(path, "a") as file:
            group = file["T_model_origin_mand_landmark_t"]
            group.attrs["sample_rate"], group.attrs["unit"] = np.array([100.0]), b"mm"
            file["notes"], file["dead"], file["n"] = "a text", h5py.SoftLink("/nowhere"), 3.0
            file["away"] = h5py.ExternalLink(str(tmp_path / "none.h5"), "/x")
            file.create_group("empty")
            smooth = file.create_group("T_model_origin_mand_landmark_t_smooth")
            for name in ("translations", "rotations"):
                smooth[name] = group[name][:] * 1.0
            smooth.attrs["sample_rate"], smooth.attrs["unit"] = 100, np.array(["mm"], dtype=h5py.string_dtype())

    lines, record = imported(tmp_path, "hdf5", write=write)
    assert_same_motion(record, files.jaw(), 1e-2)
    assert not any("smooth" in line for line in lines)
    lines, _ = imported(tmp_path, "hdf5", write=write, jaw="T_model_origin_mand_landmark_t_smooth")
    assert "is smoothed, so error bars will be too small" in lines[0]


def test_a_smoothed_body_alone_is_asked_for(tmp_path):
    def rename(path):
        with h5py.File(path, "a") as file:
            file.move("T_model_origin_mand_landmark_t", "jaw_smooth")

    with pytest.raises(InputError, match=r"--jaw is missing; allowed: names among jaw_smooth \(what ends in _smooth"):
        imported(tmp_path, "hdf5", rename)


def test_storage_of_opensim_4_written_by_pandas(tmp_path):
    def write(path, moved):
        turned, place = files.seen_jaw(moved)
        names = [f"mandible_{end}" for end in ("tx", "ty", "tz", "rz", "ry", "rx")]
        table = pd.DataFrame(np.column_stack([place / 1e3, turned.as_euler("ZYX", degrees=True)]), columns=names)
        head = "inDegrees=Yes\nDataType=double\nversion=3\nOpenSimVersion=4.5\nendheader\n"
        path.write_text(head + table.set_axis(pd.Index(moved.time, name="time")).to_csv(sep="\t"))

    assert_same_motion(imported(tmp_path, "sto", write=write)[1], files.jaw(), 1e-4)


KINEMATICS = """{}

This file contains the kinematics (positions and orientations,
velocities and angular velocities, or accelerations and angular accelerations)
of the centers of mass of the body segments in model jaw.

Body segment orientations are described using body-fixed X-Y-Z Euler angles.

Units are S.I. units (seconds, meters, Newtons, ...)
If the header above contains a line with 'inDegrees', this indicates whether rotational values are in degrees (yes).

endheader
"""


@pytest.mark.parametrize(("title", "told"), [("Positions", ""), ("Velocities", "holds 'Velocities'; allowed: pos")])
def test_body_kinematics_written_by_numpy(tmp_path, title, told):
    def write(path, moved):
        turned, place = files.seen_jaw(moved)
        table = np.column_stack([moved.time, place / 1e3, turned.as_euler("XYZ", degrees=True)])
        head = KINEMATICS.format(f"{title}\nversion=1\nnRows={len(table)}\nnColumns=7\ninDegrees=yes")
        names = "\t".join(["time", *(f"jaw_{end}" for end in ("X", "Y", "Z", "Ox", "Oy", "Oz"))])
        np.savetxt(path, table, delimiter="\t", header=head + names, comments="")

    if told:
        with pytest.raises(InputError, match=told):
            imported(tmp_path, "sto", write=write)
    else:
        assert_same_motion(imported(tmp_path, "sto", write=write)[1], files.jaw(), 1e-4)


def test_trc_written_by_numpy_without_optional_words_and_in_capitals(tmp_path):
    def write(path, moved):
        points = files.markers(moved)
        table = np.column_stack([np.arange(len(moved.time)), np.round(moved.time, 3), *points.values()])
        names = "Frame#\tTime\t" + "\t\t\t".join(points)
        axes = "\t\t" + "\t".join(f"{axis}{i + 1}" for i in range(len(points)) for axis in "XYZ")
        head = f"PathFileType\t4\t(X/Y/Z)\ta.trc\nDataRate\tUnits\n100\tMM\n{names}\n{axes}"
        np.savetxt(path, table, delimiter="\t", header=head, comments="")

    assert_same_motion(imported(tmp_path, "trc", write=write)[1], files.jaw(), 1e-3)


def test_a_file_of_other_columns_is_refused_with_what_it_lacks(tmp_path):
    path = tmp_path / "states.sto"
    path.write_text("states\ninDegrees=no\nendheader\ntime\t/jointset/tmj/q/value\n0\t1\n0.01\t2\n")
    with pytest.raises(InputError, match="holds no body and no wrench, but time, /jointset/tmj/q/value; allowed: "):
        import_file(path, tmp_path / "out.csv", ImportSettings(registered=True))


@pytest.mark.parametrize("kind", ["c3d", "trc"])
def test_a_marker_at_zero_is_lost(tmp_path, kind):
    moved, points = files.jaw(), files.markers

    def lost(moved):
        places = points(moved)
        places["J1"][300] = 0.0
        return places

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(files, "markers", lost)
        record = imported(tmp_path, kind)[1]
    assert np.isnan(record.measured[:, :6]).all(axis=1).nonzero()[0].tolist() == [300]
    seen = np.delete(np.arange(600), 300)
    np.testing.assert_allclose(record.measured[seen, 3:6], moved.turned[seen].as_euler("YZX"), atol=1e-4)


def test_the_worst_row_of_markers_is_judged_too(tmp_path):
    points = files.markers

    def jumped(moved):
        places = points(moved)
        places["J1"][300] += [25.0, 0.0, 0.0]
        return places

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(files, "markers", jumped)
        with pytest.raises(InputError, match=r"J0, J1, J2 move \d.* mm against each other at 3 s; allowed: 5 mm"):
            imported(tmp_path, "trc")


def test_quaternions_of_any_size_are_rotations():
    from jawenv.trackers.tracks import matrices

    turned = Rotation.from_rotvec([[0.1, 0.2, 0.3]])
    for size in (1e-90, 1.0, 1e300):
        np.testing.assert_allclose(matrices(size * turned.as_quat(scalar_first=True)), turned.as_matrix(), atol=1e-12)
    assert np.isnan(matrices(np.array([[0.0, 0, 0, 0], [np.nan, 0, 0, 1], [1e-320, 0, 0, 0]]))).all()


def test_damaged_parameters_of_a_c3d_are_one_line(tmp_path):
    """Sizes of 255 end a program that believes them."""
    content = bytearray(files.write_c3d(tmp_path / "a.c3d", files.jaw()).read_bytes())
    at = content.find(b"LABELS") + 6
    for value in (0, 127, 128, 255):
        content[at : at + 6] = bytes([value] * 6)
        (tmp_path / "a.c3d").write_bytes(content)
        with pytest.raises(InputError) as refused:
            read_c3d(tmp_path / "a.c3d", None)
            raise InputError("a.c3d: lacks its labels")
        assert "\n" not in str(refused.value) and "a.c3d" in str(refused.value)


FOREIGN = {
    "external link": lambda file, other: file.__setitem__("jaw", h5py.ExternalLink(other, "/jaw")),
    "external storage": lambda file, other: spoil(file, external=[(other, 0, 600 * 24)]),
    "virtual data set": lambda file, other: spoil(file, virtual=other),
    "a billion rows": lambda file, other: spoil(file, shape=(10**9, 3), chunks=(1000, 3)),
    "texts": lambda file, other: spoil(file, dtype=h5py.string_dtype()),
    "references": lambda file, other: spoil(file, dtype=h5py.ref_dtype),
    "nothing": lambda file, other: file.move("T_model_origin_mand_landmark_t/rotations", "rotations"),
}


def spoil(file, virtual=None, shape=(600, 3), dtype="<f8", **settings):
    """Other translations in place of the right ones."""
    group = file["T_model_origin_mand_landmark_t"]
    del group["translations"]
    if virtual is not None:
        layout = h5py.VirtualLayout(shape, dtype)
        layout[:] = h5py.VirtualSource(virtual, "T_model_origin_mand_landmark_t/translations", shape)
        group.create_virtual_dataset("translations", layout)
    else:
        group.create_dataset("translations", shape, dtype, **settings)


@pytest.mark.parametrize("kind", FOREIGN)
def test_no_other_file_is_read_through_an_hdf5_file_and_no_bomb_unpacked(tmp_path, kind):
    other = tmp_path / "other.h5"
    if kind == "external link":  # a pipe: who follows the link waits for ever
        os.mkfifo(other)
    else:
        files.write_hdf5(other, files.jaw())

    def write(path, moved):
        files.write_hdf5(path, moved)
        with h5py.File(path, "a") as file:
            if kind == "external link":
                del file["T_model_origin_mand_landmark_t"]
            FOREIGN[kind](file, str(other))

    with pytest.raises(InputError) as refused:
        imported(tmp_path, "hdf5", write=write)
    assert "\n" not in str(refused.value) and not (tmp_path / "out.csv").exists()


def test_a_reader_that_hangs_or_dies_is_one_line(tmp_path, monkeypatch):
    from jawenv.trackers import jaw_tracking_system as module

    for program, told in (("while True: pass", "is not read within 0.5 s"), ("import os; os.abort()", "ended with -6")):
        (tmp_path / "program.py").write_text(program)
        monkeypatch.setattr(module.hdf5_groups, "__file__", str(tmp_path / "program.py"))
        monkeypatch.setattr(module, "SECONDS", 0.5 if "while" in program else 15)
        with pytest.raises(InputError, match=told):
            imported(tmp_path, "hdf5")
