"""Volumes of the built-in surfaces against closed formulas."""

import numpy as np
import pytest

from geomhw.mesh import genus_two, implicit_surface, primitives
from support.meshes import volume

CLOSED = {
    "icosahedron": (primitives.icosphere(0), 0),
    "icosphere": (primitives.icosphere(3, radius=2.0), 0),
    "torus": (primitives.torus(40, 20), 1),
    "genus two": (genus_two(), 2),
    "contoured ball": (
        implicit_surface(lambda x, y, z: x**2 + y**2 + z**2 - 1, [-1.3] * 3, [1.2] * 3, 20),
        0,
    ),
}
#: Volumes of the smooth surfaces.
VOLUMES = {"icosphere": 8 * 4 / 3 * np.pi, "torus": 2 * np.pi**2 * 0.4**2, "contoured ball": 4 / 3 * np.pi}


@pytest.mark.parametrize("name", VOLUMES)
def test_volume(name):
    """The enclosed volume is within 3 % of that of the smooth surface."""
    assert volume(CLOSED[name][0]) == pytest.approx(VOLUMES[name], rel=0.03)
