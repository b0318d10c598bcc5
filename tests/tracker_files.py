"""A jaw's motion as trackers see it, and their files as their own libraries, or a few lines, write them."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from jawenv.anatomy.mandible import default_mandible
from jawenv.recordings.columns import READINGS

HZ, SECONDS = 100.0, 6.0
TEETH_MM, MOUTHPIECE_MM = 1e3 * default_mandible().teeth_m, 1e3 * default_mandible().mouthpiece_m
TURN = Rotation.from_euler("xyz", [0.4, -0.7, 1.1])  # from head axes to the tracker's
SHIFT_MM = np.array([120.0, -340.0, 900.0])
TRIPOD_MM = np.array([[10.0, 5.0, 0.0], [-12.0, 3.0, 4.0], [2.0, -14.0, 9.0]])


@dataclass
class Jaw:
    """Opening twice, closed at first: times, rotation and mouthpiece (mm) in head axes, wrench in body axes."""

    time: np.ndarray
    turned: Rotation
    slide: np.ndarray

    def place(self, point):
        """(T, 3) mm, head axes, of a point of the mandible given with the jaw closed."""
        return self.turned.apply(point) + self.slide

    @property
    def wrench(self):
        drop = self.place(MOUTHPIECE_MM)[:, 2] - MOUTHPIECE_MM[2]
        return np.column_stack([0.02 * drop, 0.0 * drop, 0.3 * drop, 1e-4 * drop, 0.0 * drop, 2e-4 * drop])

    def columns(self, noise_mm=0.0, clock_s=0.0):
        """What a device writes on a clock of its own: its force, and where it believes the mouthpiece."""
        noise = noise_mm * np.random.default_rng(1).normal(size=len(self.time))
        columns = {"time_s": self.time + clock_s, "mouthpiece_z_mm": self.place(MOUTHPIECE_MM)[:, 2] + noise}
        return columns | {column.name: values for column, values in zip(READINGS, self.wrench.T, strict=True)}


def jaw(periodic=False):
    time = np.arange(0.0, SECONDS, 1.0 / HZ)
    phase = np.maximum(time - 0.2, 0.0)
    opened = (
        np.sin(2.0 * np.pi * phase) ** 2 if periodic else np.sin(0.9 * phase) ** 2 + 0.3 * np.sin(0.6 * phase**2) ** 2
    )
    angles = np.radians(np.column_stack([18.0 * opened, 2.0 * opened, -1.0 * opened]))
    return Jaw(time, Rotation.from_euler("YZX", angles), np.array([6.0, 0.5, -2.0]) * opened[:, None])


def in_tracker(points):
    return TURN.apply(points) + SHIFT_MM


def seen_jaw(moved):
    """Rotation and origin (mm) of a mandibular body in the tracker's axes, whose own axes lie anyhow."""
    own = Rotation.from_euler("xyz", [1.0, 0.2, -0.5])
    return TURN * moved.turned * own, in_tracker(moved.place(np.array([70.0, 5.0, -50.0])))


def markers(moved, head_moves=True):
    """(T, 3) mm of three markers on the jaw and three on the head, which nods and drifts."""
    on_jaw = {f"J{i}": in_tracker(moved.place(MOUTHPIECE_MM + TRIPOD_MM[i])) for i in range(3)}
    on_head = {
        f"H{i}": np.tile(in_tracker([0.0, 0.0, 90.0] + 3.0 * TRIPOD_MM[i]), (len(moved.time), 1)) for i in range(3)
    }
    if not head_moves:
        return on_jaw | on_head
    since = np.maximum(moved.time - 0.2, 0.0)[:, None]
    nod, drift = Rotation.from_rotvec(np.sin(since) * [0.05, 0.1, -0.03]), since * [1.0, 2.0, -1.5]
    return {name: nod.apply(places) + drift for name, places in (on_jaw | on_head).items()}


def write_landmarks(path, error_mm=0.0, turn=in_tracker):
    shifts = error_mm * np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    names = ("incisor", "molar_left", "molar_right")
    rows = [f"{name} = {place.tolist()}" for name, place in zip(names, turn(TEETH_MM + shifts), strict=True)]
    path.write_text("\n".join(rows), encoding="utf-8")
    return path


def write_csv(path, columns):
    rows = [
        ",".join(columns),
        *(",".join(f"{value:.9g}" for value in row) for row in np.column_stack([*columns.values()])),
    ]
    path.write_text("\n".join(rows), encoding="utf-8")
    return path


def write_c3d(path, moved, unit="mm"):
    import ezc3d

    points = markers(moved)
    file = ezc3d.c3d()
    parameters = file["parameters"]["POINT"]
    parameters["RATE"]["value"], parameters["LABELS"]["value"], parameters["UNITS"]["value"] = (
        [HZ],
        tuple(points),
        [unit],
    )
    data = np.ones((4, len(points), len(moved.time)))
    data[:3] = np.stack([*points.values()]).transpose(2, 0, 1)
    file["data"]["points"] = data
    file.write(str(path))
    return path


def write_trc(path, moved, unit="mm"):
    points, count = markers(moved), len(moved.time)
    head = [
        f"PathFileType\t4\t(X/Y/Z)\t{path.name}",
        "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames",
        f"{HZ:g}\t{HZ:g}\t{count}\t{len(points)}\t{unit}\t{HZ:g}\t1\t{count}",
        "Frame#\tTime\t" + "\t\t\t".join(points) + "\t\t",
        "\t\t" + "\t".join(f"{axis}{i + 1}" for i in range(len(points)) for axis in "XYZ"),
        "",
    ]
    rows = np.column_stack([np.arange(1, count + 1), moved.time, *points.values()])
    body = ["\t".join([f"{row[0]:.0f}", *(f"{value:.7g}" for value in row[1:])]) for row in rows]
    path.write_text("\n".join([*head, *body, ""]), encoding="utf-8")
    return path


def write_hdf5(path, moved, unit="mm", scale=1.0, quaternions=True):
    import h5py

    turned, place = seen_jaw(moved)
    with h5py.File(path, "w") as file:
        group = file.create_group("T_model_origin_mand_landmark_t")
        group.create_dataset("translations", data=scale * place)
        group.create_dataset("rotations", data=turned.as_quat(scalar_first=True) if quaternions else turned.as_matrix())
        group.attrs["sample_rate"] = HZ
        if unit:
            group.attrs["unit"] = unit
    return path


def write_mot(path, moved, degrees="yes", name="mandible"):
    turned, place = seen_jaw(moved)
    angles = turned.as_euler("ZYX", degrees=degrees == "yes")
    names = [f"{name}_{end}" for end in ("tx", "ty", "tz", "rz", "ry", "rx")]
    table = np.column_stack([moved.time, place / 1e3, angles])
    head = ["motion", "version=1", f"nRows={len(table)}", "nColumns=7", f"inDegrees={degrees}", "endheader"]
    rows = ["\t".join(f"{value:.9g}" for value in row) for row in table]
    path.write_text("\n".join([*head, "\t".join(["time", *names]), *rows, ""]), encoding="utf-8")
    return path
