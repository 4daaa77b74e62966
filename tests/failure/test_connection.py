"""The connection refuses vertices without a fan or normal, and unknown names."""

import numpy as np
import pytest

from geomhw.errors import FieldError, MeshError
from geomhw.mesh.primitives import grid
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.mesh.vertex_angles import edge_directions
from geomhw.operators.parallel_transport import edge_rotations, edge_transport
from geomhw.spectral.laplacian_spectrum import connection_spectrum
from support.meshes import zoo_mesh


def test_intrinsic_refuses_what_has_no_fans() -> None:
    """Pinched vertices and disagreeing faces have no cyclic order; the message names the other connection."""
    pinched = TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]], [[0, 1, 2], [0, 3, 4]])
    two_tetrahedra = np.concatenate([zoo_mesh("tetrahedron").faces, zoo_mesh("tetrahedron").faces + 3])
    points = np.concatenate([zoo_mesh("tetrahedron").vertices, [[-2, -2, 5], [3, -1, 4], [-3, 0, 6]]])
    faces = zoo_mesh("sphere").faces.copy()
    faces[3] = faces[3, ::-1]
    turned = TriangleMesh(zoo_mesh("sphere").vertices, faces)
    for mesh in (pinched, TriangleMesh(points, two_tetrahedra), turned):
        with pytest.raises(MeshError, match="connection of normals"):
            edge_directions(mesh)


def test_no_normal_is_named() -> None:
    """A vertex whose face normals cancel has no tangent plane: vectors do not pass, and the spectrum names it."""
    mesh = TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]], [[0, 1, 2], [0, 4, 3]])
    there = (mesh.edges == 0).any(axis=1)
    assert not edge_transport(mesh)[there].any()
    assert not edge_rotations(mesh)[there].any()
    np.testing.assert_allclose(np.abs(edge_transport(mesh)[~there]), 1)
    with pytest.raises(MeshError, match="vertex 0 has no normal"):
        connection_spectrum(mesh, 1)


def test_unknown_connection() -> None:
    """The message lists the connections."""
    with pytest.raises(FieldError, match="normals, intrinsic"):
        edge_transport(grid(2, 2), "discrete")  # type: ignore[arg-type]
