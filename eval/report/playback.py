"""What the page needs to draw a moving jaw: the surfaces of the renderer, and the motions of the entries."""

from __future__ import annotations

from typing import Any

import numpy as np

from eval.comparison.ranking import Ranking
from eval.comparison.results import Results
from jawenv.rendering import outlines
from jawenv.rendering.mesh import Mesh


def playback(study: Results, ranking: Ranking) -> dict[str, Any] | None:
    """Surfaces in mm and the motions by the labels of the entries; None where none was kept.

    Surfaces: ``mandible``, ``lower_teeth`` and ``mouthpiece`` move with the jaw, ``upper_teeth`` and the outlines
    ``head`` (x, z from the side), ``face`` (y, z from the front) and ``arch`` (x, z) stand still.
    """
    motions = {row.entry: study.motions[row.entry] for row in ranking.rows if study.motions.get(row.entry)}
    if not motions:
        return None
    surfaces = {
        "mandible": _surface(outlines.mandible()),
        "lower_teeth": _surface(outlines.lower_teeth()),
        "mouthpiece": _surface(outlines.mouthpiece()),
        "upper_teeth": _surface(outlines.upper_teeth()),
    }
    lines = {
        "head": _line(outlines.closed(outlines.SIDE_HEAD)),
        "orbit": _line(outlines.closed(outlines.SIDE_ORBIT)),
        "face": _line(outlines.face()),
        "arch": _line(outlines.closed(outlines.SIDE_ARCH)),
    }
    return {"surfaces": surfaces, "lines": lines, "condyle_y": outlines.CONDYLE_Y_MM, "motions": motions}


def _surface(mesh: Mesh) -> dict[str, Any]:
    """Vertices in tenths of a millimetre, four corners per face, and its outward normal in hundredths."""
    return {
        "vertices": np.rint(10.0 * mesh.vertices).astype(int).ravel().tolist(),
        "faces": mesh.faces.ravel().tolist(),
        "normals": np.rint(100.0 * mesh.normals).astype(int).ravel().tolist(),
    }


def _line(points: Any) -> list[float]:
    return [round(float(each), 1) for each in np.asarray(points).ravel()]
