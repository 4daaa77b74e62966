"""A stage with a mesh on it, photographed as often as wanted.

Geometry is brought into the camera's coordinates in numpy: one unit is half the height of the picture, whatever the
size of the mesh and wherever it lies. The camera never moves.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Floats
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.render import creases, glyphs, hidden
from geomhw.render.colors import Shades, shade
from geomhw.render.layers import LIGHT, Arrows, Curves, Streaks, Surface, Theme
from geomhw.render.view import View, choose_view
from geomhw.render.window import Paint, Window

Image = NDArray[np.uint8]

#: Pixels drawn for each pixel delivered, along each side.
SUPERSAMPLING = 2
#: Samples of edges within each of those; none where a mesh has many faces, each of which they make thrice as dear.
SAMPLES, MANY_FACES = 4, 100_000
#: Free border round the mesh, a fraction of the picture.
MARGIN = 0.03
#: How far lines and arrows are brought towards the viewer, so that they do not drown in the surface.
LIFT = 0.006
#: How much wider the line round a streak is than the streak, and how dense.
CASING, CASING_OPACITY = 0.6, 0.55
#: No arrow is drawn longer than this many spacings, however long its vector.
LONGEST = 2.5
#: Arrows are drawn where the cosine between normal and line of sight is larger.
RIM = 0.2


class Stage:
    """A window off screen with one mesh, one view and one size; ``photograph`` draws layers and returns pixels.

    Frames of a film share a stage: the window stays open, only what is shown changes.

    >>> with Stage(mesh, (640, 480)) as stage:  # doctest: +SKIP
    ...     frames = [stage.photograph(Surface(values)) for values in history]
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
        self._hidden = hidden.turned_away(mesh, self.view.axes[2]) if many else np.zeros(mesh.n_faces, dtype=bool)
        self._doubtful = bool(self._hidden.any())
        samples = 0 if many else SAMPLES
        self._window = Window((SUPERSAMPLING * width, SUPERSAMPLING * height), theme.background, depth, samples)

    def __enter__(self) -> "Stage":
        return self

    def __exit__(self, *reason: object) -> None:
        self.close()

    def close(self) -> None:
        """Give the window back."""
        self._window.close()

    def pixels(self, points: Floats) -> Floats:
        """Where points of the mesh are in the picture, (k, 2): columns and rows, from the upper left corner."""
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
        """The picture, (h, w, 3), of the surface and what lies on it, at ``SUPERSAMPLING`` times the size.

        shades: the surface's, where they are at hand.
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
            if hidden.in_sight(self._points, self.mesh.faces[self._hidden], self._window.nearest()):
                self._hidden = np.zeros(self.mesh.n_faces, dtype=bool)
                return self.photograph(surface, arrows, shades, streaks, curves)
        return picture

    # -- what is shown -------------------------------------------------------------------------------------------

    def _add_surface(self, surface: Surface, shades: Shades | None) -> None:
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
        if not which.any():
            return
        points, normals = self._skin
        self._window.add_triangles(points, self._shell.faces[which], paint, normals)

    def _add_lines(self, segments: Floats, color: str, width: float = 1.0) -> None:
        if len(segments):
            self._window.add_lines(segments, color, width * SUPERSAMPLING)

    def _add_arrows(self, arrows: Arrows) -> None:
        per_face = arrows.location == "face"
        mesh, axes = self.mesh, self.view.axes
        normals = mesh.face_normals if per_face else mesh.vertex_normals
        width, height = self.size
        spacing = 2 * arrows.spacing * min(width / height, 1.0)
        vectors = np.asarray(arrows.vectors, dtype=float)
        squares = np.einsum("ax,ax->a", vectors, vectors)
        # Those at the rim are seen edge on, as hairs that stick out.
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
        front = np.where(normals[:, 2:] < 0, -1.0, 1.0)  # on the side that is seen, of a sheet too
        lifted = centers + 0.1 * spacing * front * normals + [0, 0, LIFT]
        points, triangles = glyphs.arrow_triangles(lifted, drawn, normals)
        self._window.add_triangles(points, triangles, Paint(arrows.color))

    def _add_streaks(self, streaks: Streaks) -> None:
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
