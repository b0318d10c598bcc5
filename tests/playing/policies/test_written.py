"""A policy's card and weights are replaced together, or not at all."""

from pathlib import Path

import pytest

from jawenv.base.errors import InputError
from jawenv.playing.policies import plain
from jawenv.playing.policies.card import CARD, read_card
from jawenv.playing.policies.plain import read_weights, write_policy
from tests import plain_policies


def test_the_older_policy_stays_until_the_new_one_lies_beside_it(tmp_path: Path, monkeypatch) -> None:
    folder = plain_policies.write_policy(tmp_path / "policy")
    card, before = read_card(folder), {path: path.read_bytes() for path in folder.iterdir()}
    other = plain_policies.write_policy(tmp_path / "other", algorithm="another")
    weights, new = read_weights(other, read_card(other)), read_card(other)
    write = Path.write_bytes

    def full(path: Path, content: bytes) -> int:
        assert (folder / CARD).exists(), "nothing goes before the new files lie beside the old ones"
        write(path, content[:10])
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch, pytest.raises(InputError, match="No space left"):
        patch.setattr(Path, "write_bytes", full)
        write_policy(folder, weights, new)
    assert {path: path.read_bytes() for path in folder.iterdir()} == before
    assert plain.load_plain(folder).card == card
    write_policy(folder, weights, new)
    assert read_card(folder) == new and set(folder.iterdir()) == set(before)
