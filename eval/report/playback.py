"""What the page needs to draw a moving jaw as the renderer does: its surfaces, cameras and colours, and the motions.

`assets/jaw.js` holds no shape, colour or width of its own: the picture of an entry is that of its film.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from eval.comparison.ranking import Ranking
from eval.comparison.results import Results
from jawenv.rendering import camera, force, muscles, outlines, palette
from jawenv.rendering.legends import LABELLED_SD, LABELLED_TENSION_N
from jawenv.rendering.mesh import Mesh

_PLANAR_MM = 1.0


def playback(study: Results, ranking: Ranking) -> dict[str, Any] | None:
    """Surfaces in mm and the motions by the labels of the entries; None where none was kept.

    Surfaces: ``mandible``, ``lower_teeth`` and ``mouthpiece`` move with the jaw, ``upper_teeth`` stand
    still, as do the outlines ``head``, ``orbit`` and ``arch`` (x, z from the side), ``face``, ``orbits`` and ``nose``
    (y, z from the front).
    """
    motions = {row.entry: study.motions[row.entry] for row in ranking.rows if study.motions.get(row.entry)}
    if not motions:
        return None
    planar = {label: _planar(motion) for label, motion in motions.items()}
    return {
        "surfaces": {
            "mandible": _surface(outlines.mandible()),
            "lower_teeth": _surface(outlines.lower_teeth()),
            "mouthpiece": _surface(outlines.mouthpiece()),
            "upper_teeth": _surface(outlines.upper_teeth()),
        },
        "lines": _outlines(),
        "cameras": {
            "side": _camera(camera.side_camera((0.0, 0.0, 1.0, 1.0), all(planar.values()))),
            "front": _camera(camera.front_camera((0.0, 0.0, 1.0, 1.0))),
        },
        "look": _look(),
        "condyle_y": outlines.CONDYLE_Y_MM,
        "motions": {label: motion | _layers(motion, planar[label]) for label, motion in motions.items()},
    }


def legend() -> dict[str, Any]:
    """The scale of knowledge and the widths of some tensions: colours with their places, 0 to 1, and labels."""
    span = math.log(palette.UNKNOWN_SD / palette.KNOWN_SD)
    last = len(palette.KNOWLEDGE) - 1
    return {
        "stops": [(100.0 * i / last, _css(colour)) for i, colour in enumerate(palette.KNOWLEDGE)],
        "sds": [(100.0 * math.log(palette.UNKNOWN_SD / sd) / span, 100.0 * sd) for sd in LABELLED_SD],
        "tensions": [(tension, muscles.muscle_width(tension)) for tension in LABELLED_TENSION_N],
    }


def _look() -> dict[str, Any]:
    """Colours and widths; lengths in design units of a view that is ``design_height`` high."""
    return {
        "design_height": camera.DESIGN_HEIGHT,
        "light": camera.LIGHT.tolist(),
        "ambient": camera.AMBIENT,
        "bone": [palette.BONE_SHADOW, palette.BONE_LIGHT, palette.BONE_LINE],
        "tooth": [palette.TOOTH_SHADOW, palette.TOOTH_LIGHT, palette.TOOTH_LINE],
        "plate": [palette.PLATE_SHADOW, palette.PLATE_LIGHT, palette.INK],
        "fossa": palette.FOSSA,
        "knowledge": palette.KNOWLEDGE,
        "known": [palette.UNKNOWN_SD, palette.KNOWN_SD],
        "muscle": [muscles.SLACK, muscles.PER_ROOT_N, muscles.WIDEST],
        "force": [force.LEAST_FORCE_N, force.MM_PER_N, force.LONGEST_MM],
    }


def _outlines() -> dict[str, Any]:
    orbit = outlines.closed(outlines.FRONT_ORBIT)
    return {
        "head": _line(outlines.closed(outlines.SIDE_HEAD)),
        "orbit": _line(outlines.closed(outlines.SIDE_ORBIT)),
        "arch": _line(outlines.closed(outlines.SIDE_ARCH)),
        "face": _line(outlines.face()),
        "orbits": [_line(orbit), _line(orbit * [-1, 1])],
        "nose": _line(outlines.closed(outlines.mirrored(outlines.FRONT_NOSE)[:-1])),
    }


def _camera(made: camera.Camera) -> dict[str, Any]:
    """Directions, and the place of the head's origin in a view of height and width 1; its scale is per mm."""
    right, toward = made.right.tolist(), made.toward.tolist()
    return {"right": right, "toward": toward, "origin": list(made.origin), "scale": made.scale}


def _planar(motion: dict[str, Any]) -> bool:
    return float(np.abs(np.array(motion["origin"] + motion["insertion"])[:, 1]).max()) < _PLANAR_MM


def _layers(motion: dict[str, Any], planar: bool) -> dict[str, list[str]]:
    """Side and depth of every line of action."""
    ends = [
        (np.array(origin), np.array(end)) for origin, end in zip(motion["origin"], motion["insertion"], strict=True)
    ]
    return {
        "sides": [muscles.side_at(origin, insertion, planar) for origin, insertion in ends],
        "layers": [muscles.layer_at(origin) for origin, _ in ends],
    }


def _surface(mesh: Mesh) -> dict[str, Any]:
    """Vertices in tenths of a millimetre, four corners per face, its outward normal in hundredths, and shared edges.

    An edge is two vertices and the two faces that it lies between.
    """
    return {
        "vertices": np.rint(10.0 * mesh.vertices).astype(int).ravel().tolist(),
        "faces": mesh.faces.ravel().tolist(),
        "normals": np.rint(100.0 * mesh.normals).astype(int).ravel().tolist(),
        "edges": np.hstack([mesh.edges, mesh.edge_faces]).ravel().tolist(),
    }


def _css(colour: palette.Colour) -> str:
    return f"rgb({', '.join(map(str, colour))})"


def _line(points: Any) -> list[float]:
    return [round(float(each), 1) for each in np.asarray(points).ravel()]
