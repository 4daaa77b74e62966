"""A stage: the window with one mesh and view that draws surfaces, arrows, curves and streaks.

Geometry is transformed to camera coordinates in numpy: one unit is half the height of the picture. The camera is fixed.

Large closed meshes are drawn without the faces turned away. A line of sight enters a closed surface through a face
turned to the viewer and leaves through one turned away, which is therefore hidden, unless the surface intersects itself
or is oriented inward. The depth buffer of the first picture confirms it.
"""

from collections.abc import Sequence
from functools import reduce

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Floats
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.render import creases, glyphs
from geomhw.render.colors import Shades, shade
from geomhw.render.layers import LIGHT, Arrows, Curves, Streaks, Surface, Theme
from geomhw.render.view import View, choose_view
from geomhw.render.window import Paint, Window

Image = NDArray[np.uint8]

#: Number of drawn pixels per pixel of the picture, along each side.
SUPERSAMPLING = 2
#: Samples per drawn pixel; 0 for meshes with many faces, where samples triple the drawing time.
SAMPLES, MANY_FACES = 4, 100_000
#: Margin around the mesh, a fraction of the picture.
MARGIN = 0.03
#: Shift of lines and arrows toward the viewer, so that the surface does not hide them.
LIFT = 0.006
#: Relative width and opacity of the outline of a streak.
CASING, CASING_OPACITY = 0.6, 0.55
#: Largest length of an arrow, in spacings.
LONGEST = 2.5
#: Smallest cosine between normal and line of sight at which arrows are drawn.
RIM = 0.2


class Stage:
    """An offscreen window with one mesh, view and size; ``photograph`` draws layers and returns pixels.

    The frames of a film share a stage and its window.

    >>> from geomhw.mesh import icosphere
    >>> from geomhw.render.layers import Surface
    >>> mesh = icosphere(2)
    >>> with Stage(mesh, (160, 120)) as stage:
    ...     frames = [stage.photograph(Surface(k * mesh.vertices[:, 2])) for k in (1, 2)]
    >>> frames[0].shape[2]
    3
    """

    def __init__(
        self, mesh: TriangleMesh, size: tuple[int, int], view: View | None = None, theme: Theme = LIGHT
    ) -> None:
        self.mesh, self.size, self.theme = mesh, size, theme
        self.view = view or choose_view(mesh)
        width, height = size
        room = np.array([width / height, 1.0]) * (1 - 2 * MARGIN)
        self.unit = float(np.max(self.view.extent / room))  # mesh length of one unit on stage
        self._points = self.view.project(mesh.vertices) / self.unit
        self._shell = shell = creases.shell(mesh)
        self._skin = self._points[shell.origin], shell.normals @ self.view.axes.T
        depth = 1.1 * float(np.abs(np.delete(self._points[:, 2], mesh.unreferenced_vertices)).max()) + 1.0
        many = mesh.n_faces > MANY_FACES
        self._hidden = turned_away(mesh, self.view.axes[2]) if many else np.zeros(mesh.n_faces, dtype=bool)
        self._doubtful = bool(self._hidden.any())
        samples = 0 if many else SAMPLES
        self._window = Window((SUPERSAMPLING * width, SUPERSAMPLING * height), theme.background, depth, samples)

    def __enter__(self) -> "Stage":
        return self

    def __exit__(self, *reason: object) -> None:
        self._window.close()

    def pixels(self, points: Floats) -> Floats:
        """Return the pixel coordinates of points of the mesh, (k, 2): column and row from the upper left corner."""
        width, height = self.size
        seen = self.view.project(points)[:, :2] / self.unit
        return np.asarray(np.array([width, height]) / 2 + seen * [1, -1] * height / 2)

    def photograph(
        self,
        surface: Surface,
        arrows: Sequence[Arrows] = (),
        shades: Shades | None = None,
        streaks: Sequence[Streaks] = (),
        curves: Sequence[Curves] = (),
    ) -> Image:
        """Draw the surface and the layers on it; return the picture, (h, w, 3), at ``SUPERSAMPLING`` times the size.

        shades: colors of the surface, if they are known already.
        """
        shades = shades or shade(surface, self.mesh)
        self._window.clear()
        self._add_surface(surface, shades)
        for line in curves:
            segments = self.view.project(line.segments) / self.unit + np.array([0, 0, LIFT])
            self._add_lines(segments, line.color, line.width)
        for item in arrows:
            self._add_arrows(item)
        for comets in streaks:
            self._add_streaks(comets)
        picture = self._window.pixels()
        if self._doubtful:
            self._doubtful = False
            if in_sight(self._points, self.mesh.faces[self._hidden], self._window.nearest()):
                self._hidden = np.zeros(self.mesh.n_faces, dtype=bool)
                return self.photograph(surface, arrows, shades, streaks, curves)
        return picture

    # -- layers --------------------------------------------------------------------------------------------------------

    def _add_surface(self, surface: Surface, shades: Shades | None) -> None:
        """Add the colored mesh and its isolines."""
        drawn = ~self._hidden
        if shades is None:
            self._add_shell(drawn, Paint(surface.color))
            return
        if shades.per_face or shades.known.all():
            known = shades.known if shades.per_face else np.ones(self.mesh.n_faces, dtype=bool)
        else:
            known = np.asarray(shades.known[self.mesh.faces].all(axis=1))
        self._add_shell(drawn & ~known, Paint(self.theme.unknown))
        values = shades.values[drawn & known] if shades.per_face else shades.values[self._shell.origin]
        table = None if shades.rgb else shades.table
        self._add_shell(drawn & known, Paint(values=values, table=table, per_face=shades.per_face))
        if not len(shades.levels):
            return
        segments = glyphs.isoline_segments(self._points, self.mesh.faces[known], shades.values, shades.levels)
        self._add_lines(segments + np.array([0, 0, LIFT]), self.theme.line)

    def _add_shell(self, which: NDArray[np.bool_], paint: Paint) -> None:
        """Add faces of the mesh."""
        if not which.any():
            return
        points, normals = self._skin
        self._window.add_triangles(points, self._shell.faces[which], paint, normals)

    def _add_lines(self, segments: Floats, color: str, width: float = 1.0) -> None:
        """Add line segments."""
        if len(segments):
            self._window.add_lines(segments, color, width * SUPERSAMPLING)

    def _add_arrows(self, arrows: Arrows) -> None:
        """Add arrows, thinned and lifted off the surface."""
        per_face = arrows.location == "face"
        mesh, axes = self.mesh, self.view.axes
        normals = mesh.face_normals if per_face else mesh.vertex_normals
        width, height = self.size
        spacing = 2 * arrows.spacing * min(width / height, 1.0)
        vectors = np.asarray(arrows.vectors, dtype=float)
        squares = np.einsum("ax,ax->a", vectors, vectors)
        # Arrows at the rim are seen edge-on.
        usable = np.flatnonzero(np.isfinite(squares) & (squares > 0) & (np.abs(normals @ axes[2]) > RIM))
        if not len(usable):
            return
        if arrows.points is not None:
            centers = self.view.project(arrows.points[usable]) / self.unit
        else:
            centers = glyphs.middles(self._points, mesh.faces[usable]) if per_face else self._points[usable]
        kept = glyphs.spread(centers, spacing)
        centers, keep = centers[kept], usable[kept]
        normals, vectors = normals[keep] @ axes.T, vectors[keep] @ axes.T
        length = np.linalg.norm(vectors, axis=1)
        full = length if arrows.scale is None else arrows.scale
        drawn = vectors * np.minimum(spacing / full, LONGEST * spacing / length)[:, None]
        front = np.where(normals[:, 2:] < 0, -1.0, 1.0)  # the visible side of an open surface
        lifted = centers + 0.1 * spacing * front * normals + [0, 0, LIFT]
        points, triangles = glyphs.arrow_triangles(lifted, drawn, normals)
        self._window.add_triangles(points, triangles, Paint(arrows.color))

    def _add_streaks(self, streaks: Streaks) -> None:
        """Add streaks with their outlines."""
        width, height = self.size
        facing = np.abs(streaks.normals @ self.view.axes[2])
        shown = facing > RIM
        if not shown.any():
            return
        radii = streaks.width * min(width / height, 1.0) * np.minimum(2 * facing[shown], 1.0)
        paths = self.view.project(streaks.paths[:, shown]) / self.unit + np.array([0, 0, LIFT])
        layers = [
            (glyphs.comets(paths, (1 + CASING) * radii), streaks.casing, CASING_OPACITY),
            (glyphs.comets(paths + np.array([0, 0, 0.2 * LIFT]), radii), streaks.color, 1.0),
        ]
        for (points, triangles, density), color, opacity in layers:
            rgb = np.array([int(color[k : k + 2], 16) for k in (1, 3, 5)], dtype=np.uint8)
            alpha = np.round(255 * opacity * density).astype(np.uint8)
            rgba = np.column_stack([np.tile(rgb, (len(points), 1)), alpha])
            self._window.add_triangles(points, triangles, Paint(values=rgba))


def turned_away(mesh: TriangleMesh, toward: Floats) -> NDArray[np.bool_]:
    """Return the mask, (m,), of faces turned away from the viewer; empty unless the mesh is closed and oriented."""
    if not (mesh.is_closed and mesh.is_oriented):
        return np.zeros(mesh.n_faces, dtype=bool)
    return np.asarray(mesh.face_normals @ toward <= 0)


def in_sight(points: Floats, faces: NDArray[np.int32], nearest: Floats) -> bool:
    """Return whether the center of a face, (k, 3), that was not drawn lies in front of everything drawn around it.

    points: (n, 3) in camera coordinates. nearest: z at each pixel, (h, w), bottom row first. The tolerance is a pixel
    in each direction.
    """
    height, width = nearest.shape
    middles = glyphs.middles(points, faces)
    places = np.floor(middles[:, :2] * height / 2 + [width / 2, height / 2]).astype(np.int64)
    column, row = np.clip(places, 0, [width - 1, height - 1]).T
    steps = [(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1)]
    round_it = (nearest[np.clip(row + i, 0, height - 1), np.clip(column + j, 0, width - 1)] for i, j in steps)
    near = reduce(np.maximum, round_it)
    return bool(np.any(middles[:, 2] > near + 2 / height))
