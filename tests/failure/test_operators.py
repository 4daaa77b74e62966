"""Operators refuse faces of zero area."""

from collections.abc import Callable

import pytest
import scipy.sparse as sp

from geomhw.errors import MeshError
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.averaging import faces_to_vertices, vertices_to_faces
from geomhw.operators.directional_derivative import directional_derivative, face_derivative
from geomhw.operators.divergence import divergence
from geomhw.operators.gradient import gradient
from geomhw.operators.laplacian import stiffness
from geomhw.operators.mass import consistent_mass, lumped_mass
from support.meshes import some_field

OPERATORS: dict[str, tuple[Callable[[TriangleMesh], sp.sparray], int, str, str]] = {
    "gradient": (gradient, -1, "face3", "vertex"),
    "divergence": (divergence, 1, "vertex", "face3"),
    "stiffness": (stiffness, 0, "vertex", "vertex"),
    "lumped_mass": (lumped_mass, 2, "vertex", "vertex"),
    "consistent_mass": (consistent_mass, 2, "vertex", "vertex"),
    "faces_to_vertices": (faces_to_vertices, 0, "vertex", "face"),
    "vertices_to_faces": (vertices_to_faces, 0, "face", "vertex"),
    "face_derivative": (lambda mesh: face_derivative(mesh, some_field(mesh)), -1, "face", "vertex"),
    "directional_derivative": (lambda mesh: directional_derivative(mesh, some_field(mesh)), -1, "vertex", "vertex"),
}


@pytest.mark.parametrize("operator", ["gradient", "divergence", "stiffness", "face_derivative"])
def test_zero_area_is_refused(operator: str) -> None:
    """Operators with 1/area in them name the face that has none."""
    flat = TriangleMesh([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0]], [[0, 1, 3], [0, 1, 2]])
    with pytest.raises(MeshError, match=r"face 1 .*zero area"):
        OPERATORS[operator][0](flat)
