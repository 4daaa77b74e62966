"""Faces of a mesh laid out in the plane, and the halfedges by which paths pass between them.

Halfedge 3f+k is the side of face f opposite its corner k. Its coordinates start at the lower of its two vertices.
"""

from math import atan2, pi, sqrt
from typing import Any, NamedTuple

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.compiled import compiled_in_place
from geomhw.mesh.topology import counting_order
from geomhw.mesh.triangle_mesh import TriangleMesh

#: A vertex is a saddle if its angle exceeds 2π by more, in radians.
FLAT = 1e-13
#: A face is a needle if its height is below this share of its longest edge.
NEEDLE = 1e-6
#: Kinds of vertices: paths pass only beside it, or also turn at it. 0 where not yet known.
CONVEX, TURNING = 1, 2


class Surface(NamedTuple):
    """Halfedges of a mesh.

    points: (n, 3). faces: (m, 3). across: (3m,), the next halfedge at the same edge, itself on the boundary. corners:
    halfedges opposite each vertex, those of v at ``starts[v]`` to ``starts[v + 1]``. kinds: (n,), of vertices, computed
    on first use. sides: largest number of faces at an edge.
    """

    points: Floats
    faces: Ints
    across: Ints
    corners: Ints
    starts: Ints
    kinds: Ints
    sides: int


class Triangle(NamedTuple):
    """A face over one of its halfedges: vertices, the other two halfedges, lengths, and angles at the base."""

    low: int
    high: int
    apex: int
    at_low: int
    at_high: int
    base: float
    left: float
    right: float
    cos_low: float
    sin_low: float
    cos_high: float
    sin_high: float


def surface_of(mesh: TriangleMesh, included: Any) -> Surface:
    """Link the halfedges at each edge and list those opposite each vertex, of the faces in a mask, (m,)."""
    edge, vertex = mesh.edge_table.of_faces.ravel(), mesh.faces.ravel()
    by_edge, by_vertex = (order[included[order // 3]] for order in (counting_order(edge), counting_order(vertex)))
    first = np.flatnonzero(np.diff(edge[by_edge], prepend=-1))
    following = np.append(by_edge[1:], 0)
    following[np.append(first[1:], len(by_edge)) - 1] = by_edge[first]
    across = np.arange(len(edge), dtype=by_edge.dtype)
    across[by_edge] = following
    starts = np.append(0, np.cumsum(np.bincount(vertex[by_vertex], minlength=mesh.n_vertices)))
    sides = int(np.diff(first, append=len(by_edge)).max())
    kinds = np.zeros(mesh.n_vertices, dtype=np.int8)
    return Surface(mesh.vertices, mesh.faces, across, by_vertex, starts, kinds, sides)


@compiled_in_place
def is_turning(surface: Surface, v: int) -> bool:
    """Whether shortest paths may turn at a vertex: unless its faces are one closed fan of angle at most 2π, no needle.

    At a needle, rounding may lose the windows on both sides of a path that runs along it.
    """
    h = first = np.int64(surface.corners[surface.starts[v]])
    out = triangle(surface, h).at_low
    angle = 0.0
    for count in range(surface.starts[v + 1] - surface.starts[v]):
        face = triangle(surface, h)
        if count > 0 and h == first:
            return True
        angle += pi - atan2(face.sin_low, face.cos_low) - atan2(face.sin_high, face.cos_high)
        g = np.int64(surface.across[out])
        longest = max(face.base, face.left, face.right)
        if g == out or surface.across[g] != out or face.sin_low * face.left * face.base <= NEEDLE * longest * longest:
            return True
        h = g // 3 * 3
        while surface.faces[h // 3, h % 3] != v:
            h += 1
        face = triangle(surface, h)
        out = face.at_high if g == face.at_low else face.at_low
    return angle > 2 * pi + FLAT


@compiled_in_place
def ends(surface: Surface, h: int) -> tuple[int, int]:
    """Lower and higher vertex of a halfedge."""
    f, k = h // 3, h % 3
    a, b = np.int64(surface.faces[f, (k + 1) % 3]), np.int64(surface.faces[f, (k + 2) % 3])
    return min(a, b), max(a, b)


@compiled_in_place
def triangle(surface: Surface, h: int) -> Triangle:
    """Lay out a face over its halfedge h; angles at an edge of length zero are 0."""
    f, k = h // 3, h % 3
    i, j = (k + 1) % 3, (k + 2) % 3
    if surface.faces[f, i] > surface.faces[f, j]:
        i, j = j, i
    low, high, apex = np.int64(surface.faces[f, i]), np.int64(surface.faces[f, j]), np.int64(surface.faces[f, k])
    p, q, r = surface.points[low], surface.points[high], surface.points[apex]
    ex, ey, ez, lx, ly, lz = q[0] - p[0], q[1] - p[1], q[2] - p[2], r[0] - p[0], r[1] - p[1], r[2] - p[2]
    rx, ry, rz = r[0] - q[0], r[1] - q[1], r[2] - q[2]
    base, left, right = (
        sqrt(ex * ex + ey * ey + ez * ez),
        sqrt(lx * lx + ly * ly + lz * lz),
        sqrt(rx * rx + ry * ry + rz * rz),
    )
    # The cross product of the two shorter sides; any other is too inaccurate where the third is short.
    ax, ay, az = (lx, ly, lz) if left <= base or left <= right else (ex, ey, ez)
    bx, by, bz = (rx, ry, rz) if right <= base or right < left else (ex, ey, ez)
    area = sqrt((ay * bz - az * by) ** 2 + (az * bx - ax * bz) ** 2 + (ax * by - ay * bx) ** 2)
    cos_low = cos_high = 1.0
    sin_low = sin_high = 0.0
    if base * left > 0:
        cos_low, sin_low = (ex * lx + ey * ly + ez * lz) / (base * left), area / (base * left)
    if base * right > 0:
        cos_high, sin_high = -(ex * rx + ey * ry + ez * rz) / (base * right), area / (base * right)
    return Triangle(low, high, apex, 3 * f + j, 3 * f + i, base, left, right, cos_low, sin_low, cos_high, sin_high)
