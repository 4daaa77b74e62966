"""Choice of the view: a parallel projection from the mesh alone, independent of its scale and position.

Candidate directions are scored by silhouette, visible detail, visible landmarks and holes that are seen through.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.mesh.geometry import unit
from geomhw.mesh.sampling import area_samples, points_on
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.render.look import AUTOMATIC, Look

#: Ratio of thickness to width below which a mesh is flat.
FLATNESS = 0.03
#: Ratio of height to width above which a flat mesh is rotated to landscape.
ELONGATION = 2.5

_AZIMUTHS = np.radians(np.arange(24) * 15.0 + 30.0)
_ELEVATIONS = np.radians([15.0, 35.0, 60.0])
#: What higher elevations cost.
_STEEP = [0.0, 0.15, 0.5]
_CELLS = 32
_SAMPLES = 10_000
#: Of silhouette, bending, bending of the top, points of interest, holes, and all but the last of these points, which
#: count if the user chose them.
_WEIGHTS = np.array([1.0, 0.3, 0.7, 0.1, 0.8, 1.5])
_FACING = 1.0
#: Smallest number of cells of a hole.
_HOLE = 4
#: Height of the base of a mesh, a fraction of its height.
_BASE = 0.03
_UPWARD = {name: np.eye(3)[k] for k, name in enumerate("xyz")}


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


def choose_view(mesh: TriangleMesh, interest: Sequence[int] = (), look: Look = AUTOMATIC) -> View:
    """Choose a view that shows the shape, its holes and, if possible, the vertices of ``interest``.

    interest: vertices of equal weight; by default those of `landmarks`. look: its ``view``, ``up`` and ``zoom`` replace
    the automatic choices.
    """
    used = np.delete(mesh.vertices, mesh.unreferenced_vertices, axis=0)
    middle = (used.min(axis=0) + used.max(axis=0)) / 2
    points = (used - middle) / np.ptp(used, axis=0).max()
    if look.view:
        azimuth, elevation = look.angles
        up = _upward(mesh, look)
        axes = camera_axes(np.radians(azimuth), np.radians(elevation), up)
    elif _is_flat(points) and not look.up:
        axes = _flat_axes(points, mesh)
    else:
        axes = _best_axes(mesh, middle, interest or landmarks(mesh), look)
    seen = (used - middle) @ axes.T
    low, high = seen.min(axis=0), seen.max(axis=0)
    return View(axes, middle + (low + high) / 2 @ axes, (high - low)[:2] / 2 / look.zoom)


def landmarks(mesh: TriangleMesh, sources: Sequence[int] = ()) -> list[int]:
    """Return the sources, by default the vertex of largest y, and the vertex farthest from the first in space."""
    used = np.unique(mesh.faces)
    first = list(sources) or [_top(mesh)]
    away = np.linalg.norm(mesh.vertices[used] - mesh.vertices[first[0]], axis=1)
    return [*first, int(used[away.argmax()])]


def _top(mesh: TriangleMesh) -> int:
    """Return the vertex of largest y, the default source."""
    used = np.unique(mesh.faces)
    return int(used[mesh.vertices[used, 1].argmax()])


def camera_axes(azimuth: float, elevation: float, up: Ints | Floats) -> Floats:
    """Return the rows right, up and toward the viewer, for angles in radians about an upward coordinate axis.

    Azimuth 0 is the front: +z if y points up, -y if z does, +y if x does; it grows to the right.
    """
    number = int(np.argmax(up))
    front = np.array([[0.0, 1, 0], [0, 0, 1], [0, -1, 0]])[number]
    right = np.cross(up, front)
    level = np.cos(azimuth) * front + np.sin(azimuth) * right
    toward = np.cos(elevation) * level + np.sin(elevation) * np.asarray(up)
    across = np.cos(azimuth) * right - np.sin(azimuth) * front
    return np.stack([across, np.cross(toward, across), toward])


def _upward(mesh: TriangleMesh, look: Look) -> Floats:
    """Return the axis that points up: the user's choice, that of the file, or a guess."""
    chosen = look.up or look.file_up
    return _UPWARD[chosen] if chosen else guess_up(mesh)


def guess_up(mesh: TriangleMesh) -> Floats:
    """Return the coordinate axis that points up: y, unless the mesh stands far more firmly along another axis."""
    points = surface_samples(mesh, _SAMPLES)
    points = (points - points.mean(axis=0)) / (np.ptp(points, axis=0).max() or 1.0)
    firm = [_firmness(points, axis) for axis in range(3)]
    best = max((2, 0), key=lambda axis: firm[axis])
    axis = best if firm[best] > 2 * firm[1] + 0.1 else 1
    return np.eye(3)[axis]


def _firmness(points: Floats, axis: int) -> float:
    """Return how firmly points stand along an axis: the share of the footprint that the base covers; 0 if they tip.

    The base is the convex hull of the lowest points. Points tip if their mean does not lie above it.
    """
    from scipy.spatial import ConvexHull, QhullError

    height, floor = points[:, axis], np.delete(points, axis, axis=1)
    low, high = height.min(), height.max()
    base = floor[height < low + _BASE * (high - low)]
    try:
        hull = ConvexHull(base)
        footprint = ConvexHull(floor)
    except (QhullError, ValueError):
        return 0.0
    margin = -float(hull.equations[:, 2].max())  # the mean is the origin
    return float(hull.volume / footprint.volume) if margin > 0 else 0.0


def _best_axes(mesh: TriangleMesh, middle: Floats, interest: Sequence[int], look: Look) -> Floats:
    """Return the axes with the highest score."""
    up = _upward(mesh, look)
    size = np.ptp(mesh.vertices[np.unique(mesh.faces)], axis=0).max()
    bends, bending = _bends(mesh)
    clouds = (surface_samples(mesh, _SAMPLES), bends, mesh.vertices[list(interest)])
    scene = [(cloud - middle) / size for cloud in clouds]
    candidates = [camera_axes(a, e, up) for e in _ELEVATIONS for a in _AZIMUTHS]
    height = scene[0] @ up
    weights = np.stack([bending, bending * (scene[1] @ up > np.quantile(height, 0.7))])
    shown = np.array([_measure(axes, scene[0], scene[1], weights, scene[2]) for axes in candidates])
    shown[:, 4] = np.minimum(shown[:, 4], max(mesh.genus or 0, 0))
    # Prefer the side to which the top fifth leans, where the face of a figure is.
    ahead = scene[0][height > np.quantile(height, 0.8)].mean(axis=0) - scene[0].mean(axis=0)
    ahead -= (ahead @ up) * up
    facing = np.array([axes[2] @ ahead for axes in candidates])
    weights = _WEIGHTS.copy()
    if interest[0] == _top(mesh):  # the default source
        weights[-1] = 0.0
    scores = shown / np.maximum(shown.max(axis=0), 1e-300) @ weights + _FACING * facing
    scores -= np.repeat(_STEEP, len(_AZIMUTHS))
    # The first of nearly equal scores keeps views of symmetric shapes independent of rounding.
    return candidates[int(np.argmax(scores > scores.max() - 1e-3))]


def surface_samples(mesh: TriangleMesh, count: int) -> Floats:
    """Return deterministic, evenly distributed points on the surface, (count, 3).

    Where not every face has one, faces are taken at random: every k-th may be one of four children of a face.
    """
    if mesh.face_areas.sum() <= 0:
        return mesh.face_centers
    order = np.random.default_rng(0).permutation(mesh.n_faces) if mesh.n_faces > count else None
    return points_on(mesh, *area_samples(mesh, count, order))


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
    right = unit(np.cross(up, toward))
    axes = np.stack([right, np.cross(toward, right), toward])
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
    """Return what `_WEIGHTS` are for: area of the silhouette, visible bending, visible points, number of holes, ...

    bending: (k, b), of which each row gives one number. Visibility is by a coarse depth buffer; the extent of the
    points is 1.
    """
    from scipy import ndimage

    seen = np.concatenate([cloud, bends, poi]) @ axes.T
    cell = np.floor((seen[:, :2] + 1) * _CELLS).astype(np.int64)
    key = cell[:, 0] * 2 * _CELLS + cell[:, 1]
    nearest = np.full(4 * _CELLS**2, -np.inf)
    np.maximum.at(nearest, key[: len(cloud)], seen[: len(cloud), 2])
    in_sight = seen[len(cloud) :, 2] > nearest[key[len(cloud) :]] - 2 / _CELLS
    filled = np.isfinite(nearest)
    shares = np.append(np.ones(len(poi) - 1), 0.5)  # the last one is the farthest point
    silhouette = filled.sum() / _CELLS**2
    detail = bending @ in_sight[: len(bends)]
    gaps, _ = ndimage.label(~filled.reshape(2 * _CELLS, -1))
    holes = np.count_nonzero(np.bincount(gaps.ravel())[1:] >= _HOLE) - 1
    visible = in_sight[len(bends) :]
    return [silhouette, *detail, visible @ shares, holes, visible[: max(len(poi) - 1, 1)].mean()]
