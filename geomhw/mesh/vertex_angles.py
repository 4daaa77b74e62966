"""Corners in order round each vertex, and the rescaled angles at which edges leave it."""

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Floats, Ints
from geomhw.errors import MeshError
from geomhw.mesh.geometry import corner_sum
from geomhw.mesh.triangle_mesh import TriangleMesh


def edge_directions(mesh: TriangleMesh) -> tuple[Floats, Floats]:
    """Angle at which each edge leaves its lower and its higher vertex, twice (e,), radians, in ``tangent_frames``.

    Angles round an inner vertex are stretched to sum to 2π [TVHM, sec. 5.2]; round a boundary vertex they stay as they
    are, which lays a flat corner out as it is. The start is turned so that the angles agree best with the edges as
    projected to the tangent plane. MeshError unless the mesh is an oriented manifold.
    """
    ahead, behind = _corner_angles(mesh)
    frames = mesh.tangent_frames[mesh.faces]
    corners = mesh.vertices[mesh.faces]
    # Every corner knows the edge at its start; where a fan ends at the boundary, the last corner adds its far edge.
    seen = np.exp(-1j * ahead) * _unit_complex(np.roll(corners, -1, axis=1) - corners, frames)
    end = np.exp(-1j * behind) * _unit_complex(np.roll(corners, -2, axis=1) - corners, frames)
    last = mesh.edge_table.face_counts[np.roll(mesh.edge_table.of_faces, -1, axis=1)] == 1
    seen = seen + np.where(last, end, 0)
    total = corner_sum(seen.real, mesh.faces, mesh.n_vertices) + 1j * corner_sum(seen.imag, mesh.faces, mesh.n_vertices)
    turn = np.angle(total)[mesh.faces]
    return _by_edge(mesh, ahead + turn, behind + turn)


def _unit_complex(vectors: Floats, frames: Floats) -> NDArray[np.complex128]:
    """Directions of vectors at corners, (m, 3), as unit complex numbers in the frames of their vertices."""
    z = np.einsum("fkx,fkx->fk", vectors, frames[:, :, 0]) + 1j * np.einsum("fkx,fkx->fk", vectors, frames[:, :, 1])
    return np.asarray(z / np.maximum(np.abs(z), np.finfo(float).tiny))


def _corner_angles(mesh: TriangleMesh) -> tuple[Floats, Floats]:
    """Stretched angle of the edge to the next, and to the previous, corner of its face, at each corner, (m, 3) each.

    Zero along the edge where the vertex's fan starts.
    """
    table = mesh.edge_table
    if not (mesh.is_edge_manifold and mesh.is_oriented):
        raise MeshError("the intrinsic connection needs an oriented manifold; use the connection of normals")
    count, m = 3 * mesh.n_faces, mesh.n_faces
    corner = np.arange(count).reshape(m, 3)
    # The edge from corner k to k+1 is opposite k+2. Before it, turning clockwise, comes the corner across that edge.
    leaving = np.roll(table.of_faces, -2, axis=1)
    arriving = np.roll(table.of_faces, -1, axis=1)
    owner = np.where(mesh.faces < np.roll(mesh.faces, -2, axis=1), 0, 1)
    by_arrival = np.full((mesh.n_edges, 2), -1)
    by_arrival[arriving, owner] = corner
    side = np.where(mesh.faces < np.roll(mesh.faces, -1, axis=1), 0, 1)
    before = by_arrival[leaving, side].ravel()
    # A fan starts at the boundary, or at the vertex's first corner.
    flat = mesh.faces.ravel()
    first = np.full(mesh.n_vertices, -1)
    first[flat[::-1]] = np.arange(count)[::-1]
    border = np.flatnonzero(before < 0)
    if len(np.unique(flat[border])) < len(border):
        raise MeshError(_PINCHED)
    first[flat[border]] = border
    before[first[first >= 0]] = -1
    # Sums along the fans by pointer doubling: as many rounds as the largest valence has binary digits.
    start = np.where(before >= 0, mesh.angles.ravel()[before], 0.0)
    total = corner_sum(mesh.angles, mesh.faces, mesh.n_vertices)
    for _ in range(64):
        if (before < 0).all():
            break
        start = start + np.where(before >= 0, start[before], 0.0)
        before = np.where(before >= 0, before[before], -1)
    else:
        raise MeshError(_PINCHED)
    _require_one_fan(flat, start, total, mesh)
    stretch = 2 * np.pi / np.where(total > 0, total, 1.0)
    stretch[mesh.boundary_vertices] = 1.0
    stretch = stretch[flat]
    return (start * stretch).reshape(m, 3), ((start + mesh.angles.ravel()) * stretch).reshape(m, 3)


_PINCHED = "the intrinsic connection needs a single fan of faces round each vertex; use the connection of normals"


def _require_one_fan(flat: Ints, start: Floats, total: Floats, mesh: TriangleMesh) -> None:
    """MeshError where the fan that starts at the first corner does not hold all corners of its vertex."""
    furthest = np.zeros(mesh.n_vertices)
    np.maximum.at(furthest, flat, start + mesh.angles.ravel())
    if np.any(furthest < total * (1 - 1e-9)):
        raise MeshError(_PINCHED)


def _by_edge(mesh: TriangleMesh, ahead: Floats, behind: Floats) -> tuple[Floats, Floats]:
    """Angles at corners gathered by edge: at the lower vertex, at the higher."""
    low, high = np.zeros(mesh.n_edges), np.zeros(mesh.n_edges)
    leaving, arriving = np.roll(mesh.edge_table.of_faces, -2, axis=1), np.roll(mesh.edge_table.of_faces, -1, axis=1)
    # Where two faces know the same angle they differ by rounding or a full turn: the later one in the file wins.
    for edges, angles, other in ((arriving, behind, -2), (leaving, ahead, -1)):
        below = mesh.faces < np.roll(mesh.faces, other, axis=1)
        low[edges[below]] = angles[below]
        high[edges[~below]] = angles[~below]
    return low, high
