"""OBJ files: every dialect gives the same square."""

import numpy as np
import pytest

from geomhw.io import read, read_mesh
from support.obj_files import SAME, SQUARE, load
from support.reference import needs_reference, reference


@pytest.mark.parametrize("dialect", SAME)
def test_dialects_give_the_same_mesh(tmp_path, dialect):
    """Each dialect gives the vertices and faces of the square."""
    result = read(load(tmp_path, SAME[dialect]))
    np.testing.assert_array_equal(result.mesh.vertices, SQUARE)
    np.testing.assert_array_equal(result.mesh.faces, [[0, 1, 2], [0, 2, 3]])
    quad = {"polygons": 1} if dialect == "quad" else {}
    assert result.report == {"file": "moo.obj", "format": "OBJ", **quad}


@needs_reference
@pytest.mark.parametrize(
    ("name", "n", "m"), [("hostile/stanford-bunny.obj", 35947, 69451), ("hostile/moebius.obj", 280, 448)]
)
def test_reference_meshes(name, n, m):
    """Real files give the known numbers of vertices and faces."""
    mesh = read_mesh(reference(f"meshes/{name}"))
    assert (mesh.n_vertices, mesh.n_faces) == (n, m)
