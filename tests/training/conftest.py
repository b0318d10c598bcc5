"""Small environments and settings that the training tests share."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))  # configurations import point_env by its name


@pytest.fixture
def tiny_config(tmp_path: Path) -> Path:
    """A configuration file of a run of a second or two."""
    from point_env import TINY_CONFIG

    path = tmp_path / "tiny.yaml"
    path.write_text(TINY_CONFIG)
    return path
