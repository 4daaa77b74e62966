"""Gaps of broken curves, closed by cubic arcs from the end of one curve to the start of another."""

from collections.abc import Sequence

import numpy as np

from geomhw.arrays import Floats
from geomhw.curves.traced import trace_polylines
from geomhw.geodesic.surface_path import SurfacePath
from geomhw.mesh.geometry import lengths, unit
from geomhw.mesh.triangle_mesh import TriangleMesh

#: Longest gap, and the sum of all, as shares of the length of the curves.
LONGEST, TOGETHER = 0.3, 0.5
#: Length of curve, in mean edges, from which the direction at an end is estimated, twice.
BEHIND = 2.0
#: The same as a share of the gap, if that is longer.
SMOOTH = 0.2
#: Distance between points of an arc, in mean edges.
SPACING = 0.5


def bridge_gaps(mesh: TriangleMesh, curves: Sequence[SurfacePath]) -> list[SurfacePath]:
    """Return arcs that join ends of curves to starts of curves, the nearest pairs first.

    At both ends, an arc turns by less than a right angle from the direction to the other end. The gap is at most 0.3 of
    the length of all curves, and the gaps together half of it. Ends on the boundary of the surface stay.

    Parameters
    ----------
    mesh : TriangleMesh
    curves : paths of at least two points.

    Raises
    ------
    FieldError
        If an arc leaves the surface.

    Examples
    --------
    >>> from geomhw.curves import trace_polyline
    >>> from geomhw.mesh import grid
    >>> square = grid(8, 8)
    >>> parts = [[[0.2, 0.2, 0], [0.7, 0.2, 0], [0.7, 0.7, 0]], [[0.6, 0.7, 0], [0.2, 0.7, 0], [0.2, 0.2, 0]]]
    >>> (arc,) = bridge_gaps(square, [trace_polyline(square, part).path for part in parts])
    >>> arc.positions[[0, -1], 0].round(6).tolist()
    [0.7, 0.6]
    """
    loose = [path for path in curves if not (path.positions[0] == path.positions[-1]).all()]
    if not loose:
        return []
    whole = sum(path.length for path in curves)
    starts, ends = (np.array([path.positions[k] for path in loose]) for k in (0, -1))
    behind = BEHIND * mesh.mean_edge_length
    onward = np.array([_direction(path.positions, behind) for path in loose])
    first = np.array([-_direction(path.positions[::-1], behind) for path in loose])
    across = starts[None] - ends[:, None]
    gap = np.linalg.norm(across, axis=2)
    fits = (np.einsum("ijx,ix->ij", across, onward) >= 0) & (np.einsum("ijx,jx->ij", across, first) >= 0)
    component = mesh.components[[mesh.faces[path.faces[0], 0] for path in loose]]
    fits &= (gap <= LONGEST * whole) & (component[:, None] == component)
    fits[[_on_boundary(mesh, path, -1) for path in loose]] = False
    fits[:, [_on_boundary(mesh, path, 0) for path in loose]] = False
    touching = gap == 0  # one curve continues another
    free_end, free_start = ~touching.any(axis=1), ~touching.any(axis=0)
    rows, columns = np.nonzero(fits)
    arcs, total = [], 0.0
    for k in np.argsort(gap[rows, columns], kind="stable"):
        i, j = int(rows[k]), int(columns[k])
        if not (free_end[i] and free_start[j]):
            continue
        total += float(gap[i, j])
        if total > TOGETHER * whole:
            break
        reach = max(behind, SMOOTH * float(gap[i, j]))
        leaving, arriving = (_direction(points, reach) for points in (loose[i].positions, loose[j].positions[::-1]))
        arcs.append(_arc(ends[i], starts[j], leaving, -arriving, SPACING * mesh.mean_edge_length))
        free_end[i] = free_start[j] = False
    names = [f"the arc across gap {k}" for k in range(len(arcs))]
    return [curve.path for curve in trace_polylines(mesh, arcs, names)] if arcs else []


def _direction(points: Floats, behind: float) -> Floats:
    """Return the unit direction of a polyline at its last point: of the arc of a circle through it and two others."""
    backward = points[::-1]
    reach = np.append(0.0, np.cumsum(lengths(np.diff(backward, axis=0))))
    behind = min(behind, float(reach[-1]) / 2)
    last, middle, before = (
        np.array([np.interp(x, reach, column) for column in backward.T]) for x in behind * np.arange(3)
    )
    near, far = unit(np.array([last - middle, middle - before]))
    turn = float(np.arccos(np.clip(near @ far, -1, 1)))
    if not 0 < turn < np.pi / 2:
        return np.asarray(near)
    return np.asarray((np.sin(1.5 * turn) * near - np.sin(turn / 2) * far) / np.sin(turn))


def _arc(p: Floats, q: Floats, onward: Floats, first: Floats, spacing: float) -> Floats:
    """Return points on a cubic curve between two points with these directions, close to an arc of a circle."""
    gap = float(np.linalg.norm(q - p))
    turn = float(np.arccos(np.clip(onward @ first, -1, 1)))
    size = gap / np.cos(turn / 4) ** 2
    u = np.linspace(0, 1, int(np.ceil(gap / spacing)) + 2)[:, None]
    from_p, from_q = u * (1 - u) ** 2, -(u**2) * (1 - u)
    points = (1 + 2 * u) * (1 - u) ** 2 * p + u**2 * (3 - 2 * u) * q + size * (from_p * onward + from_q * first)
    points[0], points[-1] = p, q
    return np.asarray(points)


def _on_boundary(mesh: TriangleMesh, path: SurfacePath, k: int) -> bool:
    """Whether the start, 0, or the end, -1, of a path is on the boundary of the surface."""
    face, weights = path.faces[k], path.weights[k]
    sides = mesh.edge_table.of_faces[face][weights == 0]
    at_edge = bool((mesh.edge_table.face_counts[sides] == 1).any())
    return at_edge or bool(np.isin(mesh.faces[face][weights == 1], mesh.boundary_vertices).any())
