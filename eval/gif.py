"""Films as GIF: one palette that holds the colours of the whole film."""

from __future__ import annotations

from collections.abc import Iterable
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from PIL.Image import Image

COLOURS = 96
_SAMPLES = 12
_SAMPLE_WIDTH = 640
_REFINEMENTS = 2


def write_gif(path: Path, pictures: Iterable[NDArray[np.uint8]], rate: float) -> None:
    """Write a film that repeats for ever.

    Only what moves is stored of each picture, since all have the same palette. It is that of samples over the whole
    film: the pictures are kept as PNG until the last is there.

    Args:
        path: of the file.
        pictures: (height, width, 3) each, of one size; at least one.
        rate: pictures per second.
    """
    from PIL import Image

    kept = [_packed(picture) for picture in pictures]
    picked = np.unique(np.linspace(0, len(kept) - 1, _SAMPLES).round().astype(int))
    palette = _palette([Image.open(kept[i]) for i in picked])
    first, *rest = (Image.open(packed).quantize(palette=palette, dither=Image.Dither.NONE) for packed in kept)
    duration = round(1e3 / rate)
    first.save(path, format="GIF", save_all=True, append_images=rest, duration=duration, loop=0, optimize=True)


def _packed(picture: NDArray[np.uint8]) -> BytesIO:
    from PIL import Image

    file = BytesIO()
    Image.fromarray(picture).save(file, format="PNG", compress_level=1)
    return file


def _palette(samples: list[Image]) -> Image:
    """A picture whose palette covers the colours of all samples, rare ones too.

    By maximum coverage: the median cut gives most of its colours to the large areas, and none to a thin blue bar.
    """
    from PIL import Image

    coarse = -(-samples[0].width // _SAMPLE_WIDTH)
    montage = np.concatenate([np.asarray(sample)[::coarse, ::coarse] for sample in samples])
    method = Image.Quantize.MAXCOVERAGE
    return Image.fromarray(montage).quantize(COLOURS, method, kmeans=_REFINEMENTS, dither=Image.Dither.NONE)
