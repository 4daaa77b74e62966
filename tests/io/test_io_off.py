"""OFF files: every dialect gives the same square, and coordinates are read exactly."""

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geomhw.io import read, read_mesh
from geomhw.mesh.primitives import icosphere
from support.number_texts import as_text
from support.off_files import SAME, SQUARE, load
from support.reference import needs_reference, reference


@pytest.mark.parametrize("dialect", SAME)
def test_dialects_give_the_same_mesh(tmp_path, dialect):
    """Each dialect gives the vertices and faces of the square."""
    result = read(load(tmp_path, SAME[dialect]))
    np.testing.assert_array_equal(result.mesh.vertices, SQUARE)
    np.testing.assert_array_equal(result.mesh.faces, [[0, 1, 2], [0, 2, 3]])
    quad = {"polygons": 1} if dialect == "quad" else {}
    assert result.report == {"file": "moo.off", "format": "OFF", **quad}


def test_polygons_become_fans_in_file_order(tmp_path):
    """Polygons become fans in the order of the file."""
    vertices = "".join(f"{i} {i * i} 0\n" for i in range(6))
    result = read(load(tmp_path, f"OFF\n6 3 0\n{vertices}3 0 1 2\n5 5 4 3 2 1 128 0 0\n4 2 3 4 5\n"))
    expected = [[0, 1, 2], [5, 4, 3], [5, 3, 2], [5, 2, 1], [2, 3, 4], [2, 4, 5]]
    assert result.mesh.faces.tolist() == expected
    assert result.report["polygons"] == 2


@settings(max_examples=30, deadline=None)
@given(st.lists(st.tuples(*[st.floats(allow_nan=False, allow_infinity=False)] * 3), min_size=3, max_size=20))
def test_coordinates_come_back_to_the_bit(tmp_path_factory, points):
    """Coordinates are read to the last bit."""
    rows = "".join(f"{x!r} {y!r} {z!r}\n" for x, y, z in points)
    path = load(tmp_path_factory.mktemp("off"), f"OFF\n{len(points)} 1 0\n{rows}3 0 1 2\n")
    assert read_mesh(path).vertices.tobytes() == np.array(points).tobytes()


@needs_reference
@pytest.mark.parametrize(
    ("name", "n", "m"), [("closed/moomoo.off", 1045, 2086), ("hostile/camelhead.off", 11381, 22704)]
)
def test_reference_meshes(name, n, m):
    """Real files give the known numbers of vertices and faces."""
    mesh = read_mesh(reference(f"meshes/{name}"))
    assert (mesh.n_vertices, mesh.n_faces) == (n, m)


SPHERE = as_text(icosphere(3), "off")
ENDS = {"newline": "\n", "blank": " \n", "blanks": "     \n", "carriage return": "\r\n", "both": " \r\n"}


@pytest.mark.parametrize("end", ENDS)
@pytest.mark.parametrize("head", ["OFF\n", "COFF # of four\n# and more\n\n", "OFF", "OFF "])
def test_files_as_programs_write_them(tmp_path, head, end):
    """Line ends of any program, comments in the header, no newline at the end, extra numbers in all lines alike."""
    mesh = icosphere(3)
    for text in (SPHERE, SPHERE + "\n\n", re.sub("(?m)^(3 .*)$", r"\1 255 0 0", SPHERE)):
        found = read(load(tmp_path, text.replace("OFF\n", head).replace("\n", ENDS[end]))).mesh
        assert found.vertices.tobytes() == mesh.vertices.tobytes()
        np.testing.assert_array_equal(found.faces, mesh.faces)
