"""A stage: the window with one mesh and view that draws surfaces, arrows, curves and streaks.

Geometry is transformed to camera coordinates in numpy: one unit is half the height of the picture. The camera is fixed.
"""

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Floats
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.options import PANEL_WIDTH
from geomhw.render import flow_lines, glyphs, texture
from geomhw.render.arrow_places import arrow_places
from geomhw.render.colors import Shades, shade
from geomhw.render.layers import LIGHT, Arrows, Curves, Streaks, Surface, Theme
from geomhw.render.view import View, choose_view
from geomhw.render.window import Paint, Window, isolines, smooth_surface

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
#: Distance in pixels and in depth to the visible surface up to which a point counts as visible.
NEAR = 3.0, 0.02
#: Largest distance in depth from an arrow to the surface, in its lengths: a larger one is at a silhouette.
STEP = 1.0


#: Slope, at most, by which a curve over another one is lifted.
STEEP = 3.0


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
        depth = 1.1 * float(np.abs(np.delete(self._points[:, 2], mesh.unreferenced_vertices)).max()) + 1.0
        self._skin = smooth_surface(self._points, mesh.faces)
        self._origin = np.asarray(self._skin.point_data["origin"])
        self._depths: Floats | None = None
        self._line = 2 / height * max(width / PANEL_WIDTH, 1.0)
        samples = 0 if mesh.n_faces > MANY_FACES else SAMPLES
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
        textures = [item for item in arrows if item.style == "lic"]
        self._add_surface(surface, shades)
        for item in textures:
            self._add_texture(item, surface, shades)
        clipped = bool(arrows or streaks)
        if clipped and self._depths is None:
            self._window.pixels()
            self._depths = self._window.nearest()
        for number, line in enumerate(curves):  # later ones lie over earlier ones
            segments = self.view.project(line.segments) / self.unit
            if number:  # over the ends of earlier strips, too, which reach into their neighbors
                segments[..., 2] += _rise(segments, curves[number - 1].width * self._line)[:, None]
            self._add_lines(segments + np.array([0, 0, (1 + number) * LIFT]), line.color, line.width)
        for item in arrows:
            if item.style == "streamlines":
                self._add_streamlines(item)
            elif item.style == "arrows":
                self._add_arrows(item)
        for comets in streaks:
            self._add_streaks(comets)
        picture = self._window.pixels()
        if self._depths is None:
            self._depths = self._window.nearest()
        if clipped:  # nothing reaches over the silhouette
            picture[~self.covered] = list(bytes.fromhex(self.theme.background[1:]))
        return picture

    @cached_property
    def covered(self) -> NDArray[np.bool_]:
        """Mask of the drawn pixels, (h, w), that show the surface."""
        return np.isfinite(self.depths)

    @property
    def depths(self) -> Floats:
        """Depth of the surface at each drawn pixel, (h, w), toward the viewer; nan where there is none."""
        if self._depths is None:
            self.photograph(Surface())
        assert self._depths is not None
        return self._depths

    def depth_at(self, points: Floats) -> Floats:
        """Return the depth of the surface, (k,), behind or before points in camera coordinates, (k, 3)."""
        height, width = self.depths.shape
        places = np.floor(points[:, :2] * [1, -1] * height / 2 + [width / 2, height / 2]).astype(np.int64)
        column, row = np.clip(places, 0, [width - 1, height - 1]).T
        return np.asarray(self.depths[row, column])

    def visible(self, points: Floats) -> NDArray[np.bool_]:
        """Return whether points of the surface, (k, 3), are visible, to ``NEAR`` pixels and units of depth."""
        seen = self.view.project(points) / self.unit
        steps = NEAR[0] * 2 / self.size[1] * np.array([-1, -0.5, 0, 0.5, 1])
        around = [self.depth_at(seen + np.array([x, y, 0])) for x in steps for y in steps]
        return np.asarray(seen[:, 2] > np.min(np.nan_to_num(around, nan=-np.inf), axis=0) - NEAR[1])

    # -- layers --------------------------------------------------------------------------------------------------------

    def _add_surface(self, surface: Surface, shades: Shades | None) -> None:
        """Add the colored mesh and its isolines."""
        if shades is None:
            self._window.add_surface(self._skin, Paint(surface.color))
            return
        table = None if shades.rgb else shades.table
        values = shades.values if shades.per_face else shades.values[self._origin]
        known = shades.known if shades.per_face else np.asarray(shades.known[self.mesh.faces].all(axis=1))
        skin = self._skin
        if not known.all():
            self._window.add_surface(_part(skin, ~known), Paint(self.theme.unknown))
            skin, values = _part(skin, known), values[known] if shades.per_face else values
        if known.any():
            self._window.add_surface(skin, Paint(values=values, table=table, per_face=shades.per_face))
            if len(shades.levels):
                segments = isolines(skin, values, shades.levels)
                self._add_lines(segments + np.array([0, 0, LIFT]), self.theme.line)

    def _add_lines(self, segments: Floats, color: str, width: float = 1.0) -> None:
        """Add line segments."""
        if len(segments):
            points, triangles = glyphs.ribbons(segments, width * self._line)
            self._window.add_triangles(points, triangles, Paint(color))

    def _add_arrows(self, arrows: Arrows) -> None:
        """Add arrows, thinned and lifted off the surface."""
        (width, height), axes = self.size, self.view.axes
        spacing = 2 * arrows.spacing * min(width / height, 1.0)
        places, vectors, normals = arrow_places(self.mesh, arrows, spacing * self.unit)
        squares = np.einsum("ax,ax->a", vectors, vectors)
        # Arrows at the rim are seen edge-on.
        usable = np.flatnonzero(np.isfinite(squares) & (squares > 0) & (np.abs(normals @ axes[2]) > RIM))
        if not len(usable):
            return
        centers = self.view.project(places[usable]) / self.unit
        kept = glyphs.spread(centers, spacing)
        centers, keep = centers[kept], usable[kept]
        normals, vectors = normals[keep] @ axes.T, vectors[keep] @ axes.T
        length = np.linalg.norm(vectors, axis=1)
        full = length if arrows.scale is None else arrows.scale
        drawn = vectors * np.minimum(spacing / full, LONGEST * spacing / length)[:, None]
        front = np.where(normals[:, 2:] < 0, -1.0, 1.0)  # the visible side of an open surface
        lifted = centers + 0.1 * spacing * front * normals + [0, 0, LIFT]
        whole = self._on_surface(centers, drawn)
        if whole.any():
            points, triangles = glyphs.arrow_triangles(lifted[whole], drawn[whole], normals[whole])
            self._window.add_triangles(points, triangles, Paint(arrows.color))

    def _add_streamlines(self, layer: Arrows) -> None:
        """Add streamlines of a layer of arrows, with heads."""
        width, height = self.size
        spacing = 2 * flow_lines.DENSITY * layer.spacing * min(width / height, 1.0)
        streamlines = layer.lines or flow_lines.traced(self.mesh, layer, spacing * self.unit)
        spacing = min(streamlines.spacing / self.unit, spacing)
        lines = flow_lines.flow_lines(streamlines, layer.scale)
        if not len(lines.points):
            return
        points = self.view.project(lines.points) / self.unit + np.array([0, 0, LIFT])
        strips = glyphs.strips(points, lines.segments, flow_lines.WIDTH * self._line * lines.widths)
        self._window.add_triangles(*strips, Paint(layer.color))
        shown = np.abs(lines.normals @ self.view.axes[2]) > RIM
        normals, ahead = lines.normals[shown] @ self.view.axes.T, lines.ahead[shown] @ self.view.axes.T
        centers = self.view.project(lines.heads[shown]) / self.unit
        vectors = flow_lines.HEAD * spacing * np.sqrt(lines.sizes[shown])[:, None] * ahead
        whole = self._on_surface(centers, vectors)
        if whole.any():
            front = np.where(normals[:, 2:] < 0, -1.0, 1.0)
            lifted = centers + 0.1 * spacing * front * normals + [0, 0, 1.5 * LIFT]
            heads = glyphs.head_triangles(lifted[whole], vectors[whole], normals[whole])
            self._window.add_triangles(*heads, Paint(layer.color))

    def _add_texture(self, layer: Arrows, surface: Surface, shades: Shades | None) -> None:
        """Add the surface once more, with its colors modulated by a texture along the vectors."""
        size = texture.CELL * self._line * self.unit
        cells = texture.cells(self.mesh, layer, size)
        points, normals, triangles = cells.refined(
            self._skin.regular_faces, self._skin.points, self._skin.point_normals
        )
        colors = cells.colors(surface, shades, self._skin.regular_faces, self._origin, self.theme)
        lifted = points + np.array([0, 0, 0.2 * LIFT])
        self._window.add_textured(lifted, normals, triangles, colors)

    def _on_surface(self, centers: Floats, vectors: Floats) -> NDArray[np.bool_]:
        """Return the mask of arrows that do not reach over a silhouette in front of other parts of the surface."""
        room = STEP * np.linalg.norm(vectors, axis=1) + 0.02
        ends = (centers + share * vectors for share in (-0.5, 0.25, 0.5))
        return np.all([~(np.abs(self.depth_at(end) - end[:, 2]) > room) for end in ends], axis=0)

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


def _part(surface: Any, which: NDArray[np.bool_]) -> Any:
    """Return the faces of a surface in a mask, with all its points."""
    import pyvista

    part = pyvista.PolyData.from_regular_faces(surface.points, surface.regular_faces[which])
    part.point_data.active_normals = surface.point_data.active_normals
    return part


def _rise(segments: Floats, width: float) -> Floats:
    """How far strips of a width along segments, (s, 2, 3), reach toward the viewer beside the segments, (s,)."""
    along = np.abs(segments[:, 1] - segments[:, 0])
    across = np.hypot(along[:, 0], along[:, 1])
    return np.asarray(width * np.minimum(along[:, 2] / np.maximum(across, 1e-12), STEEP))
