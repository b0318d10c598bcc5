"""The files of a page's drives, bounded in number and size."""

from __future__ import annotations

from pathlib import Path

from jawenv.base.errors import InputError
from jawenv.live.session import DriveSession

MOST_DRIVES = 200
MOST_BYTES = 500 * 2**20


class Saves:
    """Saved drives of one page: a pair of files each, which a later save of the same drive replaces.

    Args:
        folder: where the files are.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._sizes: dict[Path, int] = {}
        self.begin()

    def begin(self) -> None:
        """Another drive."""
        self._files: list[Path] = []
        self._steps = 0

    def save(self, session: DriveSession) -> list[Path]:
        """Write the drive of a session, unless nothing was driven since it was written last.

        Returns:
            Its files.
        """
        if not self._files or self._steps != session.steps:
            drives, size = len(self._sizes) - bool(self._files), sum(self._sizes.values())
            if drives >= MOST_DRIVES or size >= MOST_BYTES:
                raise InputError(
                    f"not saved: {drives} drives of {size / 2**20:.0f} MiB are; "
                    f"allowed: {MOST_DRIVES} of {MOST_BYTES / 2**20:.0f} MiB, until jawenv live starts again"
                )
            self._files = session.save(self._folder, *self._files[:1])
            self._steps = session.steps
            self._sizes[self._files[0]] = sum(path.stat().st_size for path in self._files)
        return self._files
