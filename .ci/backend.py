"""The build backend: setuptools, whose wheel names only the extras of what it holds.

The other extras (`train`, `eval`, `dev` ...) are for folders that run from the clone: editable installations have them.
"""

from __future__ import annotations

import base64
import hashlib
import re
import zipfile
from pathlib import Path
from typing import Any

from setuptools import build_meta

# No prepare_metadata_for_build_wheel: the metadata is that of the wheel.
build_editable = build_meta.build_editable
build_sdist = build_meta.build_sdist
get_requires_for_build_editable = build_meta.get_requires_for_build_editable
get_requires_for_build_sdist = build_meta.get_requires_for_build_sdist
get_requires_for_build_wheel = build_meta.get_requires_for_build_wheel
prepare_metadata_for_build_editable = build_meta.prepare_metadata_for_build_editable

OF_THE_WHEEL = ("all", "live", "reference", "render", "sagittal")
_EXTRA = re.compile(r"""^Provides-Extra: (?P<own>.+)$|^Requires-Dist:.*\bextra == ["'](?P<needs>.+?)["']""")


def build_wheel(folder: str, config_settings: Any = None, metadata_directory: Any = None) -> str:
    """Build the wheel, and leave the other extras out of its metadata."""
    name = build_meta.build_wheel(folder, config_settings, metadata_directory)
    path = Path(folder) / name
    with zipfile.ZipFile(path) as wheel:
        files = {info: wheel.read(info) for info in wheel.infolist()}
    (metadata,) = (info for info in files if info.filename.endswith(".dist-info/METADATA"))
    (record,) = (info for info in files if info.filename.endswith(".dist-info/RECORD"))
    files[metadata] = _of_the_wheel(files[metadata].decode()).encode()
    files[record] = _renewed(files[record].decode(), metadata.filename, files[metadata]).encode()
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as wheel:
        for info, content in files.items():
            wheel.writestr(info, content)
    return name


def _of_the_wheel(metadata: str) -> str:
    """The metadata without the other extras; the description after the first empty line stays as it is."""
    head, gap, description = metadata.partition("\n\n")
    kept = []
    for line in head.split("\n"):
        extra = _EXTRA.match(line)
        if extra is None or (extra["own"] or extra["needs"]) in OF_THE_WHEEL:
            kept.append(line)
    return "\n".join(kept) + gap + description


def _renewed(record: str, name: str, content: bytes) -> str:
    """The wheel's list of files with the digest of a changed one."""
    digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
    lines = (
        f"{name},sha256={digest},{len(content)}" if line.startswith(f"{name},") else line for line in record.split("\n")
    )
    return "\n".join(lines)
