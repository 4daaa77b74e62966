"""Many faces at one edge or vertex: the time of each method grows in proportion to the number of faces."""

from collections.abc import Callable
from time import process_time

import pytest

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
