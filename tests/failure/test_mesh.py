"""TriangleMesh refuses wrong arrays, and its own arrays are read-only."""

import numpy as np
import pytest

from geomhw.errors import MeshError
from geomhw.mesh.primitives import grid
from geomhw.mesh.triangle_mesh import TriangleMesh


def test_arrays_are_read_only_and_own() -> None:
    """A mesh copies the caller's arrays, and its own arrays are read-only."""
    vertices = np.eye(3)
    mesh = TriangleMesh(vertices, [[0, 1, 2]])
    vertices[0] = 7
    assert mesh.vertices[0, 0] == 1
    for array in (mesh.vertices, mesh.faces, mesh.face_areas, mesh.edges, mesh.vertex_normals, mesh.tangent_frames):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0


@pytest.mark.parametrize(
    ("vertices", "faces", "words"),
    [
        (np.zeros((3, 2)), [[0, 1, 2]], r"\(n, 3\)"),
        (np.eye(3), np.empty((0, 3), dtype=int), "no faces"),
        (np.eye(3), [[0, 1, 2, 2]], r"\(m, 3\)"),
        (np.eye(3), [[0.0, 1.0, 2.0]], "integers"),
        ([[0, 0, 0], [np.nan, 0, 0], [0, 1, 0]], [[0, 1, 2]], "vertex 1 .*finite"),
        ([[0, 0, 0], [np.inf, 0, 0], [0, 1, 0]], [[0, 1, 2]], "vertex 1 .*finite"),
        (np.eye(3), [[0, 1, 3]], "face 0 .* from 0 to 2"),
        (np.eye(3), [[0, 1, -1]], "face 0"),
        (np.eye(3), [[0, 1, 2], [0, 1, 1]], "face 1 names a vertex twice"),
    ],
)
def test_refusals(vertices: object, faces: object, words: str) -> None:
    """Arrays of wrong shape, type or content raise, with the vertex or face."""
    with pytest.raises(MeshError, match=words):
        TriangleMesh(vertices, faces)  # type: ignore[arg-type]


def test_zero_area_is_named() -> None:
    """A face of zero area raises with its index."""
    square = grid(2, 2)
    vertices = square.vertices.copy()
    face = square.faces[3]
    vertices[face[2]] = (vertices[face[0]] + vertices[face[1]]) / 2
    mesh = TriangleMesh(vertices, square.faces)
    assert mesh.degenerate_faces.size
    with pytest.raises(MeshError, match=f"face {mesh.degenerate_faces[0]} .*zero area"):
        mesh.require_area()
