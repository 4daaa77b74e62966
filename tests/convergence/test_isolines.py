"""Convergence of length and enclosed area of geodesic circles, isolines of the exact distance from their center."""

import numpy as np
import pytest

from geomhw.curves import isolines
from geomhw.geodesic import ExactDistance
from geomhw.mesh import TriangleMesh, grid, icosphere
from support.rates import fitted_rate


def cone(rings: int) -> TriangleMesh:
    """Return a cone of side length 2 whose surface has an angle of π at the apex: rings of 4k vertices."""
    sectors = 4 * rings
    turn = 2 * np.pi * np.arange(sectors) / sectors
    way = np.stack([np.cos(turn), np.sin(turn), np.full(sectors, -np.sqrt(3))], axis=1)
    points = np.concatenate([np.zeros((1, 3)), *(k / rings * way for k in range(1, rings + 1))])
    a, b = np.arange(sectors), (np.arange(sectors) + 1) % sectors
    faces = [np.stack([0 * a, 1 + a, 1 + b], axis=1)]
    for k in range(rings - 1):
        inner, outer = 1 + k * sectors, 1 + (k + 1) * sectors
        faces += [
            np.stack([inner + a, outer + a, outer + b], axis=1),
            np.stack([inner + a, outer + b, inner + b], axis=1),
        ]
    return TriangleMesh(points, np.concatenate(faces))


#: Meshes of a family, the source, the radius of the circle, its length, and its area.
FAMILIES = {
    "sphere": ([icosphere(k) for k in (2, 3, 4)], 0, 1.2, 2 * np.pi * np.sin(1.2), 2 * np.pi * (1 - np.cos(1.2))),
    "plane": ([grid(k, k) for k in (8, 16, 32)], None, 0.4, 0.8 * np.pi, 0.16 * np.pi),
    "cone": ([cone(k) for k in (5, 10, 20)], 0, 1.3, 1.3 * np.pi, 1.3**2 * np.pi / 2),
}


@pytest.mark.parametrize("name", FAMILIES)
def test_geodesic_circles(name: str) -> None:
    """Length and enclosed area converge at second order."""
    meshes, source, radius, length, area = FAMILIES[name]
    errors = []
    for mesh in meshes:
        center = mesh.n_vertices // 2 if source is None else source
        found = isolines(mesh, ExactDistance(mesh).from_vertices([center])["distance"], [radius])
        assert found.closed.tolist() == [True]
        errors.append([abs(found.lengths[0] - length), abs(found.areas[0, 0] - area)])
    widths = [mesh.mean_edge_length for mesh in meshes]
    rates = [fitted_rate(widths, list(column)) for column in zip(*errors, strict=True)]
    assert min(rates) > 1.8, rates
