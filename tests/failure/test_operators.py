"""Operators refuse faces of zero area."""

from collections.abc import Callable

import numpy as np
import pytest

from geomhw.errors import MeshError
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.directional_derivative import face_derivative
from geomhw.operators.divergence import divergence
from geomhw.operators.gradient import gradient
from geomhw.operators.laplacian import stiffness


@pytest.mark.parametrize(
    "operator",
    [gradient, divergence, stiffness, lambda mesh: face_derivative(mesh, np.ones((2, 3)))],
    ids=["gradient", "divergence", "stiffness", "face_derivative"],
)
def test_zero_area_is_refused(operator: Callable[[TriangleMesh], object]) -> None:
    """Operators that divide by areas raise at a face of zero area, with its index."""
    flat = TriangleMesh([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0]], [[0, 1, 3], [0, 1, 2]])
    with pytest.raises(MeshError, match=r"face 1 .*zero area"):
        operator(flat)
