"""OBJ files: every dialect gives the same square."""

import numpy as np
import pytest

from geomhw.io import read, read_mesh
from geomhw.mesh.primitives import icosphere
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


@pytest.mark.parametrize("corner", ["{0}", "{0}//{0}", "{0}/{0}/{0}"])
def test_many_faces_with_attributes(tmp_path, corner):
    """A sphere to the bit, whatever stands beside the vertex of a corner."""
    mesh = icosphere(2)
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in mesh.vertices.tolist()]
    lines += ["f " + " ".join(corner.format(i + 1) for i in face) for face in mesh.faces.tolist()]
    found = read(load(tmp_path, "\n".join(lines))).mesh
    assert found.vertices.tobytes() == mesh.vertices.tobytes()
    np.testing.assert_array_equal(found.faces, mesh.faces)
