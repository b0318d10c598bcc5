"""Modules of kernels that are loaded only where a model needs them: digests read their text."""

import importlib
from pathlib import Path
from types import SimpleNamespace

import pytest

from jawenv.filter.model.motion_step import predict_cov
from jawenv.filter.tick import take
from jawenv.kernels import cache
from tests.processes import python

DIGEST = """
import sys
for module in sys.argv[1:]:
    __import__(module)
from jawenv.envs.world.step_kernel import advance
from jawenv.kernels.cache import LAZY_MODULES, kernel_digest
print(kernel_digest(advance._function), *sorted(LAZY_MODULES & set(sys.modules)))
"""


def digest_in_a_process(*loaded: str) -> list[str]:
    return python("-c", DIGEST, *loaded).stdout.split()


def test_a_digest_loads_none_of_them_and_is_the_same_where_they_are_loaded():
    digest, *loaded = digest_in_a_process()
    assert not loaded
    assert digest_in_a_process(*sorted(cache.LAZY_MODULES)) == [digest, *sorted(cache.LAZY_MODULES)]


@pytest.mark.parametrize(
    ("old", "new", "changes"),
    [
        ("STEP = 0.01", "STEP = 0.02", True),
        ("def set_wrenches(", "# a remark\ndef set_wrenches(", False),
        ('"""What one sd', '"""That which one sd', False),
        ("scale(1.0 / STEP", "scale(2.0 / STEP", True),
    ],
)
def test_a_digest_changes_with_what_could_change_numbers(monkeypatch, old, new, changes):
    """With a constant or an operation, and not with a remark."""

    def edited(name):
        text = Path(importlib.import_module(name).__file__).read_text(encoding="utf-8")
        return SimpleNamespace(loader=SimpleNamespace(get_source=lambda _: text.replace(old, new)))

    before, other = cache.kernel_digest(take.py_func), cache.kernel_digest(predict_cov.py_func)
    monkeypatch.setattr(cache, "find_spec", edited)
    cache._lazy_module.cache_clear()
    try:
        assert (cache.kernel_digest.__wrapped__(take.py_func) != before) is changes
        assert cache.kernel_digest.__wrapped__(predict_cov.py_func) == other
    finally:
        cache._lazy_module.cache_clear()


def test_a_digest_without_sources_is_of_the_code(monkeypatch):
    def sourceless(name):
        code = compile("STEP = 0.01", name, "exec")
        return SimpleNamespace(loader=SimpleNamespace(get_source=lambda _: None, get_code=lambda _: code))

    monkeypatch.setattr(cache, "find_spec", sourceless)
    pieces, references = cache._lazy_module.__wrapped__("jawenv.filter.nuisances.changes")
    assert pieces and not references
