"""Files of jaw trackers: the motion comes back from each format, and a spoilt file is refused in one line."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from jawenv.base.errors import InputError
from jawenv.commands.app import main
from jawenv.recordings.columns import READINGS
from jawenv.recordings.files import load_record, save_record
from jawenv.recordings.plausibility import findings
from jawenv.trackers.clocks import clock_offset
from jawenv.trackers.importing import ImportSettings, import_file
from tests import tracker_files as files
from tests.recorded import opening
from tests.tracker_imports import FORMATS, assert_same_motion, imported

pytest.importorskip("ezc3d")
pytest.importorskip("h5py")


@pytest.mark.parametrize("kind", FORMATS)
def test_every_format_gives_the_motion_in_head_axes(kind, tmp_path):
    lines, record = imported(tmp_path, kind)
    assert_same_motion(record, files.jaw(), 1e-2)  # C3D has 32 bits, texts seven digits
    assert lines[0].startswith("landmarks: ") and lines[-1].endswith("out.csv: 600 rows")
    assert any(line.startswith("markers: ") for line in lines) == (kind in ("c3d", "trc"))
    assert all(finding.plausible for finding in findings(record))


def test_units_angles_and_matrices_are_those_that_the_file_states(tmp_path):
    metres = {"write": lambda path, moved: files.write_hdf5(path, moved, "m", 1e-3, quaternions=False)}
    assert_same_motion(imported(tmp_path, "hdf5", **metres)[1], files.jaw(), 1e-4)
    silent = {"write": lambda path, moved: files.write_hdf5(path, moved, None, 0.1)}
    assert_same_motion(imported(tmp_path, "hdf5", **silent, unit="cm")[1], files.jaw(), 1e-4)
    radians = {"write": lambda path, moved: files.write_mot(path, moved, "no")}
    assert_same_motion(imported(tmp_path, "mot", **radians)[1], files.jaw(), 1e-4)


def test_landmarks_state_their_residual_and_may_be_markers(tmp_path):
    lines, record = imported(tmp_path, "hdf5", landmarks=files.write_landmarks(tmp_path / "off.toml", 3.0))
    teeth = files.TEETH_MM - files.TEETH_MM.mean(axis=0)
    shifted = teeth + 3.0 * np.array([[1.0, 0, 0], [-1.0, 0, 0], [0, 0, 0]])
    distance = Rotation.align_vectors(teeth, shifted - shifted.mean(axis=0))[1] / np.sqrt(3.0)
    assert f"{distance:.2g} mm" in lines[0]
    np.testing.assert_allclose(1e3 * record.measured[0, :3], files.MOUTHPIECE_MM, atol=1e-3)

    (tmp_path / "names.toml").write_text('incisor = "J0"\nmolar_left = "J1"\nmolar_right = "H9"\n')
    with pytest.raises(InputError, match=r"molar_right is 'H9'; allowed: three numbers, or a marker"):
        imported(tmp_path, "trc", landmarks=tmp_path / "names.toml")


def test_a_gap_of_the_tracker_is_an_empty_cell(tmp_path):
    def lose(path):
        lines = path.read_text().splitlines()
        cells = lines[100].split("\t")
        cells[2:5] = ["", "", ""]
        path.write_text("\n".join([*lines[:100], "\t".join(cells), *lines[101:]]))

    record = imported(tmp_path, "trc", lose)[1]
    assert np.isnan(record.measured[:, :6]).all(axis=1).nonzero()[0].tolist() == [94]


def replaced(old, new):
    """Spoils a text file."""

    def spoil(path):
        text = path.read_text()
        assert old in text
        path.write_text(text.replace(old, new, 1))

    return spoil


def written(write, *arguments):
    return lambda path: write(path, files.jaw(), *arguments)


def mirrored(path):
    import h5py

    with h5py.File(path, "a") as file:
        group = file["T_model_origin_mand_landmark_t"]
        turned = Rotation.from_quat(group["rotations"][:], scalar_first=True).as_matrix()
        del group["rotations"]
        group["rotations"] = turned * [1.0, 1.0, -1.0]


def without(name):
    def spoil(path):
        import h5py

        with h5py.File(path, "a") as file:
            del file["T_model_origin_mand_landmark_t"][name]

    return spoil


UPSIDE_DOWN = "pitch_deg: -.* allowed: -5 to 45 deg"


@pytest.mark.parametrize(
    ("kind", "spoil", "settings", "message"),
    [
        ("c3d", written(files.write_c3d, "m"), {}, "the mouthpiece moves .* allowed: 2 to 100 mm"),
        ("c3d", written(files.write_c3d, ""), {}, "states no unit of length; allowed: --unit"),
        ("c3d", None, {"jaw": "J0,J1,J9"}, "is 'J9'; allowed: J0, J1"),
        ("c3d", None, {"jaw": "J0,J1,H2"}, "move .* mm against each other"),
        ("c3d", None, {"head": None}, "--head is missing; allowed: fixed, or markers among J0"),
        ("trc", written(files.write_trc, "ft"), {}, "has unit 'ft'; allowed: mm"),
        ("trc", replaced("J2\t", "\t"), {}, "has 5 markers; allowed: '6'"),
        ("hdf5", written(files.write_hdf5, "m"), {}, "the mouthpiece moves .* allowed: 2 to 100 mm"),
        ("hdf5", written(files.write_hdf5, None), {}, "states no unit of length; allowed: --unit"),
        ("hdf5", mirrored, {}, "mirror or scale; allowed: proper rotations"),
        ("hdf5", without("rotations"), {}, "data set 'rotations' is missing"),
        ("mot", replaced("inDegrees=yes", ""), {}, "inDegrees is ''; allowed: yes or no"),
        ("mot", replaced("mandible_rz", "mandible_tx"), {}, "a column stands there twice"),
        ("mot", None, {"unit": "mm"}, "the mouthpiece moves .* allowed: 2 to 100 mm"),
        ("mot", replaced("mandible_rx", "mandible_qx"), {}, "column 'mandible_rx' is missing"),
        ("mot", None, {"registered": True}, "the mouthpiece moves|mouthpiece_.* allowed: within 30 mm"),
    ],
)
def test_a_spoilt_file_is_refused_or_asked_about_in_one_line(kind, spoil, settings, message, tmp_path):
    with pytest.raises(InputError, match=message) as refused:
        imported(tmp_path, kind, spoil, **settings)
    assert "\n" not in str(refused.value) and not (tmp_path / "out.csv").exists()


@pytest.mark.parametrize(
    ("landmarks", "message"),
    [
        ("swapped", UPSIDE_DOWN),
        ("metres", "times as far apart as ours"),
        ("incisor = [0, 0, 0]", "molar_left is missing"),
        ("incisor = [0, 0]\nmolar_left = [0, 0, 0]\nmolar_right = [0, 0, 0]", "three numbers"),
        ("canine = [0, 0, 0]", "landmark is 'canine'"),
    ],
)
def test_landmarks_that_cannot_be_are_refused(landmarks, message, tmp_path):
    path = files.write_landmarks(tmp_path / "own.toml")
    text = path.read_text()
    swapped = text.replace("left", "x").replace("right", "left").replace("x", "right")
    path.write_text({"swapped": swapped, "metres": f'unit = "m"\n{text}'}.get(landmarks, landmarks))
    with pytest.raises(InputError, match=message):
        imported(tmp_path, "hdf5", landmarks=path)


def test_the_clock_of_the_forces_is_found_within_its_stated_error(tmp_path):
    moved = files.jaw()
    columns = {name: values[40:] for name, values in moved.columns(noise_mm=0.2, clock_s=3.2171).items()}
    forces = files.write_csv(tmp_path / "late.csv", columns)
    lines, record = imported(tmp_path, "hdf5", forces=forces, offset_s=None)
    words = next(line for line in lines if line.startswith("clocks: ")).split()
    seconds, sd_s = float(words[1]), 1e-3 * float(words[6])
    assert abs(seconds - 3.2171) < 3.0 * sd_s < 3e-3
    assert len(record.time) in (559, 560)
    np.testing.assert_allclose(record.samples[:500, 0], moved.wrench[40:540], atol=0.15)


def test_errors_of_the_offset_are_as_large_as_stated():
    moved, rng = files.jaw(), np.random.default_rng(3)
    signal = moved.place(files.MOUTHPIECE_MM)[:, 2]
    shares = []
    for _ in range(40):
        offset = clock_offset(moved.time, signal, moved.time + 0.333, signal + 0.5 * rng.normal(size=len(signal)))
        shares.append((offset.seconds - 0.333) / offset.sd_s)
    assert 0.6 < np.std(shares) < 1.5 and abs(np.mean(shares)) < 0.6


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (
            lambda columns: {**columns, "mouthpiece_z_mm": -columns["mouthpiece_z_mm"]},
            "correlate by .* at best|fit alike",
        ),
        (lambda columns: {k: v for k, v in columns.items() if k != "mouthpiece_z_mm"}, "no column shows the motion"),
        (lambda columns: {k: v for k, v in columns.items() if k != "moment_y_N_m"}, "'moment_y_N_m' is missing"),
        (lambda columns: {**columns, "force_z_N": 1e3 * columns["force_z_N"]}, r"force_\*_N: .* newtons"),
    ],
)
def test_forces_that_do_not_fit_are_refused(spoil, message, tmp_path):
    forces = files.write_csv(tmp_path / "own.csv", spoil(files.jaw().columns()))
    with pytest.raises(InputError, match=message):
        imported(tmp_path, "hdf5", forces=forces, offset_s=None)


def test_a_motion_that_repeats_itself_does_not_tell_the_offset():
    moved = files.jaw(periodic=True)
    signal = moved.place(files.MOUTHPIECE_MM)[:, 2]
    noise = 0.1 * np.random.default_rng(0).normal(size=len(signal))
    with pytest.raises(InputError, match="fit alike; allowed: --offset SECONDS"):
        clock_offset(moved.time[100:], signal[100:], moved.time, signal + noise)


@pytest.mark.parametrize("name", ["out.mot", "out.sto"])
def test_a_recording_comes_back_from_the_formats_that_are_written(name, tmp_path):
    record = opening().records[0]
    save_record(record, tmp_path / "recording.csv")
    assert main(["import", str(tmp_path / "recording.csv"), "-o", str(tmp_path / name)]) == 0
    assert main(["import", str(tmp_path / name), "--registered", "-o", str(tmp_path / "back.csv")]) == 0
    back = load_record(tmp_path / "back.csv")
    np.testing.assert_allclose(back.measured[:, :6], record.measured[:, :6], atol=1e-9)
    np.testing.assert_allclose(back.samples[:, 0], record.samples[:, 0], atol=1e-9)


def test_opensim_points_up_with_its_second_axis(tmp_path):
    save_record(opening().records[0], tmp_path / "recording.csv")
    import_file(tmp_path / "recording.csv", tmp_path / "out.mot", ImportSettings())
    lines = (tmp_path / "out.mot").read_text().splitlines()
    names = lines[lines.index("endheader") + 1].split("\t")
    row = dict(zip(names, map(float, lines[-2].split("\t")), strict=True))
    last = opening().records[0]
    x, y, z = last.measured[-2, :3]
    assert (row["jaw_tx"], row["jaw_ty"], row["jaw_tz"]) == pytest.approx((x, z, -y), abs=1e-9)
    assert row["jaw_rz"] == pytest.approx(-np.degrees(last.measured[-2, 3]), abs=1e-6)
    assert row["jaw_force_vy"] == pytest.approx(last.samples[-1, 0, 2], abs=1e-9)


def test_a_tracked_patient_is_identified(tmp_path, capsys):
    """A patient who bites together, rests, and is moved: a tracker sees all, the device begins later."""
    record, closed = opening().records[0], 20
    turned = Rotation.from_euler("YZX", np.vstack([np.zeros((closed, 3)), record.measured[:, 3:6]]))
    mouthpiece = 1e3 * np.vstack([np.tile(files.MOUTHPIECE_MM / 1e3, (closed, 1)), record.measured[:, :3]])
    time = np.arange(len(turned)) * record.dt
    moved = files.Jaw(time, turned, mouthpiece - turned.apply(files.MOUTHPIECE_MM))
    files.write_hdf5(tmp_path / "chew.h5", moved)
    files.write_landmarks(tmp_path / "landmarks.toml")
    samples = np.vstack([record.samples[:, 0], record.samples[-1:, 2]])
    columns = {name: values[closed:] for name, values in moved.columns(clock_s=-7.5).items()}
    columns |= {column.name: values for column, values in zip(READINGS, samples.T, strict=True)}
    files.write_csv(tmp_path / "forces.csv", columns)
    given = ["--landmarks", str(tmp_path / "landmarks.toml"), "--forces", str(tmp_path / "forces.csv")]
    assert main(["import", str(tmp_path / "chew.h5"), "-o", str(tmp_path / "out.csv"), *given]) == 0
    assert "clocks: -7.500" in capsys.readouterr().out
    assert main(["identify", str(tmp_path / "out.csv")]) == 0
