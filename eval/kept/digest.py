"""Names of kept files: digests of everything that can change their content."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

import agents
import jawenv
from agents import registry
from eval.kept.entries import Entry
from jawenv.base.errors import InputError, shown
from jawenv.base.files import FILE_TYPES
from jawenv.base.reading import read_bytes
from jawenv.base.versions import package_versions
from jawenv.playing.agents import Agent

_SOURCES = {".py", ".toml", ".yaml", ".json", ".csv"}
DECIDING = (
    "base",
    "kernels",
    "anatomy",
    "mechanics",
    "device",
    "reality",
    "filter",
    "envs",
    "playing",
    "metrics",
    "recordings",
    "analysis",
    "references",
    "inference",
)
"""Rooms of jawenv that a number can come from; the single modules beside them count too."""


def digest(decided_by: Any, files: Iterable[Path] = (), made_by: Iterable[ModuleType] = ()) -> str:
    """16 hexadecimal digits for values, files, sources of jawenv that change numbers, agents, and packages.

    Args:
        decided_by: values that JSON can hold.
        files: read for it.
        made_by: further modules with an effect on the result; of a package all of its files count.
    """
    content = hashlib.sha256(json.dumps([decided_by, package_versions()], sort_keys=True).encode())
    for module in (jawenv, agents, *made_by):
        content.update(_source(Path(str(module.__file__))).encode())
    for file in files:
        content.update(file.name.encode() + hashlib.sha256(read_bytes(file)).digest())
    return content.hexdigest()[:16]


def fingerprint(entry: Entry, settings: Any, *made_by: ModuleType) -> str:
    """The digest of an entry's results.

    An entry is made of its files (`agents.registry.files_of`), those that an agent of one's own names in its attribute
    ``made_of``, and those among the arguments of its environment, such as a cohort's.

    Args:
        entry: player of the kept results.
        settings: patients, settings, and anything else that decides the content.
        made_by: see `digest`.
    """
    texts = [value for value in entry.env_kwargs.values() if isinstance(value, str)]
    named = [Path(text) for text in texts if Path(text).suffix.lower() in FILE_TYPES]
    files = (*registry.files_of(entry.spec), *_made_of(entry.agent), *named)
    return digest([entry.about(), settings], files, made_by)


@cache
def _source(module: Path) -> str:
    """The digest of a module's file, or of all files of its package; of jawenv the files that can change a number."""
    files = module.parent.rglob("*") if module.name == "__init__.py" else [module]
    content, root = hashlib.sha256(), Path(str(jawenv.__file__)).parent
    for file in sorted(file for file in files if file.suffix in _SOURCES):
        if file.parent == root or not file.is_relative_to(root) or file.relative_to(root).parts[0] in DECIDING:
            content.update(file.name.encode() + hashlib.sha256(read_bytes(file)).digest())
    return content.hexdigest()


def _made_of(agent: Agent) -> list[Path]:
    named = getattr(agent, "made_of", ())
    if not isinstance(named, list | tuple) or not all(isinstance(path, str | Path) for path in named):
        raise InputError(f"{agent.name}: made_of is {shown(named)}; allowed: a list of paths")
    return [Path(path) for path in named]
