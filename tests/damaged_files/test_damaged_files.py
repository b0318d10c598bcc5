"""A damaged file of any kind is refused in one line, or read right."""

from pathlib import Path

import pytest

from tests.damaged_files.reading import FORMATS, Format, faults_of

NUMBER = 16


@pytest.mark.parametrize("format_", FORMATS, ids=lambda format_: format_.name)
def test_damaged_files_are_refused_or_read_right(format_: Format, tmp_path: Path) -> None:
    faults, refused = faults_of(format_, tmp_path, NUMBER, seed=1)
    assert not faults, "\n".join(faults)
    assert refused > 0
