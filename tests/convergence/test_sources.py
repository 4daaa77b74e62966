"""Convergence of distances from the boundary of a square."""

import numpy as np

from geomhw.mesh.named_points import boundary_points
from geomhw.mesh.primitives import grid
from support.exact import errors
from support.rates import fitted_rate


def test_distance_from_the_boundary() -> None:
    """Distances from the boundary of a square converge to the distance from the nearest side with order h or better."""
    lengths, sizes = [], []
    for cells in (16, 32, 64):
        mesh = grid(cells, cells)
        exact = np.minimum(mesh.vertices, 1 - mesh.vertices)[:, :2].min(axis=1)
        near, far, largest = errors(mesh, boundary_points(mesh), exact)
        assert near < 0.04
        assert far < 0.03
        assert largest < 0.6
        lengths.append(far * mesh.mean_edge_length)
        sizes.append(mesh.mean_edge_length)
    assert fitted_rate(sizes, lengths) > 1.2
