"""Rescaled angles of the edges around each vertex, in the tangent frames: the intrinsic connection."""

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Floats
from geomhw.errors import MeshError
from geomhw.mesh.geometry import corner_sum
from geomhw.mesh.polyhedral import PolyhedralSurface
from geomhw.mesh.triangle_mesh import TriangleMesh


def edge_directions(mesh: TriangleMesh) -> tuple[Floats, Floats]:
    """Return the angle of each edge at its lower and at its higher vertex, (e,) each, radians, in ``tangent_frames``.

    Angles around an inner vertex are scaled to sum to 2π [TVHM, sec. 5.2]. Angles at a boundary vertex are not scaled,
    so a flat corner stays flat. The zero direction is rotated to fit the projected edges best in the least-squares
    sense. Raises MeshError unless the mesh is an oriented manifold.
    """
    return _by_edge(mesh, *corner_directions(mesh, mesh.tangent_frames))


def corner_directions(mesh: TriangleMesh, frames: Floats) -> tuple[Floats, Floats]:
    """Return the angles of `edge_directions` of the edges to the next and the previous corner, (m, 3) each.

    frames : (n, 2, 3) tangent frames.
    """
    ahead, behind = _corner_angles(mesh)
    frames = frames[mesh.faces]
    corners = mesh.vertices[mesh.faces]
    # Each corner contributes its first edge; the last corner of an open fan also its second.
    seen = np.exp(-1j * ahead) * _unit_complex(np.roll(corners, -1, axis=1) - corners, frames)
    end = np.exp(-1j * behind) * _unit_complex(np.roll(corners, -2, axis=1) - corners, frames)
    last = mesh.edge_table.face_counts[np.roll(mesh.edge_table.of_faces, -1, axis=1)] == 1
    seen = seen + np.where(last, end, 0)
    total = corner_sum(seen.real, mesh.faces, mesh.n_vertices) + 1j * corner_sum(seen.imag, mesh.faces, mesh.n_vertices)
    turn = np.angle(total)[mesh.faces]
    return ahead + turn, behind + turn


def intrinsic_edge_directions(surface: PolyhedralSurface) -> tuple[Floats, Floats]:
    """Return angles as `edge_directions`, (e,) each, for edge lengths alone; 0 is the edge at which a fan starts."""
    return _by_edge(surface, *_corner_angles(surface))


def _unit_complex(vectors: Floats, frames: Floats) -> NDArray[np.complex128]:
    """Return the directions of vectors at corners, (m, 3), as unit complex numbers in the frames of the vertices."""
    z = np.einsum("fkx,fkx->fk", vectors, frames[:, :, 0]) + 1j * np.einsum("fkx,fkx->fk", vectors, frames[:, :, 1])
    return np.asarray(z / np.maximum(np.abs(z), np.finfo(float).tiny))


def _corner_angles(mesh: PolyhedralSurface) -> tuple[Floats, Floats]:
    """Return the scaled angles at each corner of the edges to the next and the previous corner, (m, 3) each.

    Angle 0 is the edge at which the fan of the vertex starts.
    """
    table = mesh.edge_table
    if not (mesh.is_edge_manifold and mesh.is_oriented):
        raise MeshError("the intrinsic connection needs an oriented manifold; use the connection of normals")
    count, m = 3 * mesh.n_faces, mesh.n_faces
    corner = np.arange(count).reshape(m, 3)
    # The edge from corner k to k+1 is opposite k+2. The clockwise neighbor of a corner lies across that edge.
    leaving = np.roll(table.of_faces, -2, axis=1)
    arriving = np.roll(table.of_faces, -1, axis=1)
    owner = np.where(mesh.faces < np.roll(mesh.faces, -2, axis=1), 0, 1)
    by_arrival = np.full((mesh.n_edges, 2), -1)
    by_arrival[arriving, owner] = corner
    side = np.where(mesh.faces < np.roll(mesh.faces, -1, axis=1), 0, 1)
    before = by_arrival[leaving, side].ravel()
    # An open fan starts at the boundary, a closed one at the first corner of the vertex.
    flat = mesh.faces.ravel()
    first = np.full(mesh.n_vertices, -1)
    first[flat[::-1]] = np.arange(count)[::-1]
    border = np.flatnonzero(before < 0)
    several_fans = len(np.unique(flat[border])) < len(border)
    first[flat[border]] = border
    before[first[first >= 0]] = -1
    # Sums along the fans by pointer doubling: the number of rounds is logarithmic in the largest valence.
    start = np.where(before >= 0, mesh.angles.ravel()[before], 0.0)
    total = corner_sum(mesh.angles, mesh.faces, mesh.n_vertices)
    for _ in range(64):
        start = start + np.where(before >= 0, start[before], 0.0)
        before = np.where(before >= 0, before[before], -1)
        if (before < 0).all():
            break
    if several_fans or (before >= 0).any():  # a closed fan without the first corner of its vertex is a cycle
        raise MeshError(
            "the intrinsic connection needs a single fan of faces around each vertex; use the connection of normals"
        )
    stretch = 2 * np.pi / np.where(total > 0, total, 1.0)
    stretch[mesh.boundary_vertices] = 1.0
    stretch = stretch[flat]
    return (start * stretch).reshape(m, 3), ((start + mesh.angles.ravel()) * stretch).reshape(m, 3)


def _by_edge(mesh: PolyhedralSurface, ahead: Floats, behind: Floats) -> tuple[Floats, Floats]:
    """Gather angles at corners by edge: at the lower and at the higher vertex, (e,) each."""
    low, high = np.zeros(mesh.n_edges), np.zeros(mesh.n_edges)
    leaving, arriving = np.roll(mesh.edge_table.of_faces, -2, axis=1), np.roll(mesh.edge_table.of_faces, -1, axis=1)
    # Two faces give the same angle up to rounding or a full turn; the value of the later face is kept.
    for edges, angles, other in ((arriving, behind, -2), (leaving, ahead, -1)):
        below = mesh.faces < np.roll(mesh.faces, other, axis=1)
        low[edges[below]] = angles[below]
        high[edges[~below]] = angles[~below]
    return low, high
