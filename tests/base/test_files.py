"""Files from outside: every fault is one line that names the file and the field."""

import json
import os
from pathlib import Path

import pytest
from pydantic import Field

from jawenv.base.errors import InputError
from jawenv.base.files import InputModel, Number, Text, atomic_write, read_mapping, read_model, validate, write_json
from jawenv.playing.maneuvers import Maneuver


class Part(InputModel):
    gain: Number = Field(gt=0)
    points: tuple[Number, ...] = ()


class Device(InputModel):
    name: str
    parts: list[Part] = []
    spare: Part | None = None


def line(path: Path, model: type[InputModel] = Device) -> str:
    with pytest.raises(InputError) as caught:
        read_model(path, model)
    message = str(caught.value)
    assert "\n" not in message
    assert message.startswith(f"{path}: ")
    return message.removeprefix(f"{path}: ")


@pytest.mark.parametrize(
    ("suffix", "text"),
    [
        ("json", '{"name": "x", "parts": [{"gain": 1e-4, "points": [1, 2.5]}]}'),
        ("toml", 'name = "x"\n[[parts]]\ngain = 1e-4\npoints = [1, 2.5]'),
        ("yaml", "name: x\nparts:\n  - gain: 1e-4\n    points: [1, 2.5]"),
        ("YML", "defaults: &d {gain: 1.0e-4}\nname: x\nparts:\n  - {<<: *d, points: [1, 2.5]}"),
    ],
)
def test_three_formats_say_the_same(tmp_path: Path, suffix: str, text: str) -> None:
    path = tmp_path / f"device.{suffix}"
    path.write_text(text)
    data = read_mapping(path)
    data.pop("defaults", None)
    assert validate(Device, data, "device") == Device(name="x", parts=[Part(gain=1e-4, points=(1, 2.5))])


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.json", b"", "damaged JSON: Expecting value: line 1 column 1 (char 0)"),
        ("a.json", b"[1]", "content is a list; allowed: a mapping of keys to values"),
        ("a.json", b'{"name": 1, "name": 2}', "damaged JSON: key 'name' appears twice"),
        ("a.yaml", b"name: a\nname: b", "damaged YAML: key 'name' appears twice"),
        ("a.yaml", b"x: [1", "damaged YAML: expected ',' or ']', but got '<stream end>' (line 1)"),
        ("a.yaml", b"\n? [x]\n: 1", "damaged YAML: found unhashable key (line 2)"),
        ("a.yaml", b"x: !py y", "damaged YAML: could not determine a constructor for the tag '!py' (line 1)"),
        ("a.json", b"\xff", "damaged JSON: 'utf-8' codec can't decode byte 0xff in position 0: invalid start byte"),
        ("a.json", b"[" * 200_000, "damaged JSON: nested too deeply"),
        ("a.txt", b"", "unknown file type '.txt'; allowed: .json, .toml, .yaml, .yml"),
        ("a.json", b"{}", "name is missing"),
        ("a.json", b'{"name": 3}', "name is 3; allowed: a valid string"),
        ("a.json", b'{"name": "x", "nam": 1, "z": 2}', "unknown key 'nam'; allowed: name, parts, spare (and 1 more)"),
        ("a.json", b'{"name": "x", "parts": [{"gain": NaN}]}', "parts.0.gain is nan; allowed: a finite number"),
        ("a.json", b'{"name": "x", "parts": [{"gain": -1}]}', "parts.0.gain is -1.0; allowed: greater than 0"),
        (
            "a.json",
            b'{"name": "x", "spare": {"gian": 1}}',
            "unknown key 'spare.gian'; allowed: gain, points (and 1 more)",
        ),
        ("a.toml", b'name = "x"\nspare.gain = inf', "spare.gain is inf; allowed: a finite number"),
        ("a.yaml", b"name: x\nspare: {gain: yes}", "spare.gain is True; allowed: a number"),
    ],
)
def test_faults(tmp_path: Path, name: str, content: bytes, message: str) -> None:
    path = tmp_path / name
    path.write_bytes(content)
    assert line(path) == message


def test_missing_file_and_folder(tmp_path: Path) -> None:
    assert line(tmp_path / "none.json") == "no such file"
    (tmp_path / "folder.json").mkdir()
    assert line(tmp_path / "folder.json") == "cannot be read: Is a directory"


def test_what_can_be_made_again_is_not_forced_onto_the_disk(tmp_path, monkeypatch):
    synced = []
    monkeypatch.setattr("os.fsync", synced.append)
    for forced in (True, False):
        with atomic_write(tmp_path / "kept", synced=forced) as unfinished:
            unfinished.write_text("whole")
    assert len(synced) == 1 and (tmp_path / "kept").read_text() == "whole"


def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "part.json"
    write_json(path, Part(gain=1))
    before = path.read_text()

    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("os.fsync", interrupted)
    with pytest.raises(KeyboardInterrupt):
        write_json(path, Part(gain=2))
    assert path.read_text() == before
    assert [entry.name for entry in tmp_path.iterdir()] == ["part.json"]


def test_unwritable_places(tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        write_json(tmp_path / "none" / "part.json", Part(gain=1))
    assert str(caught.value) == f"{tmp_path}/none/part.json: cannot be written: No such file or directory"
    with pytest.raises(InputError):
        write_json(tmp_path / "part.toml", Part(gain=1))


def test_yaml_without_pyyaml_names_the_remedy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.yaml"
    path.write_text("name: x")
    monkeypatch.setitem(__import__("sys").modules, "yaml", None)
    monkeypatch.delitem(__import__("sys").modules, "jawenv.base.plain_yaml", raising=False)
    monkeypatch.delattr("jawenv.base.plain_yaml", raising=False)
    assert line(path) == "YAML files need the package pyyaml; JSON and TOML files do not"


@pytest.mark.parametrize("text", ["a\x1b[2J", "turned \u202e round"])
def test_a_text_that_steers_a_terminal_is_refused(text: str, tmp_path: Path) -> None:
    class Named(InputModel):
        title: Text

    assert Named(title="two\n  lines").title == "two lines"
    with pytest.raises(InputError):
        Named(title=text)


@pytest.mark.parametrize("name", ["x" * 10**6, "x\x1b[2J\x07"])
def test_an_unknown_key_is_shown_short_and_printable(name: str, tmp_path: Path) -> None:
    (tmp_path / "odd.json").write_text(json.dumps({name: 1}))
    with pytest.raises(InputError) as caught:
        Maneuver.load(tmp_path / "odd.json")
    assert str(caught.value).isprintable() and len(str(caught.value)) < 400


def test_yaml_is_bounded_by_what_it_takes_to_read(tmp_path: Path) -> None:
    (tmp_path / "long.yaml").write_text("#" * (2**20 + 1))
    with pytest.raises(InputError):
        read_mapping(tmp_path / "long.yaml")


def test_what_is_no_file_stays_what_it_is(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "stdout").symlink_to("/proc/self/fd/1")
    for name in (tmp_path / "pipe", tmp_path / "stdout", Path("/dev/stdout"), Path("/dev/null")):
        with pytest.raises(InputError, match="allowed: a file"), atomic_write(name) as unfinished:
            unfinished.write_text("lost", encoding="utf-8")
    assert not Path("/dev/null").is_file() and (tmp_path / "pipe").is_fifo() and (tmp_path / "stdout").is_symlink()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["pipe", "stdout"]


def test_a_link_stays_and_so_do_permissions(tmp_path: Path) -> None:
    (tmp_path / "far").mkdir()
    target = tmp_path / "far" / "kept"
    target.write_text("old", encoding="utf-8")
    target.chmod(0o600)
    (tmp_path / "link").symlink_to(target)
    with atomic_write(tmp_path / "link") as unfinished:
        unfinished.write_text("new", encoding="utf-8")
    assert (tmp_path / "link").is_symlink() and target.read_text(encoding="utf-8") == "new"
    assert target.stat().st_mode & 0o777 == 0o600 and len(list((tmp_path / "far").iterdir())) == 1
