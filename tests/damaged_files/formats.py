"""Every kind of file that the project reads from outside: a whole one of each, and what is read of it."""

import hashlib
import io
import json
import shutil
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from agents.evaluations import read_evaluations
from agents.policies import load_policy
from agents.replay import Replay
from eval.kept.tables import read_table
from eval.studies.design import read as read_study
from eval.studies.design import shipped as shipped_studies
from jawenv import Anatomy, Cohort, Device, Patient
from jawenv.playing.maneuvers import Maneuver
from jawenv.playing.maneuvers.maneuver import FOLDER as MANEUVERS
from jawenv.playing.policies.card import SHIPPED, read_card
from jawenv.reality.options import Reality
from jawenv.recordings.files import load_record
from jawenv.recordings.mapping import read_columns
from jawenv.trackers.importing import READERS
from jawenv.trackers.registration import read_landmarks
from jawenv.trackers.tracks import Tracks
from tests import tracker_files
from tests.damaged_files import contents
from training.run.config import TrainingConfig
from training.run.folder import read_counts

CONFIGS = Path(__file__).parents[2] / "training" / "configs"


@dataclass(frozen=True)
class Format:
    """A kind of file.

    Attributes:
        name: of the kind.
        file: the one that is damaged, in a folder of its own.
        make: writes all files into the folder.
        read: what the folder's files say, as something that can be compared.
        has_checksums: a damaged file is refused, or says the same; a text may say something else that is allowed.
        inner: what is damaged, of the file's content.
        put: writes the damaged content into the place of the file.
    """

    name: str
    file: str
    make: Callable[[Path], object]
    read: Callable[[Path], Any]
    has_checksums: bool = False
    inner: Callable[[bytes], bytes] = bytes
    put: Callable[[Path, bytes], object] = Path.write_bytes


def _text(name: str, file: str, text: str, read: Callable[[Path], Any]) -> Format:
    return Format(name, file, lambda folder: (folder / file).write_text(text), lambda folder: repr(read(folder / file)))


def _copied(name: str, source: Path, read: Callable[[Path], Any]) -> Format:
    return _text(name, source.name, source.read_text(encoding="utf-8"), read)


def _with_hash(path: Path, content: bytes) -> None:
    """Weights whose card has their hash."""
    path.write_bytes(content)
    card = path.parent / "card.json"
    fields = json.loads(card.read_text(encoding="utf-8"))
    card.write_text(json.dumps(fields | {"weights_sha256": hashlib.sha256(content).hexdigest()}), encoding="utf-8")


def _member(name: str) -> dict[str, Any]:
    """A member of an archive is damaged, and the archive is written anew: no checksum tells of it."""

    def inner(content: bytes) -> bytes:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            return archive.read(name)

    def put(path: Path, content: bytes) -> None:
        with zipfile.ZipFile(path) as archive:
            members = {each: archive.read(each) for each in archive.namelist()}
        with zipfile.ZipFile(path, "w") as archive:
            for each, held in (members | {name: content}).items():
                archive.writestr(each, held)

    return {"inner": inner, "put": put}


def _table(folder: Path) -> Any:
    frame, about = read_table(folder / "a.parquet")
    return frame.to_json(), list(map(str, frame.dtypes)), about


def _record(path: Path) -> Any:
    record = load_record(path)
    return repr([part.tobytes() for part in (record.time, record.measured, record.samples, record.start_mean)])


def _tracker(name: str, file: str, write: Callable[..., object]) -> Format:
    """A tracker's file."""

    def read(folder: Path) -> Any:
        tracks = READERS[Path(file).suffix](folder / file, None)
        return repr([tracks.time.tobytes(), *(part.tobytes() for part in tracks.places.values())])

    return Format(name, file, lambda folder: write(folder / file, tracker_files.jaw()), read)


def _landmarks(path: Path) -> Any:
    time = np.arange(3.0)
    return repr(read_landmarks(path, Tracks("here", time, {"MR": np.ones((3, 3))}), np.eye(3)))


def _replay(folder: Path) -> Any:
    replay = Replay.load(folder / "a.safetensors")
    return replay.name, replay.decision_hz, contents.actions_of(replay)


def _policy(folder: Path) -> Any:
    return contents.actions_of(load_policy(folder))


def _shipped_policy(folder: Path) -> None:
    shutil.copytree(SHIPPED / "ppo_trismus", folder, dirs_exist_ok=True)


_COLUMNS = """time_s = {name = "t", unit = "ms"}
mouthpiece_x_mm = {name = "Z", unit = "m", sign = -1}
"""
_LANDMARKS = """unit = "mm"
incisor = [120.4, -312.0, 871.5]
molar_left = [98.1, -297.3, 862.0]
molar_right = "MR"
"""
_CHECKPOINT = ("step_1.zip", contents.checkpoint, lambda folder: repr(read_counts(folder / "step_1.zip")))
_WEIGHTS = ("policy.safetensors", _shipped_policy, _policy)

FORMATS = (
    _copied("maneuver", MANEUVERS / "refined.yaml", Maneuver.load),
    _text("patient", "a.json", contents.patient(), Patient.load),
    _text("cohort", "a.toml", contents.COHORT, lambda path: Cohort.load(path).to_dict()),
    _text("device", "a.toml", contents.numbers(Device), Device.load),
    _text("anatomy", "a.toml", contents.ANATOMY, Anatomy.load),
    _text("reality", "a.yaml", contents.numbers(Reality).replace(" = ", ": "), Reality.load),
    _copied("study", shipped_studies()["ladder"], lambda path: read_study(str(path))),
    _copied("training configuration", CONFIGS / "ppo.yaml", TrainingConfig.load),
    _text("evaluations", "evaluations.csv", contents.EVALUATIONS, lambda path: read_evaluations(path.parent)),
    Format("card", "card.json", _shipped_policy, lambda folder: repr(read_card(folder))),
    Format("policy", *_WEIGHTS, has_checksums=True),
    Format("weights with their hash", *_WEIGHTS, put=_with_hash),
    Format("recording in CSV", "a.csv", contents.recording, lambda folder: _record(folder / "a.csv")),
    Format("recording", "a.parquet", contents.recording, lambda folder: _record(folder / "a.parquet"), True),
    Format("results", "a.parquet", contents.table, _table, has_checksums=True),
    Format("recorded actions", "a.safetensors", contents.replay, _replay),
    Format("checkpoint", *_CHECKPOINT, has_checksums=True),
    Format("checkpoint's settings, anew", *_CHECKPOINT, **_member("data")),
    _tracker("C3D", "a.c3d", tracker_files.write_c3d),
    _tracker("HDF5", "a.h5", tracker_files.write_hdf5),
    _tracker("TRC", "a.trc", tracker_files.write_trc),
    _tracker("MOT", "a.mot", tracker_files.write_mot),
    _text("landmarks", "a.toml", _LANDMARKS, _landmarks),
    _text("columns of a recording", "a.toml", _COLUMNS, read_columns),
)
"""All kinds."""
