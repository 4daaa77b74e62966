"""Paths on a surface: polylines of points in faces."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.geodesic.strips import Crossings, Strip
from geomhw.mesh.inserted_points import InsertedPoints
from geomhw.mesh.named_points import face_point
from geomhw.mesh.surface_points import SurfacePoints
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.results import Cloud, Field


@dataclass(frozen=True, eq=False, repr=False)
class SurfacePath:
    """A polyline on a mesh; each of its segments lies in a face.

    Attributes
    ----------
    mesh : TriangleMesh
    faces : (k,) integer array
        The face of the segment that follows each point; of the last point, the face of the last segment.
    weights : (k, 3) array
        Barycentric coordinates of the points in these faces.
    tied : bool
        Whether another shortest path comes to the end from another direction, so that the end lies on the cut locus of
        the sources, as far as `ShortestPaths` looked for it.
    stop : {"", "boundary", "non-manifold edge"}
        Where a traced line ends before its length.
    """

    mesh: TriangleMesh
    faces: Ints
    weights: Floats
    tied: bool = False
    stop: str = ""

    def __repr__(self) -> str:
        return f"SurfacePath of {len(self.faces)} points, length {self.length:.6g}"

    @cached_property
    def positions(self) -> Floats:
        """Coordinates of the points, (k, 3)."""
        return np.asarray(np.einsum("kc,kcx->kx", self.weights, self.mesh.vertices[self.mesh.faces[self.faces]]))

    @cached_property
    def arc_length(self) -> Floats:
        """Length of the path from its start to each point, (k,)."""
        steps = np.linalg.norm(np.diff(self.positions, axis=0), axis=1)
        return np.append(0.0, np.cumsum(steps))

    @property
    def length(self) -> float:
        """Length of the path."""
        return float(self.arc_length[-1])

    @property
    def vertices(self) -> Ints:
        """The vertices of the mesh at which the path has points, in order, its ends included."""
        at = np.flatnonzero((self.weights == 1).any(axis=1))
        return np.asarray(self.mesh.faces[self.faces[at], self.weights[at].argmax(axis=1)])

    @property
    def crossings(self) -> int:
        """Number of edges that the path crosses between its ends, at inner points of the edges."""
        inner = self.weights[1:-1]
        return int(((inner == 0).sum(axis=1) == 1).sum())

    def end(self, k: int) -> SurfacePoints:
        """Return the start, k = 0, or the end, k = -1, as a point on the surface."""
        return face_point(self.mesh, int(self.faces[k]), self.weights[k])


def polylines(paths: Sequence[SurfacePath]) -> Cloud:
    """Return paths as polylines.

    Returns
    -------
    Cloud with ``path`` (number of the path), ``face``, ``barycentric`` and ``arc_length`` on points, and ``length`` of
    each path.
    """
    sizes = [len(path.faces) for path in paths]
    fields = [
        Field("path", "vertex", np.repeat(np.arange(len(paths), dtype=np.int32), sizes)),
        Field("face", "vertex", np.concatenate([path.faces for path in paths]).astype(np.int32)),
        Field("barycentric", "vertex", np.concatenate([path.weights for path in paths])),
        Field("arc_length", "vertex", np.concatenate([path.arc_length for path in paths])),
        Field("length", "mesh", np.array([path.length for path in paths])),
    ]
    return Cloud(np.concatenate([path.positions for path in paths]), fields, np.cumsum([0, *sizes]))


def joined(paths: Sequence[SurfacePath]) -> SurfacePath:
    """Return the path along several paths, each of which starts at the end of the one before."""
    kept = [slice(0, -1)] * (len(paths) - 1) + [slice(None)]
    faces = np.concatenate([path.faces[part] for path, part in zip(paths, kept, strict=True)])
    weights = np.concatenate([path.weights[part] for path, part in zip(paths, kept, strict=True)])
    return SurfacePath(paths[0].mesh, faces, weights, any(path.tied for path in paths))


def path_in_strip(mesh: TriangleMesh, strip: Strip, found: Crossings) -> SurfacePath:
    """Return the shortest path in a strip of a mesh."""
    enter = np.array(strip.enter, dtype=np.int64)
    faces, corner = np.divmod(enter, 3)
    weights, rows = np.zeros((len(enter), 3)), np.arange(len(enter))
    one, other = (corner + 1) % 3, (corner + 2) % 3
    swap = mesh.faces[faces, one] > mesh.faces[faces, other]
    low, high = np.where(swap, other, one), np.where(swap, one, other)
    weights[rows, low], weights[rows, high] = 1 - found.shares, found.shares
    # Several edges crossed at one vertex give one point, in the last face there.
    at = np.where(found.shares == 0, mesh.faces[faces, low], np.where(found.shares == 1, mesh.faces[faces, high], -1))
    kept = (at < 0) | (at != np.append(at[1:], -1))
    faces = np.concatenate([[strip.first], faces[kept], [strip.last]])
    return SurfacePath(mesh, faces, np.concatenate([[strip.start], weights[kept], [strip.end]]))


def on_original(mesh: TriangleMesh, inserted: InsertedPoints, path: SurfacePath) -> SurfacePath:
    """Return the path on the mesh before points were inserted, without points inside of faces between its ends."""
    weights = np.einsum("kc,kcx->kx", path.weights, inserted.corners[path.faces])
    kept = (weights == 0).any(axis=1)
    kept[[0, -1]] = True
    return SurfacePath(mesh, inserted.parents[path.faces[kept]], weights[kept], path.tied)
