"""Many faces at one edge or vertex: the time of each method grows in proportion to the number of faces."""

from collections.abc import Callable
from time import process_time

import numpy as np
import pytest

from geomhw.flow.passive_scalar import OneRings
from geomhw.geodesic.exact import ExactDistance
from geomhw.mesh.triangle_mesh import TriangleMesh
from support.crowded import CROWDED


def growth(method: Callable[[TriangleMesh], object], shape: str, m: int) -> float:
    """Return how much longer a method takes on 4m faces than on m: 4 if its time is linear, 16 if it is quadratic."""

    def seconds(mesh: TriangleMesh) -> float:
        start = process_time()
        method(mesh)
        return process_time() - start

    few, many = CROWDED[shape](m), CROWDED[shape](4 * m)
    return min(seconds(many) for _ in range(3)) / min(seconds(few) for _ in range(3))


@pytest.mark.parametrize("shape", CROWDED)
def test_exact_distance(shape: str) -> None:
    assert growth(lambda mesh: ExactDistance(mesh).from_vertices([7]), shape, 10_000) < 9


@pytest.mark.parametrize("shape", CROWDED)
def test_one_rings(shape: str) -> None:
    """The largest value at each vertex and its neighbors."""
    mesh = CROWDED[shape](1_000)
    values = np.random.default_rng(0).random(mesh.n_vertices)
    expected = values.copy()
    for one, other in (mesh.edges.T, mesh.edges.T[::-1]):
        np.maximum.at(expected, one, values[other])
    np.testing.assert_array_equal(OneRings(mesh.edges, mesh.n_vertices).largest(values), expected)
    assert (
        growth(lambda mesh: OneRings(mesh.edges, mesh.n_vertices).largest(np.ones(mesh.n_vertices)), shape, 20_000) < 9
    )
