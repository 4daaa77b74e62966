"""Points of a mesh that are named by vertices, faces and barycentric coordinates, with checks of what is given."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from geomhw.arrays import Ints
from geomhw.errors import ArgumentError
from geomhw.mesh.surface_points import SurfacePoints
from geomhw.mesh.triangle_mesh import TriangleMesh

#: Largest deviation from 1 of the sum of three barycentric coordinates: they may be rounded to two digits.
ROUNDED_SUM = 0.015
#: A barycentric coordinate below this is set to zero: the point lies on an edge or is a vertex.
SNAP = 1e-9


def vertex_points(mesh: TriangleMesh, vertices: Sequence[int] | Ints) -> SurfacePoints:
    """Select vertices of a mesh as surface points.

    Parameters
    ----------
    mesh : TriangleMesh
    vertices : sequence of k vertex indices, at least one.

    Raises
    ------
    ArgumentError
        If there is no index, or one is not an integer, out of range or an unreferenced vertex.

    Examples
    --------
    >>> from geomhw.mesh import grid
    >>> vertex_points(grid(2, 2), [3, 1]).report()
    [3, 1]
    """
    wanted = np.atleast_1d(np.asarray(vertices))
    if wanted.size == 0:
        raise ArgumentError("there is no source; name at least one vertex")
    if not np.issubdtype(wanted.dtype, np.integer):
        raise ArgumentError(f"a source is a vertex index, a whole number, not {wanted.flat[0]}")
    if (outside := (wanted < 0) | (wanted >= mesh.n_vertices)).any():
        bad = wanted[outside][0]
        raise ArgumentError(
            f"source {bad} is not a vertex: the mesh has {mesh.n_vertices} (0 to {mesh.n_vertices - 1})"
        )
    if (loose := np.isin(wanted, mesh.unreferenced_vertices)).any():
        raise ArgumentError(f"source {wanted[loose][0]} belongs to no face; choose a vertex on the surface")
    return vertices_as_points(wanted)


def vertices_as_points(vertices: Ints) -> SurfacePoints:
    """Return vertices, (k,), as surface points, without checks."""
    k = len(vertices)
    return SurfacePoints(np.full(k, -1), np.repeat(vertices[:, None], 3, axis=1), np.tile([1.0, 0.0, 0.0], (k, 1)))


def region_points(mesh: TriangleMesh, vertices: Sequence[int] | Ints) -> SurfacePoints:
    """Select a filled region: vertices, with all edges and faces between them; raises as `vertex_points` does.

    Exact distances are from the edges and faces, too; distances by the heat method from the vertices.

    Examples
    --------
    >>> from geomhw.geodesic import ExactDistance
    >>> from geomhw.mesh import TriangleMesh
    >>> mesh = TriangleMesh([[0, 0, 0], [2, 0, 0], [1, 3, 0]], [[0, 1, 2]])
    >>> ExactDistance(mesh).from_sources(region_points(mesh, [0, 1]))["distance"].tolist()
    [0.0, 0.0, 3.0]
    """
    return replace(vertex_points(mesh, vertices), filled=np.ones(len(np.atleast_1d(vertices)), dtype=bool))


def vertex_range(mesh: TriangleMesh, first: int, last: int) -> SurfacePoints:
    """Select the vertices ``first`` to ``last``, both included; raises as `vertex_points` does.

    Examples
    --------
    >>> from geomhw.mesh import grid
    >>> vertex_range(grid(2, 2), 2, 4).vertices.tolist()
    [2, 3, 4]
    """
    vertex_points(mesh, [first, last])  # checks the ends before a range of any size is allocated
    return vertex_points(mesh, np.arange(first, last + 1))


def face_point(mesh: TriangleMesh, face: int, weights: ArrayLike | None = None) -> SurfacePoints:
    """Select a point in a face by barycentric coordinates.

    Parameters
    ----------
    mesh : TriangleMesh
    face : int
        Index of the face.
    weights : (3,) array, optional
        Barycentric coordinates in the order of the corners, nonnegative. They are divided by their sum, which must be
        within 0.015 of 1. By default the barycenter. Coordinates below 1e-9 become 0; (1, 0, 0) gives a vertex.

    Raises
    ------
    ArgumentError
        If the face does not exist or the coordinates are not valid.

    Examples
    --------
    >>> from geomhw.mesh import grid
    >>> face_point(grid(1, 1), 0, [0.5, 0.25, 0.25]).positions(grid(1, 1))
    array([[0.5 , 0.25, 0.  ]])
    """
    return face_points(mesh, [face], np.asarray([np.full(3, 1 / 3) if weights is None else weights]))


def face_points(mesh: TriangleMesh, faces: Sequence[int] | Ints, weights: ArrayLike) -> SurfacePoints:
    """Select points in faces, (k,), by barycentric coordinates, (k, 3); check each as `face_point` does."""
    return points_in_faces(np.asarray(faces), weights, mesh.n_faces, lambda face: mesh.faces[face])


def points_in_faces(face: Ints, weights: ArrayLike, m: int, corners_of: Callable[[Ints], Ints]) -> SurfacePoints:
    """Select points as `face_points` does on a mesh of m faces; corners_of: returns the corners, (k, 3), of faces."""
    b = np.asarray(weights, dtype=float)
    for outside in face[(face < 0) | (face >= m)][:1]:
        raise ArgumentError(f"face {outside} does not exist: the mesh has {m} faces (0 to {m - 1})")
    if b.shape != (len(face), 3):
        raise ArgumentError(
            f"a point in face {face[0]} has three barycentric coordinates, not {', '.join(f'{x:g}' for x in b.ravel())}"
        )
    sums = b.sum(axis=1)
    faults = {
        "a point in face {face} has three barycentric coordinates, not {given}": ~np.isfinite(sums),
        "barycentric coordinates {given} lie outside of face {face}; none may be negative": (b < 0).any(axis=1),
        "barycentric coordinates {given} in face {face} sum to {sum:g}; they must sum to 1": abs(sums - 1)
        > ROUNDED_SUM,
    }
    for sentence, wrong in faults.items():
        for k in np.flatnonzero(wrong)[:1]:
            raise ArgumentError(sentence.format(face=face[k], given=", ".join(f"{x:g}" for x in b[k]), sum=sums[k]))
    b = np.where(b < SNAP, 0.0, b)
    b /= b.sum(axis=1, keepdims=True)
    corners = corners_of(face).astype(np.int64)
    at_corner = np.count_nonzero(b, axis=1) == 1
    corners[at_corner] = corners[at_corner, b[at_corner].argmax(axis=1), None]
    b[at_corner] = 1.0, 0.0, 0.0
    return SurfacePoints(np.where(at_corner, -1, face), corners, b)


def boundary_points(mesh: TriangleMesh) -> SurfacePoints:
    """Select all boundary vertices, ascending.

    Raises
    ------
    ArgumentError
        If the mesh has no boundary.

    Examples
    --------
    >>> from geomhw.mesh import grid
    >>> boundary_points(grid(2, 2)).vertices.tolist()
    [0, 1, 2, 3, 5, 6, 7, 8]
    """
    if mesh.is_closed:
        raise ArgumentError("the mesh has no boundary; name vertices or faces as sources")
    return vertex_points(mesh, mesh.boundary_vertices)


def extreme_vertex(mesh: TriangleMesh, axis: int, sign: int) -> int:
    """Return the referenced vertex of largest (sign 1) or smallest (-1) coordinate; the lowest index on a tie."""
    height = sign * mesh.vertices[:, axis]
    height[mesh.unreferenced_vertices] = -np.inf
    return int(height.argmax())


def default_source(mesh: TriangleMesh) -> int:
    """Return the vertex of largest y, the default source of all methods."""
    return extreme_vertex(mesh, 1, 1)
