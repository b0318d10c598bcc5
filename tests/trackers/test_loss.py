"""What is there is there afterwards: an import that is refused writes nothing, and no file is read and written."""

import numpy as np
import pytest

from jawenv.base.errors import InputError
from jawenv.recordings.files import load_record
from jawenv.trackers import importing
from jawenv.trackers.importing import ImportSettings, import_file
from tests import tracker_files as files


def asked(folder, scale=1.0):
    moved = files.jaw()
    columns = {name: values * (scale if "_N" in name else 1.0) for name, values in moved.columns().items()}
    files.write_trc(folder / "chew.trc", moved)
    return {
        "forces": files.write_csv(folder / "forces.csv", columns),
        "landmarks": files.write_landmarks(folder / "landmarks.toml"),
        "jaw": "J0,J1,J2",
        "head": "H0,H1,H2",
        "offset_s": 0.0,
    }


def refused(folder, output, **settings):
    with pytest.raises(InputError) as error:
        import_file(folder / "chew.trc", output, ImportSettings(**{**asked(folder, 1e4), **settings}))
    return str(error.value)


def test_an_older_output_stays_where_a_recording_is_refused(tmp_path):
    (tmp_path / "old.csv").write_text("of last year")
    (tmp_path / "link.csv").symlink_to(tmp_path / "old.csv")
    for output in ("old.csv", "link.csv"):
        assert "newtons" in refused(tmp_path, tmp_path / output)
        assert (tmp_path / output).read_text() == "of last year"
    assert (tmp_path / "link.csv").is_symlink()
    assert not list(tmp_path.glob(".*"))


def test_nothing_is_written_before_the_judgement(tmp_path, monkeypatch):
    monkeypatch.setattr(importing, "findings", lambda record: (_ for _ in ()).throw(KeyboardInterrupt))
    with pytest.raises(KeyboardInterrupt):
        import_file(tmp_path / "chew.trc", tmp_path / "out.csv", ImportSettings(**asked(tmp_path)))
    assert not (tmp_path / "out.csv").exists() and not list(tmp_path.glob(".*"))


@pytest.mark.parametrize("link", [None, "symlink_to", "hardlink_to"])
def test_an_output_is_no_input(tmp_path, link):
    settings = asked(tmp_path)
    output = tmp_path / "forces.csv"
    if link is not None:
        output = tmp_path / "other.csv"
        getattr(output, link)(tmp_path / "forces.csv")
    before = output.read_bytes()
    with pytest.raises(InputError, match="is read as .*forces.csv; allowed: an output that is no input"):
        import_file(tmp_path / "chew.trc", output, ImportSettings(**settings))
    assert output.read_bytes() == before


def test_bursts_without_forces_are_missing_readings(tmp_path):
    """Rows that a force file lacks, and cells that it leaves empty."""
    settings = asked(tmp_path)
    columns = {name: values.copy() for name, values in files.jaw().columns().items()}
    for name in columns:
        if "_N" in name:
            columns[name][200:230] = np.nan
    kept = np.r_[0:400, 450:600]
    files.write_csv(tmp_path / "forces.csv", {name: values[kept] for name, values in columns.items()})
    import_file(tmp_path / "chew.trc", tmp_path / "out.csv", ImportSettings(**settings))
    unread = np.isnan(load_record(tmp_path / "out.csv").samples[:, 0]).all(axis=1)
    assert unread.nonzero()[0].tolist() == [*range(200, 230), *range(400, 450)]
