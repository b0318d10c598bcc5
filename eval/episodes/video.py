"""Pictures become a film in a file."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray


def write_mp4(path: Path, pictures: Iterable[NDArray[np.uint8]], rate: float, options: Sequence[str] = ()) -> None:
    """Write pictures as they come.

    Args:
        path: of the film.
        pictures: (height, width, 3), height and width even.
        rate: pictures per second.
        options: of ffmpeg.
    """
    import imageio.v2 as imageio

    own = path.with_name(path.name + ".mp4")  # the writer goes by the ending
    try:
        writer: Any
        with imageio.get_writer(own, fps=rate, macro_block_size=2, output_params=list(options)) as writer:
            for picture in pictures:
                writer.append_data(picture)
        own.replace(path)
    finally:
        own.unlink(missing_ok=True)


def write_webp(path: Path, pictures: Iterable[NDArray[np.uint8]], rate: float) -> None:
    """Write a film that repeats for ever."""
    from PIL import Image

    first, *rest = map(Image.fromarray, pictures)
    duration = round(1e3 / rate)
    first.save(path, "WEBP", save_all=True, append_images=rest, duration=duration, loop=0, quality=75)
