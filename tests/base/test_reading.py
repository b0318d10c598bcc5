"""Files that would hang or fill the memory are refused in one line, at once."""

import os
import time
from pathlib import Path

import pytest

from jawenv.base.errors import InputError
from jawenv.base.files import read_mapping
from jawenv.base.reading import open_file, read_bytes, read_text


def refusal(path: Path) -> str:
    start = time.monotonic()
    with pytest.raises(InputError) as caught:
        read_mapping(path)
    assert time.monotonic() - start < 20.0
    message = str(caught.value)
    assert "\n" not in message and message.startswith(f"{path}: ") and len(message) < 400
    return message.removeprefix(f"{path}: ")


def aliases_of_aliases(levels: int) -> str:
    lines = [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9)}]\n" for i in range(1, levels)]
    return "a0: &a0 [1, 1]\n" + "".join(lines)


def merges_of_merges(levels: int) -> str:
    lines = [f"m{i}: &m{i} {{<<: [{', '.join([f'*m{i - 1}'] * 9)}]}}\n" for i in range(1, levels)]
    return "m0: &m0 {a: 1}\n" + "".join(lines)


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.yaml", aliases_of_aliases(9), "damaged YAML: more than 200,000 values, aliases written out"),
        ("a.yaml", f"env: {{kwargs: {{x: 1}}}}\n{merges_of_merges(9)}", "more than 200,000 values"),
        ("a.yaml", "a: &a [*a]", "damaged YAML: alias 'a' stands in its own value"),
        ("a.yaml", f"a: 1{':1' * 5000}", "damaged YAML: a number of more than 1000 characters (line 1)"),
        ("a.yaml", f"a: 1{':1' * 5000}.5", "damaged YAML: a number of more than 1000 characters (line 1)"),
        ("a.yaml", "a0: &a [1]\n? *a\n: 1", "damaged YAML: found unhashable key (line 1)"),
        ("a.yaml", "a: !!int ''", "damaged YAML: a value that its tag does not fit (IndexError"),
        ("a.yaml", "a: !!bool x", "damaged YAML: a value that its tag does not fit (KeyError"),
        ("a.yaml", "a: !!timestamp x", "damaged YAML: a value that its tag does not fit (AttributeError"),
        ("a.toml", f"a{'.a' * 50_000} = 1", "damaged TOML: a key of more than 30 parts"),
        ("a.json", f'{{"a": {"1" * 5000}}}', "damaged JSON: Exceeds the limit"),
    ],
)
def test_texts_that_say_more_than_they_hold(tmp_path: Path, name: str, text: str, message: str) -> None:
    (tmp_path / name).write_text(text)
    assert message in refusal(tmp_path / name)


def test_pipes_and_devices_are_no_files(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.yaml")
    assert refusal(tmp_path / "pipe.yaml") == "is a pipe; allowed: a regular file"
    (tmp_path / "zero.yaml").symlink_to("/dev/zero")
    assert refusal(tmp_path / "zero.yaml") == "is a device; allowed: a regular file"
    (tmp_path / "gone.yaml").symlink_to(tmp_path / "nowhere")
    assert refusal(tmp_path / "gone.yaml") == "no such file"


def test_a_link_to_a_file_is_followed(tmp_path: Path) -> None:
    (tmp_path / "file.yaml").write_text("a: 1\r\nb: 2\r\n")
    (tmp_path / "link.yaml").symlink_to(tmp_path / "file.yaml")
    assert read_mapping(tmp_path / "link.yaml") == {"a": 1, "b": 2}
    assert read_text(tmp_path / "link.yaml") == "a: 1\nb: 2\n"


def test_large_files_are_refused_before_they_are_read(tmp_path: Path) -> None:
    with (tmp_path / "large.yaml").open("wb") as file:
        file.truncate(2**40)  # a hole: it takes no place
    assert refusal(tmp_path / "large.yaml") == "has 1,099,511,627,776 bytes; allowed: 8,388,608 at most"
    with pytest.raises(InputError, match="allowed: 3 at most"):
        read_bytes("/proc/self/status", 3)  # states no size
    with pytest.raises(InputError, match="allowed: 1,073,741,824 at most"), open_file(tmp_path / "large.yaml"):
        pass


def test_a_name_with_a_null_character_is_refused() -> None:
    with pytest.raises(InputError, match="cannot be read: embedded null byte"):
        read_bytes("a\0b")
