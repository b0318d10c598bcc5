"""Trackers' files of one motion, imported with forces of the same clock."""

import numpy as np

from jawenv.recordings.files import load_record
from jawenv.trackers.importing import ImportSettings, import_file
from tests import tracker_files as files

MARKERS = {"jaw": "J0,J1,J2", "head": "H0,H1,H2"}
FORMATS = {
    "c3d": (files.write_c3d, "chew.c3d", MARKERS),
    "trc": (files.write_trc, "chew.trc", MARKERS),
    "hdf5": (files.write_hdf5, "chew.h5", {}),
    "mot": (files.write_mot, "chew.mot", {}),
    "sto": (files.write_mot, "chew.sto", {}),
}


def imported(folder, kind, spoil=None, landmarks=None, write=None, **settings):
    """The lines and the recording of a file of this format, with forces of the same clock."""
    usual, name, named = FORMATS[kind]
    path, moved = folder / name, files.jaw()
    (write or usual)(path, moved)
    if spoil is not None:
        spoil(path)
    asked = {"forces": files.write_csv(folder / "forces.csv", moved.columns()), "offset_s": 0.0, **named, **settings}
    if "registered" not in asked:
        asked["landmarks"] = landmarks or files.write_landmarks(folder / "landmarks.toml")
    lines = import_file(path, folder / "out.csv", ImportSettings(**asked))
    return lines, load_record(folder / "out.csv")


def assert_same_motion(record, moved, atol_mm):
    np.testing.assert_allclose(1e3 * record.measured[:, :3], moved.place(files.MOUTHPIECE_MM), atol=atol_mm)
    np.testing.assert_allclose(record.measured[:, 3:6], moved.turned.as_euler("YZX"), atol=2e-3 * atol_mm + 1e-6)
    np.testing.assert_allclose(record.samples[:, 0], moved.wrench[:-1], atol=1e-6)
