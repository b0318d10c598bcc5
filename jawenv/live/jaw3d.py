"""The jaw in three dimensions: surfaces and lines of a viser scene that follow the moments of a drive."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.spatial import Delaunay
from scipy.spatial.transform import Rotation

from jawenv.live.panels import muscle_name
from jawenv.playing.agents import Array
from jawenv.rendering import outlines, palette
from jawenv.rendering.mesh import Mesh, loft
from jawenv.rendering.muscles import muscle_colours
from jawenv.rendering.scene import Scene

UNITS_PER_M = 10.0  # of the viser scene, whose lights suit things of about one unit
_UNITS_PER_MM = UNITS_PER_M / 1000.0
_MM_PER_N = 1.6
_LONGEST_ARROW_MM = 45.0
_LEAST_FORCE_N = 0.2
FIRST_POSITION = (4.0, -3.6, 0.3)  # of the camera, in units of the scene
_LOOK_AT_M = np.array([0.040, 0.0, -0.020])
_AROUND, _ABOVE = 0.7, 2.3  # intensities of the lights
_LIGHT_AT = (3.0, -6.0, 6.0)  # from the viewer's upper left
_BONE = palette.mix(palette.BONE_SHADOW, palette.BONE_LIGHT, 0.6)
_GHOST_OPACITY = 0.28
_NAME_APART, _NAME_SIZE = 0.12, 0.8
_BONE_PLATE: palette.Colour = (168, 156, 134)


class Jaw3D:
    """The jaw of one patient in the scene of a viser server.

    Args:
        server: a ``viser.ViserServer``.
        scene: the first moment.
        root: name of the frame that the jaw hangs on, where several jaws are in one scene.
        named: whether the muscles' names stand beside them.

    Attributes:
        colours: of the lines of a scene.
    """

    def __init__(self, server: Any, scene: Scene, root: str = "", named: bool = True) -> None:
        self._viser, self._root = server.scene, root
        self._sent: dict[str, Any] = {}
        self.colours = muscle_colours
        self._lines = len(scene.muscle_names)
        _prepare(server)
        self._add_skull(scene)
        self._ghost: Any = None
        self._jaw = self._viser.add_frame(f"{root}/jaw", show_axes=False)
        self._add_mesh("/jaw/bone", outlines.mandible(), _BONE)
        self._add_mesh("/jaw/teeth", outlines.lower_teeth(), palette.TOOTH_LIGHT)
        self._plate = self._add_mesh("/mouthpiece", outlines.mouthpiece(), palette.PLATE_LIGHT)
        spindle = _spindle()
        self._muscles = [self._add_mesh(f"/muscles/{i}", spindle, palette.ACCENT) for i in range(self._lines)]
        if named:
            self._add_names(scene)
        self._force = self._viser.add_arrows(
            f"{root}/force",
            _arrow(scene.mouthpiece_m, np.array([0.0, 0.0, -0.01])),
            palette.INK,
            shaft_radius=0.012,
            head_radius=0.035,
            head_length=0.07,
            visible=False,
        )
        self.show(scene)

    def show(self, scene: Scene, redraw: bool = True) -> None:
        """Move everything to a moment; what has not changed is not sent again.

        Args:
            scene: the moment.
            redraw: sizes, colours and the force as well. Browsers move things at once, and draw anew what has another
                size or colour, which they never come to if it changes too often for them.
        """
        self._place("jaw", self._jaw, scene.rotation, scene.contact_m)
        self._place("plate", self._plate, scene.rotation, scene.mouthpiece_m)
        for i, handle in enumerate(self._muscles):
            start, end = scene.muscle_origin_m[i], scene.muscle_insertion_m[i]
            self._place(f"muscle {i}", handle, _turn_to((end - start) / np.linalg.norm(end - start)), start)
        if redraw:
            self._show_muscles(scene)
            self._show_force(scene)

    def _show_muscles(self, scene: Scene) -> None:
        colours = self.colours(scene)
        for i, handle in enumerate(self._muscles):
            length = float(np.linalg.norm(scene.muscle_insertion_m[i] - scene.muscle_origin_m[i])) * UNITS_PER_M
            radius = _UNITS_PER_MM * min(1.2 + 0.9 * float(np.sqrt(scene.muscle_tension_N[i])), 7.0)
            self._set(handle, f"size {i}", "scale", (round(radius, 4), round(radius, 4), round(length, 3)))
            self._set(handle, f"colour {i}", "color", colours[i])

    def show_ghost(self, scene: Scene | None) -> None:
        """Move the ghost, a translucent mandible, to another drive's moment of the same patient; None hides it."""
        if self._ghost is None:
            if scene is None:
                return
            self._ghost = self._viser.add_frame(f"{self._root}/ghost", show_axes=False)
            self._add_mesh("/ghost/bone", outlines.mandible(), palette.ACCENT, _GHOST_OPACITY)
        self._set(self._ghost, "ghost seen", "visible", scene is not None)
        if scene is not None:
            self._place("ghost", self._ghost, scene.rotation, scene.contact_m)

    def remove(self) -> None:
        """Take all of it out of the scene, for another patient."""
        self._viser.reset()

    def _show_force(self, scene: Scene) -> None:
        size = float(np.linalg.norm(scene.mouthpiece_force_N))
        seen = size >= _LEAST_FORCE_N
        if seen:
            reach_m = (min(_MM_PER_N * size, _LONGEST_ARROW_MM) + 7.0) / 1000.0
            start = scene.mouthpiece_m + 0.010 * scene.rotation[:, 0]
            self._set(self._force, "force", "points", _arrow(start, scene.mouthpiece_force_N / size * reach_m))
        self._set(self._force, "force seen", "visible", seen)

    def _add_skull(self, scene: Scene) -> None:
        self._add_mesh("/skull/teeth", outlines.upper_teeth(), palette.TOOTH_LIGHT)
        self._add_plate("/skull/head", outlines.closed(outlines.SIDE_HEAD), 0.0, 0.22)
        for side, y in (("left", outlines.CONDYLE_Y_MM), ("right", -outlines.CONDYLE_Y_MM)):
            self._add_plate(f"/skull/arch_{side}", outlines.closed(outlines.SIDE_ARCH), y, 0.45)
            path = 1000.0 * scene.path_m(outlines.PATH_X_MM / 1000.0)
            curve = np.column_stack([outlines.PATH_X_MM, np.full_like(path, y), path])
            self._add_line(f"/skull/path_{side}", curve, palette.FOSSA)

    def _add_names(self, scene: Scene) -> None:
        """Names of the muscles at their origins on the skull, a little outside; of lines that share one, once."""
        for muscle in dict.fromkeys(scene.muscle_names):
            i = scene.muscle_names.index(muscle)
            place = scene.muscle_origin_m[i] * UNITS_PER_M + np.array([0.0, _NAME_APART, 0.0]) * np.sign(
                scene.muscle_origin_m[i][1]
            )
            self._viser.add_label(
                f"{self._root}/names/{muscle}",
                muscle_name(muscle),
                position=tuple(place.tolist()),
                font_screen_scale=_NAME_SIZE,
                anchor="bottom-center",
            )

    def _add_mesh(self, name: str, mesh: Mesh, colour: palette.Colour, opacity: float | None = None) -> Any:
        faces = np.vstack([mesh.faces[:, :3], mesh.faces[:, [0, 2, 3]]])
        unit = 1.0 if name.startswith("/muscles") else _UNITS_PER_MM
        vertices = (mesh.vertices * unit).astype(np.float32)
        triangles = faces.astype(np.uint32)
        name = self._root + name
        return self._viser.add_mesh_simple(name, vertices, triangles, color=colour, side="front", opacity=opacity)

    def _add_plate(self, name: str, outline_mm: Array, y_mm: float, opacity: float) -> None:
        """A flat, translucent piece of the skull, of its outline (N, 2) in x and z."""
        vertices = (np.insert(outline_mm, 1, y_mm, axis=1) * _UNITS_PER_MM).astype(np.float32)
        faces = _triangles(outline_mm)
        name = self._root + name
        self._viser.add_mesh_simple(name, vertices, faces, color=_BONE_PLATE, side="double", opacity=opacity)

    def _add_line(self, name: str, points_mm: Array, colour: palette.Colour) -> None:
        points = np.stack([points_mm[:-1], points_mm[1:]], axis=1) * _UNITS_PER_MM
        self._viser.add_line_segments(self._root + name, points.astype(np.float32), colour, thickness=0.018)

    def _place(self, name: str, handle: Any, turn: Array, place_m: Array) -> None:
        x, y, z, w = Rotation.from_matrix(turn).as_quat()
        self._set(handle, f"{name} turn", "wxyz", tuple(np.round([w, x, y, z], 5).tolist()))
        self._set(handle, f"{name} place", "position", tuple(np.round(place_m * UNITS_PER_M, 5).tolist()))

    def _set(self, handle: Any, key: str, attribute: str, value: Any) -> None:
        if not np.array_equal(self._sent.get(key, ()), value):
            setattr(handle, attribute, value)
            self._sent[key] = value


def _prepare(server: Any) -> None:
    """Lights, and a camera that sees the jaw from the patient's right and front."""
    server.scene.set_up_direction("+z")
    server.scene.configure_environment_map(None)  # takes four fifths of the time where the processor draws
    server.scene.configure_default_lights(enabled=False)
    server.scene.add_light_ambient("/lights/all_around", intensity=_AROUND)
    server.scene.add_light_directional("/lights/above", intensity=_ABOVE, position=_LIGHT_AT)
    server.initial_camera.position = FIRST_POSITION
    server.initial_camera.look_at = tuple((_LOOK_AT_M * UNITS_PER_M).tolist())
    server.initial_camera.fov = float(np.radians(32.0))


def _arrow(start_m: Array, along_m: Array) -> Any:
    """The ends (1, 2, 3) of an arrow, in units of the viser scene."""
    return (np.array([[start_m, start_m + along_m]]) * UNITS_PER_M).round(4).astype(np.float32)


def _triangles(outline: Array) -> Any:
    """Triangles (K, 3) that fill a closed outline (N, 2)."""
    faces = Delaunay(outline).simplices
    x, z = outline[faces].mean(axis=1).T
    (x0, z0), (x1, z1) = outline.T, np.roll(outline, -1, axis=0).T
    crosses = (z0 > z[:, None]) != (z1 > z[:, None])
    rise = np.where(z1 == z0, 1.0, z1 - z0)
    left_of_edge = x[:, None] < x0 + (z[:, None] - z0) / rise * (x1 - x0)
    return faces[(crosses & left_of_edge).sum(axis=1) % 2 == 1].astype(np.uint32)


def _spindle() -> Mesh:
    """A belly of radius 1 from the origin to (0, 0, 1)."""
    height = np.linspace(0.0, 1.0, 11)
    radius = 0.40 + 0.60 * np.sin(np.pi * height) ** 0.8
    angle = 2.0 * np.pi * np.arange(12) / 12
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    levels = np.repeat(height[:, None, None], len(angle), axis=1)
    return loft(np.concatenate([radius[:, None, None] * ring, levels], axis=-1))


def _turn_to(direction: Array) -> Array:
    """A rotation that takes the z axis to a unit direction."""
    aside = np.cross([0.0, 1.0, 0.0] if abs(direction[1]) < 0.9 else [1.0, 0.0, 0.0], direction)
    aside /= np.linalg.norm(aside)
    return np.column_stack([aside, np.cross(direction, aside), direction])
