"""Convergence of the heat method to distances along great circles."""

import numpy as np
import pytest

from geomhw.geodesic.heat_method import HeatDistance
from geomhw.mesh.primitives import icosphere
from support.exact import great_circle
from support.rates import fitted_rate


def mean_relative_error(level: int, time: str) -> float:
    """Return the mean relative error in %, without the source, over sources with five and with six neighbors."""
    mesh = icosphere(level)
    solver = HeatDistance(mesh, time)
    errors = []
    for source in (0, 11, 12, 20, 42, 100, 300, 641):
        exact = great_circle(mesh, source)
        others = np.arange(mesh.n_vertices) != source
        distance = solver.from_vertices([source])["distance"]
        errors.append(np.mean(np.abs(distance - exact)[others] / exact[others]))
    return 100 * float(np.mean(errors))


@pytest.mark.parametrize(
    ("time", "bounds", "rate"), [("h2", (1.8, 1.2, 0.8, 0.65), 0.5), ("sqrt-h", (1.7, 0.8, 0.4, 0.2), 1.0)]
)
def test_error_on_the_sphere(time: str, bounds: tuple[float, ...], rate: float) -> None:
    """The mean error against great circles is of order h at t = √h, and of order h^0.5 on these meshes at t = h².

    The mean relative errors are bounded in %, on 642, 2,562, 10,242 and 40,962 vertices.
    """
    errors = [mean_relative_error(level, time) for level in (3, 4, 5, 6)]
    assert all(error <= bound for error, bound in zip(errors, bounds, strict=True)), errors
    assert fitted_rate([icosphere(level).mean_edge_length for level in (3, 4, 5, 6)], errors) > rate
