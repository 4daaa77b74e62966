"""Deformation energy: linear fields, both connections, directions of edges, and fields carried to faces."""

import numpy as np
import pytest

from geomhw.intrinsic import IntrinsicMesh
from geomhw.mesh.primitives import cylinder_band, grid, icosphere, torus
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators import carried_to_faces, deformation_energy, edge_ends, field_unknowns, to_complex
from geomhw.options import Connection


def skewed() -> TriangleMesh:
    """Return an irregular triangulation of a square in the plane."""
    mesh = grid(7, 7)
    shift = 0.04 * np.random.default_rng(4).uniform(-1, 1, (mesh.n_vertices, 3)) * [1, 1, 0]
    return TriangleMesh(mesh.vertices + shift, mesh.faces)


@pytest.mark.parametrize("connection", ["normals", "intrinsic"])
def test_linear_fields_in_the_plane(connection: Connection) -> None:
    """V = Jx has the energy |½(J + Jᵀ)|² times area; rotations have none."""
    mesh = skewed()
    energy = deformation_energy(mesh, edge_ends(mesh, connection))
    for J in np.random.default_rng(1).normal(size=(3, 2, 2)):
        z = to_complex(mesh, np.column_stack([mesh.vertices[:, :2] @ J.T, np.zeros(mesh.n_vertices)]))
        V = np.stack([z.real, z.imag], axis=1).ravel()
        expected = ((J + J.T) ** 2).sum() / 4 * mesh.face_areas.sum()
        assert V @ energy @ V == pytest.approx(expected, rel=1e-9)
    z = to_complex(mesh, np.cross([0, 0, 1.0], mesh.vertices))
    V = np.stack([z.real, z.imag], axis=1).ravel()
    assert abs(V @ energy @ V) < 1e-12


@pytest.mark.parametrize("mesh", [icosphere(1), torus(10, 6), cylinder_band(8, 3)])
def test_symmetric_positive_semidefinite_without_scale(mesh: TriangleMesh) -> None:
    """The energy is symmetric and not negative, and has no unit; unknowns are orthonormal."""
    for connection in ("normals", "intrinsic"):
        ends = edge_ends(mesh, connection)
        energy = deformation_energy(mesh, ends).toarray()
        np.testing.assert_allclose(energy, energy.T, atol=1e-13)
        assert np.linalg.eigvalsh(energy).min() > -1e-12
        scaled = TriangleMesh(1e9 * mesh.vertices, mesh.faces)
        np.testing.assert_allclose(
            deformation_energy(scaled, edge_ends(scaled, connection)).toarray(), energy, atol=1e-9
        )
        E = field_unknowns(mesh, ends)
        np.testing.assert_allclose((E.T @ E).toarray(), np.eye(E.shape[1]), atol=1e-14)


def test_edge_lengths_alone_give_the_same_energy() -> None:
    """The spectrum of the intrinsic energy does not depend on coordinates, on a mesh or on its edge lengths."""
    mesh = torus(10, 6)
    surface = IntrinsicMesh.of(mesh)
    one, other = (deformation_energy(item, edge_ends(item, "intrinsic")).toarray() for item in (mesh, surface))
    np.testing.assert_allclose(np.linalg.eigvalsh(one), np.linalg.eigvalsh(other), atol=1e-9)


def test_boundary_vertices_have_one_unknown_and_corners_none() -> None:
    """On a square: two unknowns at inner vertices, one along each side, none at the corners."""
    mesh = grid(5, 5)
    E = field_unknowns(mesh, edge_ends(mesh, "normals"))
    assert E.shape == (2 * mesh.n_vertices, 2 * 16 + 16)
    field = (E @ np.ones(E.shape[1])).reshape(-1, 2)
    corner = np.flatnonzero(np.isin(mesh.vertices[:, :2], [0, 1]).all(axis=1))
    assert not field[corner].any()
    free = field_unknowns(mesh, edge_ends(mesh, "normals"), tangent=False)
    assert free.shape[1] == 2 * mesh.n_vertices


def test_parallel_fields_keep_their_length_on_faces() -> None:
    """A constant field in the plane, and the field along a cylinder, arrive on the faces unchanged."""
    mesh = skewed()
    for connection in ("normals", "intrinsic"):
        V = carried_to_faces(mesh, edge_ends(mesh, connection), to_complex(mesh, np.tile([1.0, 2, 0], (64, 1))))
        np.testing.assert_allclose(V, np.tile([1.0, 2, 0], (mesh.n_faces, 1)), atol=1e-12)
    band = cylinder_band(12, 4)
    V = carried_to_faces(band, edge_ends(band, "normals"), to_complex(band, np.tile([0, 0, 1.0], (60, 1))))
    assert np.abs(V - [0, 0, 1.0]).max() < 0.02
