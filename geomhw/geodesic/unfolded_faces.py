"""Faces of a mesh laid out in the plane, and the halfedges by which paths pass between them.

Halfedge 3f+k is the side of face f opposite its corner k. Its coordinates start at the lower of its two vertices.
"""

from math import atan2, inf, pi, sqrt
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
#: ``totals`` of vertices at which paths do not turn.
CONVEX = -1.0


class Surface(NamedTuple):
    """Halfedges of a mesh.

    points: (n, 3). faces: (m, 3). across: (3m,), the next halfedge at the same edge, itself on the boundary. corners:
    halfedges opposite each vertex, those of v at ``starts[v]`` to ``starts[v + 1]``. sides: (3m,), number of faces at
    the edge of each halfedge. angles: (3m,), of the corner opposite each halfedge, 0 until `angle` computes it. totals:
    (n,), of `total_angle`, 0 until then.
    """

    points: Floats
    faces: Ints
    across: Ints
    corners: Ints
    starts: Ints
    sides: Ints
    angles: Floats
    totals: Floats


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
    counts = np.diff(first, append=len(by_edge))
    sides = np.zeros(len(edge), dtype=np.int32)
    sides[by_edge] = np.repeat(counts, counts)
    angles, totals = np.zeros(len(edge)), np.zeros(mesh.n_vertices)
    return Surface(mesh.vertices, mesh.faces, across, by_vertex, starts, sides, angles, totals)


@compiled_in_place
def total_angle(surface: Surface, v: int) -> float:
    """Total angle of the faces at a vertex; CONVEX where paths do not turn, inf where they may turn in any direction.

    Paths do not turn where the faces are one closed fan of angle at most 2π. They may turn in any direction where the
    faces are no closed fan, and at a needle, where rounding may lose the windows on both sides of a path along it.
    """
    if surface.totals[v] == 0:
        surface.totals[v] = _total_angle(surface, v)
    return surface.totals[v]


@compiled_in_place
def _total_angle(surface: Surface, v: int) -> float:
    """Compute what `total_angle` returns."""
    h = first = np.int64(surface.corners[surface.starts[v]])
    side, total = h - h % 3 + (h + 1) % 3, 0.0
    for count in range(surface.starts[v + 1] - surface.starts[v]):
        face = triangle(surface, h)
        longest, g = max(face.base, face.left, face.right), surface.across[side]
        is_needle = face.sin_low * face.left * face.base <= NEEDLE * longest * longest
        if (count > 0 and h == first) or is_needle or g == side or surface.across[g] != side:
            return inf
        total += angle(surface, h)
        h, side = next_corner(surface, v, side)
    return total if total > 2 * pi + FLAT else CONVEX


@compiled_in_place
def angle(surface: Surface, h: int) -> float:
    """Angle of a face at the corner opposite its halfedge h."""
    if surface.angles[h] == 0:
        face = triangle(surface, h)
        surface.angles[h] = pi - atan2(face.sin_low, face.cos_low) - atan2(face.sin_high, face.cos_high)
    return surface.angles[h]


@compiled_in_place
def next_corner(surface: Surface, v: int, side: int) -> tuple[int, int]:
    """Halfedges of the face across a side at a vertex v: the one opposite v, and the other side at v."""
    g = np.int64(surface.across[side])
    h = g - g % 3
    while surface.faces[h // 3, h % 3] != v:
        h += 1
    return h, 3 * (g // 3) + 3 - h % 3 - g % 3


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
