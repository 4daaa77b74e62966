"""Convergence of the heat method to distances along great circles."""

import numpy as np
import pytest

from geomhw.geodesic.heat_method import HeatDistance
from geomhw.mesh.primitives import icosphere
from support.exact import great_circle


def mean_relative_error(level: int, time: str) -> float:
    """Over all vertices but the source, in %, averaged over sources of five and of six neighbors."""
    mesh = icosphere(level)
    solver = HeatDistance(mesh, time)
    errors = []
    for source in (0, 11, 12, 20, 42, 100, 300, 641):
        exact = great_circle(mesh, source)
        others = np.arange(mesh.n_vertices) != source
        distance = solver.from_vertices([source])["distance"]
        errors.append(np.mean(np.abs(distance - exact)[others] / exact[others]))
    return 100 * float(np.mean(errors))


@pytest.mark.parametrize(("time", "bounds"), [("h2", (1.8, 1.2, 0.8, 0.65)), ("sqrt-h", (1.7, 0.8, 0.4, 0.2))])
def test_error_on_the_sphere(time: str, bounds: tuple[float, ...]) -> None:
    """Mean relative error against the great circle, in %, on 642, 2,562, 10,242 and 40,962 vertices."""
    errors = [mean_relative_error(level, time) for level in (3, 4, 5, 6)]
    assert all(error <= bound for error, bound in zip(errors, bounds, strict=True)), errors
