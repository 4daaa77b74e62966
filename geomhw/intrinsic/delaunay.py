"""Intrinsic Delaunay triangulation by edge flips: the same surface and vertices, without negative cotan weights.

Fisher, Springborn, Bobenko, Schröder: An Algorithm for the Construction of Intrinsic Delaunay Triangulations with
Applications to Digital Geometry Processing. Computing 81, 2007.
"""

from dataclasses import replace

import numpy as np

from geomhw.arrays import Floats, Ints, frozen
from geomhw.compiled import compiled
from geomhw.errors import ConvergenceError
from geomhw.intrinsic.intrinsic_mesh import IntrinsicMesh
from geomhw.mesh.topology import Edges, counting_order

#: An edge is flipped if cot α + cot β is below minus this fraction of the size of its terms: not by rounding alone,
#: also that of files with twelve digits.
TOLERANCE = 1e-9
#: The three terms of a cotangent have this error at most, in longest sides times errors of positions.
LENGTH_ERRORS = 6
#: Largest number of flips of one edge.
MAX_FLIPS = 100_000
Sides = tuple[float, float, float]


def intrinsic_delaunay(surface: IntrinsicMesh, rounding: Floats | None = None) -> tuple[IntrinsicMesh, int]:
    """Flip the edges of a closed oriented surface until all are Delaunay: opposite angles sum to at most π.

    Parameters
    ----------
    surface : IntrinsicMesh
    rounding : (n,) array
        Errors of the vertex positions, by default 0. An edge whose weight they may have made negative is kept, so that
        ties do not depend on the place of the mesh.

    Returns
    -------
    surface : IntrinsicMesh
        The same surface and vertices; edges and faces keep their numbers and change their vertices. No cotan weight is
        negative beyond rounding.
    flips : int
        Number of edge flips.

    Raises
    ------
    ConvergenceError
        If the flips do not terminate.

    Examples
    --------
    >>> from geomhw.intrinsic import tufted_cover
    >>> from geomhw.mesh import TriangleMesh
    >>> rhombus = TriangleMesh([[-1, 0, 0], [1, 0, 0], [0, 0.1, 0], [0, -0.1, 0]], [[0, 1, 2], [1, 0, 3]])
    >>> flipped, flips = intrinsic_delaunay(tufted_cover(IntrinsicMesh.of(rhombus)))
    >>> flips, float(flipped.lengths.min().round(12))  # the long diagonal becomes the short one, on both sides
    (2, 0.2)
    """
    assert surface.is_closed
    assert surface.is_edge_manifold
    assert surface.is_oriented
    faces, of_faces = surface.faces.copy(), surface.gluing.of_faces.copy()
    ends, lengths = surface.edges.copy(), surface.lengths.copy()
    halfedges = counting_order(of_faces.ravel()).reshape(-1, 2)
    flips = np.zeros(surface.n_edges, dtype=np.int64)
    rounding = np.zeros(surface.n_vertices) if rounding is None else rounding
    failed = _flip_edges(faces.ravel(), of_faces.ravel(), halfedges, ends, lengths, rounding, flips, MAX_FLIPS)
    if failed >= 0:
        raise ConvergenceError(
            f"edge flips do not terminate: an edge at vertex {ends[failed, 0]} is flipped more than {MAX_FLIPS} times; "
            "clean the mesh there"
        )
    gluing = Edges(frozen(ends), frozen(of_faces), surface.gluing.face_counts, surface.gluing.orientation_sums)
    return replace(surface, faces=frozen(faces), gluing=gluing, lengths=frozen(lengths)), int(flips.sum())


@compiled
def _flip_edges(
    corner: Ints, edge: Ints, halfedges: Ints, ends: Ints, length: Floats, rounding: Floats, flips: Ints, most: int
) -> int:
    """Flip edges in place, first in first out; return an edge that needs more than ``most`` flips, or -1.

    Halfedge 3f+k is opposite corner k of face f. ``corner`` and ``edge`` are by halfedge, ``halfedges`` by edge.
    """
    queue, waiting = np.arange(len(length)), np.ones(len(length), dtype=np.bool_)
    first, count = 0, len(length)
    around, side = np.empty(4, dtype=np.int64), np.empty(4, dtype=np.int64)
    while count:
        ab = queue[first]
        first, count, waiting[ab] = (first + 1) % len(queue), count - 1, False
        c, d = halfedges[ab]
        f, g = c - c % 3, d - d % 3
        bc, ca, ad, db = f + (c + 1) % 3, f + (c + 2) % 3, g + (d + 1) % 3, g + (d + 2) % 3
        above = length[ab], length[edge[ca]], length[edge[bc]]
        below = length[ab], length[edge[ad]], length[edge[db]]
        errors = rounding[corner[bc]] + rounding[corner[ca]]
        if _are_delaunay(above, errors + rounding[corner[c]], below, errors + rounding[corner[d]]):
            continue
        if flips[ab] == most:
            return ab
        flips[ab] += 1
        # Across the edge ab, the faces cab and dba become cad and dbc.
        (x, y), (u, v) = _apex(above), _apex(below)
        length[ab] = np.hypot(x - u, y + v)
        at_a, at_b, at_c, at_d = corner[bc], corner[ca], corner[c], corner[d]
        corner[f], corner[f + 1], corner[f + 2] = at_c, at_a, at_d
        corner[g], corner[g + 1], corner[g + 2] = at_d, at_b, at_c
        ends[ab, 0], ends[ab, 1] = min(at_c, at_d), max(at_c, at_d)
        for k, old in enumerate((ad, ca, bc, db)):
            around[k], side[k] = edge[old], halfedges[edge[old], 1] == old
        for k, new in enumerate((f, f + 2, g, g + 2)):
            edge[new], halfedges[around[k], side[k]] = around[k], new
            if not waiting[around[k]]:
                queue[(first + count) % len(queue)] = around[k]
                count, waiting[around[k]] = count + 1, True
        edge[f + 1], halfedges[ab, 0] = ab, f + 1
        edge[g + 1], halfedges[ab, 1] = ab, g + 1
    return -1


@compiled
def _are_delaunay(above: Sides, above_errors: float, below: Sides, below_errors: float) -> bool:
    """Return whether the angles opposite the first side of two triangles sum to at most π, up to rounding.

    Errors are those of the positions of their corners, summed.
    """
    return _dot(above, above_errors) * _area(below) + _dot(below, below_errors) * _area(above) >= 0.0


@compiled
def _dot(sides: Sides, errors: float) -> float:
    """Return twice the dot product of two sides at the angle opposite the first, plus the tolerance."""
    base, left, right = sides
    tolerance = max(sides) * (TOLERANCE * max(sides) + LENGTH_ERRORS * errors)
    return (right - base) * (right + base) + left * left + tolerance


@compiled
def _area(sides: Sides) -> float:
    """Return the area of a triangle, as `geometry.heron_areas` does."""
    x, y, z = sides
    low, high = min(x, y), max(x, y)
    c, b, a = min(low, z), max(low, min(high, z)), max(high, z)
    return np.sqrt(max((a + (b + c)) * (c - (a - b)) * (c + (a - b)) * (a + (b - c)), 0.0)) / 4


@compiled
def _apex(sides: Sides) -> tuple[float, float]:
    """Return the apex of a triangle whose first side lies along x from 0, as `geometry.apex` does."""
    base, left, right = sides
    return base / 2 + (left - right) * (left + right) / (2 * base), 2 * _area(sides) / base
