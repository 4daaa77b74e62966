"""Choice of the view: a parallel projection from the mesh alone, independent of its scale and position.

The y axis points up. The view is slightly from above, in the direction that shows most of the surface.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.mesh.geometry import unit
from geomhw.mesh.sampling import area_samples, points_on
from geomhw.mesh.triangle_mesh import TriangleMesh

#: Ratio of thickness to width below which a mesh is flat.
FLATNESS = 0.03
#: Ratio of height to width above which a flat mesh is rotated to landscape.
ELONGATION = 2.5

_AZIMUTHS = np.radians(np.arange(12) * 30.0 + 30.0)
_ELEVATIONS = np.radians([20.0, 40.0])
_CELLS = 48
_SAMPLES = 20_000
_WEIGHTS = np.array([1.0, 0.6, 0.15])  # silhouette, bending, points of interest
_FACING = 0.8


@dataclass(frozen=True)
class View:
    """A parallel projection.

    axes: rows right, up, toward the viewer. center: the point in the middle of the picture. extent: half width and half
    height of the projected mesh.
    """

    axes: Floats
    center: Floats
    extent: Floats

    @property
    def aspect(self) -> float:
        """Ratio of width to height of the projected mesh."""
        return float(self.extent[0] / max(self.extent[1], 1e-3 * self.extent[0]))

    def project(self, points: Floats) -> Floats:
        """Return points in view coordinates (right, up, toward the viewer), in the units of the mesh."""
        return np.asarray((points - self.center) @ self.axes.T)


def choose_view(mesh: TriangleMesh, interest: Sequence[int] = ()) -> View:
    """Choose a view that shows the shape and, if possible, the vertices of ``interest``."""
    used = np.delete(mesh.vertices, mesh.unreferenced_vertices, axis=0)
    middle = (used.min(axis=0) + used.max(axis=0)) / 2
    size = np.ptp(used, axis=0).max()
    points = (used - middle) / size
    axes = _flat_axes(points, mesh) if _is_flat(points) else None
    if axes is None:
        bends, bending = _bends(mesh)
        scene = [(p - middle) / size for p in (surface_samples(mesh, _SAMPLES), bends, mesh.vertices[list(interest)])]
        candidates = [_axes(_direction(a, e), np.array([0.0, 1.0, 0.0])) for e in _ELEVATIONS for a in _AZIMUTHS]
        shown = np.array([_measure(axes, scene[0], scene[1], bending, scene[2]) for axes in candidates])
        # Prefer the side to which the top fifth leans, where the face of a figure is.
        top = scene[0][:, 1] > np.quantile(scene[0][:, 1], 0.8)
        ahead = scene[0][top].mean(axis=0) - scene[0].mean(axis=0)
        facing = np.array([axes[2, [0, 2]] @ ahead[[0, 2]] for axes in candidates])
        scores = shown / np.maximum(shown.max(axis=0), 1e-300) @ _WEIGHTS + _FACING * facing
        # The first of nearly equal scores keeps views of symmetric shapes independent of rounding.
        axes = candidates[int(np.argmax(scores > scores.max() - 1e-3))]
    seen = (used - middle) @ axes.T
    low, high = seen.min(axis=0), seen.max(axis=0)
    return View(axes, middle + (low + high) / 2 @ axes, (high - low)[:2] / 2)


def visible(mesh: TriangleMesh, view: View, vertices: Sequence[int], at: Floats | None = None) -> list[bool]:
    """Return whether each vertex is visible: no face lies in front of it.

    at: (k, 3), a point in a face of each vertex, tested instead of the vertex.
    """
    points = view.project(mesh.vertices)
    places = points[list(vertices)] if at is None else view.project(at)
    near = 1e-3 * np.ptp(points, axis=0).max()
    answers = []
    for vertex, p in zip(vertices, places, strict=True):  # a handful of markers
        round_it = mesh.faces[_boxed(points, mesh.faces, p)]
        a, b, c = (points[round_it[:, k]] for k in range(3))
        areas = np.stack([_turn(b - p, c - p), _turn(c - p, a - p), _turn(a - p, b - p)], axis=1)
        total = areas.sum(axis=1)
        inside = (total != 0) & (((areas >= 0).all(axis=1)) | ((areas <= 0).all(axis=1)))
        weights = areas[inside] / total[inside, None]
        depth = np.einsum("fk,fk->f", weights, np.stack([a[inside, 2], b[inside, 2], c[inside, 2]], axis=1))
        own = (round_it[inside] == vertex).any(axis=1)
        answers.append(not np.any((depth > p[2] + near) & ~own))
    return answers


def _boxed(points: Floats, faces: Ints, p: Floats) -> Ints:
    """Return the faces whose bounding box in the picture contains p."""
    sides = np.zeros(len(points), dtype=np.uint8)
    for bit, away in enumerate((points[:, 0] < p[0], points[:, 0] > p[0], points[:, 1] < p[1], points[:, 1] > p[1])):
        sides |= away.astype(np.uint8) << bit
    a, b, c = (sides[faces[:, k]] for k in range(3))
    return np.flatnonzero(a & b & c == 0)  # the corners are not all on one side of p


def surface_samples(mesh: TriangleMesh, count: int) -> Floats:
    """Return deterministic, evenly distributed points on the surface, (count, 3)."""
    if mesh.face_areas.sum() <= 0:
        return mesh.face_centers
    return points_on(mesh, *area_samples(mesh, count))


def _turn(p: Floats, q: Floats) -> Floats:
    """Return the z component of cross products, (k,)."""
    return np.asarray(p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0])


def _direction(azimuth: float, elevation: float) -> Floats:
    """Return the unit vector toward the viewer; azimuth 0 is +z and grows toward +x."""
    across = np.cos(elevation)
    return np.array([across * np.sin(azimuth), np.sin(elevation), across * np.cos(azimuth)])


def _axes(toward: Floats, up: Floats) -> Floats:
    """Return the rows right, up, toward, from the direction to the viewer and an upward vector."""
    right = unit(np.cross(up, toward))
    return np.stack([right, np.cross(toward, right), toward])


def _is_flat(points: Floats) -> bool:
    """Return whether the points lie nearly in a plane."""
    centered = points - points.mean(axis=0)
    thinnest, middle, _ = np.linalg.eigvalsh(np.einsum("px,py->xy", centered, centered))
    return bool(thinnest < FLATNESS**2 * middle)


def _flat_axes(points: Floats, mesh: TriangleMesh) -> Floats:
    """Return the axes that face a flat mesh; y points up unless the mesh is elongated or horizontal."""
    _, _, (_, _, thin) = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)
    side = float(thin @ (mesh.face_areas @ mesh.face_normals))
    tallest = thin[np.abs(thin).argmax()]
    toward = thin if (side if abs(side) > 1e-6 * mesh.face_areas.sum() else tallest) > 0 else -thin
    up = np.array([0.0, 1.0, 0.0]) if abs(toward[1]) < 0.7 else np.array([0.0, 0.0, -1.0])
    axes = _axes(toward, up)
    extent = np.ptp(points @ axes.T, axis=0)
    if extent[1] > ELONGATION * extent[0]:
        axes = np.stack([axes[1], -axes[0], axes[2]])
    return axes


def _bends(mesh: TriangleMesh) -> tuple[Floats, Floats]:
    """Return midpoints of a sample of the edges, and their bending: change of the normal times edge length."""
    some = slice(None, None, 1 + mesh.n_edges // _SAMPLES)
    start, end = mesh.edges[some].T
    turning = np.linalg.norm(mesh.vertex_normals[start] - mesh.vertex_normals[end], axis=1)
    return (mesh.vertices[start] + mesh.vertices[end]) / 2, turning * mesh.edge_lengths[some]


def _measure(axes: Floats, cloud: Floats, bends: Floats, bending: Floats, poi: Floats) -> list[float]:
    """Return the area of the silhouette, the visible bending, and the visible share of the points of interest.

    Visibility is by a coarse depth buffer; the extent of the points is 1.
    """
    seen = np.concatenate([cloud, bends, poi]) @ axes.T
    cell = np.floor((seen[:, :2] + 1) * _CELLS).astype(np.int64)
    key = cell[:, 0] * 2 * _CELLS + cell[:, 1]
    nearest = np.full(4 * _CELLS**2, -np.inf)
    np.maximum.at(nearest, key[: len(cloud)], seen[: len(cloud), 2])
    in_sight = seen[len(cloud) :, 2] > nearest[key[len(cloud) :]] - 2 / _CELLS
    silhouette = np.isfinite(nearest).sum() / _CELLS**2
    detail = in_sight[: len(bends)] @ bending
    return [silhouette, detail, in_sight[len(bends) :].mean() if len(poi) else 0.0]
