"""Implicit surfaces are refused where the box is wrong or the grid too coarse."""

import numpy as np
import pytest

from geomhw.errors import MeshError
from geomhw.mesh import implicit_surface


def test_implicit_surface_refuses():
    """A surface that leaves the box, an empty one and a grid too coarse raise."""

    def ball(x, y, z):
        return x**2 + y**2 + z**2 - 1

    with pytest.raises(MeshError, match="leaves the box"):
        implicit_surface(ball, [-0.5] * 3, [1.5] * 3, 8)
    with pytest.raises(MeshError, match="nowhere negative"):
        implicit_surface(ball, [2.0] * 3, [3.0] * 3, 8)
    with pytest.raises(MeshError, match="too coarse"):  # two balls a cell apart touch along an edge
        implicit_surface(
            lambda x, y, z: np.minimum(ball(x - 1.03, y - 1.03, z), ball(x + 0.03, y + 0.03, z)) - 0.45,
            [-2.5] * 3,
            [3.5] * 3,
            9,
        )
