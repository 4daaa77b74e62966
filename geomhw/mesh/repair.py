"""Repair of a mesh: vertices welded, degenerate and duplicate faces removed, faces oriented."""

from dataclasses import dataclass

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.errors import ArgumentError, MeshError
from geomhw.mesh.orientation import oriented
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.mesh.welding import distinct_points, first_nearby

#: Vertices of one position differ by at most this share of the extent, and of the median edge.
_OF_EXTENT, _OF_EDGE = 1e-5, 0.1


@dataclass(frozen=True)
class Repair:
    """A repaired mesh and where its vertices and faces come from.

    Attributes
    ----------
    mesh : TriangleMesh
    vertices : (n,) array
        Vertex of the original mesh for each vertex.
    faces : (m,) array
        Face of the original mesh for each face.
    first_vertices : array, one row for each vertex of the original mesh
        The vertex it is welded with, by default itself.
    steps : dict
        Number of changes of each step: ``welded_vertices``, ``degenerate_faces``, ``duplicate_faces``,
        ``reversed_faces`` and ``unreferenced_vertices``.
    tolerance : float
        Distance up to which vertices were welded.
    """

    mesh: TriangleMesh
    vertices: Ints
    faces: Ints
    first_vertices: Ints
    steps: dict[str, int]
    tolerance: float


def weld_tolerance(mesh: TriangleMesh) -> float:
    """Return the distance below which vertices of no common face are taken for one: 1e-5 of the extent.

    It is at most a tenth of the median edge length.
    """
    used = mesh.vertices[np.unique(mesh.faces)]
    extent = float((used.max(axis=0) - used.min(axis=0)).max())
    return min(_OF_EXTENT * extent, _OF_EDGE * float(np.median(mesh.edge_lengths)))


def repair(mesh: TriangleMesh, tolerance: float | None = None) -> Repair:
    """Repair a mesh in five steps.

    1. Weld vertices within a tolerance, at the position of the first.
    2. Remove faces with fewer than three different vertices or of zero area.
    3. Remove faces with the vertices of an earlier face.
    4. Orient the faces consistently, as `oriented` does.
    5. Remove vertices of no face.

    Parameters
    ----------
    mesh : TriangleMesh
    tolerance : float, optional
        Distance in units of the mesh; 0 welds vertices at equal positions only. By default `weld_tolerance`.

    Returns
    -------
    Repair

    Raises
    ------
    ArgumentError
        If the tolerance is negative or more than the median length of an edge, or leaves no face.
    MeshError
        If all faces have zero area.

    Examples
    --------
    >>> points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1e-9, 0], [1, 1, 0], [0, 1, 0]]
    >>> repaired = repair(TriangleMesh(points, [[0, 1, 2], [3, 5, 4]]))
    >>> repaired.mesh.faces.tolist(), repaired.steps["welded_vertices"], repaired.steps["reversed_faces"]
    ([[0, 1, 2], [1, 3, 2]], 2, 1)
    """
    if tolerance is None:
        tolerance = weld_tolerance(mesh)
    if not 0 <= tolerance <= (median := float(np.median(mesh.edge_lengths))):
        raise ArgumentError(
            f"vertices are joined within 0 to {median:.6g}, the median length of an edge, not {tolerance:g}"
        )
    first = _first_vertices(mesh.vertices, tolerance)
    used = np.zeros(mesh.n_vertices, dtype=bool)
    used[mesh.faces] = True
    steps = {"welded_vertices": int(np.count_nonzero(used & (first != np.arange(len(first)))))}
    corners = first[mesh.faces]
    a, b, c = corners.T
    kept = np.flatnonzero((a != b) & (b != c) & (c != a))
    if not len(kept):
        raise ArgumentError(f"no face has three different vertices after vertices within {tolerance:.3g} are joined")
    welded = TriangleMesh(mesh.vertices, corners[kept])
    sound = np.setdiff1d(np.arange(len(kept)), welded.degenerate_faces)
    steps["degenerate_faces"] = mesh.n_faces - len(sound)
    if not len(sound):
        raise MeshError("all faces of the mesh have zero area")
    kept, welded = kept[sound], TriangleMesh(mesh.vertices, welded.faces[sound])
    steps["duplicate_faces"] = len(copies := welded.duplicate_faces[:, 0])
    kept, faces = np.delete(kept, copies), np.delete(welded.faces, copies, axis=0)
    turned = oriented(TriangleMesh(mesh.vertices, faces))
    steps["reversed_faces"] = int(np.count_nonzero((turned.faces != faces).any(axis=1)))
    vertices, inverse = np.unique(turned.faces, return_inverse=True)
    steps["unreferenced_vertices"] = mesh.n_vertices - len(vertices) - steps["welded_vertices"]
    repaired = TriangleMesh(mesh.vertices[vertices], inverse.reshape(faces.shape))
    return Repair(repaired, vertices, kept, first, steps, tolerance)


def _first_vertices(points: Floats, tolerance: float) -> Ints:
    """The first vertex at the position of each."""
    first, inverse = distinct_points(points)
    return first[first_nearby(points[first], tolerance)[inverse]] if tolerance > 0 else first[inverse]
