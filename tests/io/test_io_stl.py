"""STL files: corners are merged in the order of the file."""

import numpy as np
import pytest
import pyvista

from geomhw.io import read, read_mesh
from support.stl_files import POINTS, facets


@pytest.mark.parametrize("binary", [True, False])
def test_stl_corners_are_welded_in_file_order(tmp_path, binary):
    """Equal corners are merged, in the order of first appearance."""
    faces = np.array([[3, 1, 0], [3, 2, 1], [0, 1, 2]])
    path = tmp_path / "moo.stl"
    pyvista.PolyData(POINTS, np.insert(faces, 0, 3, axis=1)).save(path, binary=binary)
    result = read(path)
    assert result.mesh.faces.tolist() == [[0, 1, 2], [0, 3, 1], [2, 1, 3]]
    np.testing.assert_array_equal(result.mesh.vertices, POINTS[[3, 1, 0, 2]])
    single = {"single_precision": ["positions"]} if binary else {}
    assert result.report == {"file": "moo.stl", "format": "STL", **single}


def test_stl_zeros_of_both_signs_are_one_corner(tmp_path):
    """0 and -0 are the same corner."""
    path = tmp_path / "moo.stl"
    path.write_bytes(facets([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[-0.0, 0, 0], [0, 1, 0], [-1, -0.0, 0]]))
    assert read_mesh(path).faces.tolist() == [[0, 1, 2], [0, 2, 3]]
