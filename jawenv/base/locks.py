"""An output belongs to one process at a time."""

from __future__ import annotations

import contextlib
import errno
import os
from collections.abc import Iterator
from pathlib import Path

from filelock import FileLock, Timeout

from jawenv.base.errors import InputError, reason_of
from jawenv.base.files import remove_unfinished


@contextlib.contextmanager
def alone(output: Path) -> Iterator[None]:
    """No other process writes this file, or into this folder, within the block.

    The lock is the file ``.NAME.lock`` beside the output, which is removed at the end of the block. The system frees it
    when the process ends, whatever ends it. What such a process was writing is removed by the next one.

    Args:
        output: a file or a folder, which need not exist. The folder that it is to lie in is made where it is missing,
            and goes again if nothing was written.
    """
    target = output.resolve()
    path = target.with_name(f".{target.name}.lock")
    made = [folder for folder in target.parents if not folder.exists()]
    lock = FileLock(path, timeout=0)
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        lock.acquire()
    except Timeout:
        raise InputError(f"{output}: in use by another process; wait for it, or name another output") from None
    except NotImplementedError:
        raise InputError(f"output {output}: its file system has no locks; allowed: one on another") from None
    except OSError as error:
        reason = os.strerror(errno.ENOTDIR) if isinstance(error, FileExistsError) else reason_of(error)
        raise InputError(f"output {output}: cannot be {'written' if target.exists() else 'made'}: {reason}") from None
    try:
        remove_unfinished(target)
        yield
    finally:
        with contextlib.suppress(OSError):  # Windows removes no file that is open
            path.unlink()
        lock.release()
        with contextlib.suppress(OSError):
            for folder in made:
                folder.rmdir()
