"""Modules of kernels that are loaded only where a model needs them: digests read their text."""

import importlib
import inspect
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

import jawenv
from jawenv.filter.tick import take
from jawenv.filter.updates.time_update import predict_cov
from jawenv.kernels import cache

PACKAGE = Path(jawenv.__file__).parent
DIGEST = """
import sys
for module in sys.argv[1:]:
    __import__(module)
from jawenv.envs.world.step_kernel import advance
from jawenv.kernels.cache import APART, kernel_digest
print(kernel_digest(advance._function), *sorted(APART & set(sys.modules)))
"""


def digest_in_a_process(*loaded: str) -> list[str]:
    command = [sys.executable, "-c", DIGEST, *loaded]
    return subprocess.run(command, capture_output=True, text=True, check=True, timeout=600).stdout.split()


def test_a_digest_loads_none_of_them_and_is_the_same_where_they_are_loaded():
    digest, *loaded = digest_in_a_process()
    assert not loaded
    assert digest_in_a_process(*sorted(cache.APART)) == [digest, *sorted(cache.APART)]


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
    cache._module_apart.cache_clear()
    try:
        assert (cache.kernel_digest.__wrapped__(take.py_func) != before) is changes
        assert cache.kernel_digest.__wrapped__(predict_cov.py_func) == other
    finally:
        cache._module_apart.cache_clear()


def test_parts_that_are_named_take_the_arguments_of_those_that_name_them():
    named = 0
    for path in PACKAGE.rglob("*.py"):
        if "where(" not in path.read_text(encoding="utf-8") or path.parent.name == "kernels":
            continue
        module = importlib.import_module(".".join(path.relative_to(PACKAGE.parent).with_suffix("").parts))
        for part in vars(module).values():
            pieces = getattr(part, cache.MADE_OF, ())
            if pieces and getattr(part, "__module__", "") == module.__name__ and isinstance(pieces[1], str):
                home = vars(importlib.import_module(pieces[1]))
                assert pieces[1] in cache.APART
                others = [getattr(other, "py_func", other) for other in home.values() if callable(other)]
                names = [[*inspect.signature(other).parameters] for other in others if inspect.isfunction(other)]
                assert [*inspect.signature(pieces[0]).parameters] in names
                named += 1
    assert named >= 7


def test_a_digest_without_sources_is_of_the_code(monkeypatch):
    def sourceless(name):
        code = compile("STEP = 0.01", name, "exec")
        return SimpleNamespace(loader=SimpleNamespace(get_source=lambda _: None, get_code=lambda _: code))

    monkeypatch.setattr(cache, "find_spec", sourceless)
    pieces, references = cache._module_apart.__wrapped__("jawenv.filter.nuisances.changes")
    assert pieces and not references
