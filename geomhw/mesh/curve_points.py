"""Curves on a surface as points and the segments between them."""

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.errors import ArgumentError
from geomhw.mesh.named_points import vertex_points
from geomhw.mesh.surface_points import SurfacePoints
from geomhw.mesh.triangle_mesh import TriangleMesh


def curve_points(mesh: TriangleMesh, faces: Ints, weights: Floats) -> SurfacePoints:
    """Return the points of a polyline and its segments.

    Parameters
    ----------
    mesh : TriangleMesh
    faces, weights : (k,) and (k, 3) arrays
        Points in barycentric coordinates. Each segment lies in the face of its first point. A last point equal to the
        first closes the curve.

    Examples
    --------
    >>> from geomhw.mesh import grid
    >>> curve = curve_points(grid(1, 1), np.array([0, 0]), np.array([[0.5, 0.5, 0], [0, 0.5, 0.5]]))
    >>> len(curve), curve.segments.tolist()
    (2, [[0, 1, 0]])
    """
    corners = mesh.faces[faces].astype(np.int64)
    at = (weights == 1).any(axis=1)
    vertex = corners[np.arange(len(faces)), weights.argmax(axis=1)]
    count = np.arange(len(faces))
    return SurfacePoints(
        np.where(at, -1, faces),
        np.where(at[:, None], vertex[:, None], corners),
        np.where(at[:, None], [1.0, 0.0, 0.0], weights),
        segments=np.column_stack([count[:-1], count[1:], faces[:-1]]),
    )


def edge_points(mesh: TriangleMesh, sides: Ints) -> SurfacePoints:
    """Return the ends of edges, ascending, and the edges as segments in the direction of a face.

    Parameters
    ----------
    mesh : TriangleMesh
    sides : (s,) integer array
        3f + k for the side of face f opposite its corner k.

    Raises
    ------
    ArgumentError
        If there is no edge.

    Examples
    --------
    >>> from geomhw.mesh import grid
    >>> edge_points(grid(1, 1), np.array([2])).segments.tolist()
    [[0, 1, 0]]
    """
    if not len(sides):
        raise ArgumentError("there is no edge")
    face, corner = np.divmod(np.asarray(sides), 3)
    ends = np.stack([mesh.faces[face, (corner + 1) % 3], mesh.faces[face, (corner + 2) % 3]], axis=1)
    vertices, number = np.unique(ends, return_inverse=True)
    points = vertex_points(mesh, vertices)
    segments = np.column_stack([number.reshape(-1, 2), face])
    return SurfacePoints(points.faces, points.corners, points.weights, segments=segments)


def even_samples(mesh: TriangleMesh, points: SurfacePoints, spacing: float) -> tuple[SurfacePoints, Floats]:
    """Return points evenly spread along segments, and the direction of the segment at each.

    Parameters
    ----------
    mesh : TriangleMesh
    points : SurfacePoints
        With segments; they count one after the other, in their order.
    spacing : largest distance between neighboring samples, along the segments.

    Returns
    -------
    samples : SurfacePoints
        s points within faces, or on edges.
    directions : (s, 3) array of unit vectors

    Examples
    --------
    >>> from geomhw.mesh import grid
    >>> samples, along = even_samples(grid(1, 1), edge_points(grid(1, 1), np.array([2])), 0.5)
    >>> samples.positions(grid(1, 1))[:, 0].tolist(), along[0].tolist()
    ([0.25, 0.75], [1.0, 0.0, 0.0])
    """
    i, j, face = points.segments.T
    positions = points.positions(mesh)
    steps = positions[j] - positions[i]
    length = np.linalg.norm(steps, axis=1)
    ends = np.cumsum(length)
    count = int(np.ceil(ends[-1] / spacing))
    at = (np.arange(count) + 0.5) * (ends[-1] / count)
    segment = np.minimum(np.searchsorted(ends, at, side="right"), len(ends) - 1)
    share = 1 - (ends[segment] - at) / length[segment]
    corners = mesh.faces[face[segment]].astype(np.int64)
    of_points, rows = points.corner_weights(), corners.tolist()

    def in_faces(ends_of: Ints) -> Floats:
        """The barycentric coordinates of ends of segments in the faces of these."""
        found = zip(ends_of[segment].tolist(), rows, strict=True)
        return np.array([[of_points[p].get(v, 0.0) for v in row] for p, row in found])

    start, end = in_faces(i), in_faces(j)
    weights = (1 - share)[:, None] * start + share[:, None] * end
    return SurfacePoints(face[segment], corners, weights), steps[segment] / length[segment][:, None]
