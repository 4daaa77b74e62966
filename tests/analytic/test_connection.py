"""The discrete connection on the sphere: edge directions, and holonomy against curvature."""

import numpy as np
import pytest

from geomhw.mesh.primitives import icosphere
from geomhw.mesh.vertex_angles import edge_directions
from geomhw.operators.parallel_transport import edge_transport


def test_intrinsic_directions_follow_the_edges() -> None:
    """On the sphere, rescaled corner angles give the directions of projected edges, with an error of order h²."""
    mesh = icosphere(4)
    low, high = edge_directions(mesh)
    i, j = mesh.edges.T
    for start, end, angle in ((i, j, low), (j, i, high)):
        edge = mesh.vertices[end] - mesh.vertices[start]
        z = np.einsum("ekx,ex->ke", mesh.tangent_frames[start], edge)
        assert np.abs(np.angle((z[0] + 1j * z[1]) * np.exp(-1j * angle))).max() < 0.01


def test_holonomy_is_curvature() -> None:
    """Transport round a face turns a vector by the curvature of the face; the total is 4π."""
    mesh = icosphere(3)
    table = mesh.edge_table
    for connection in ("normals", "intrinsic"):
        r = edge_transport(mesh, connection)
        upward = mesh.faces < np.roll(mesh.faces, -1, axis=1)
        edge = np.roll(table.of_faces, -2, axis=1)
        # From corner k on to k+1: r brings from the higher vertex down, its conjugate from the lower up.
        step = np.where(upward, r[edge].conj(), r[edge])
        turned = np.angle(step.prod(axis=1))
        assert turned.sum() == pytest.approx(4 * np.pi, rel=1e-9)
        np.testing.assert_allclose(turned / mesh.face_areas, 4 * np.pi / mesh.face_areas.sum(), rtol=0.2)
