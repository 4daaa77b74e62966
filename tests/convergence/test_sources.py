"""Convergence of distances from the boundary of a square."""

import numpy as np

from geomhw.mesh.primitives import grid
from geomhw.mesh.surface_points import boundary_points
from support.exact import errors


def test_distance_from_the_boundary() -> None:
    """In a square, the distance from the nearest side: right beside it, and better on a finer mesh."""
    relative = []
    for cells in (16, 32, 64):
        mesh = grid(cells, cells)
        exact = np.minimum(mesh.vertices, 1 - mesh.vertices)[:, :2].min(axis=1)
        near, far, largest = errors(mesh, boundary_points(mesh), exact)
        assert near < 0.04
        assert far < 0.03
        assert largest < 0.6
        relative.append(far * mesh.mean_edge_length)
    rates = np.log2(np.array(relative[:-1]) / relative[1:])
    assert (rates > 0.9).all(), rates
