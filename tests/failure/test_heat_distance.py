"""The heat method refuses wrong times, sources, boundary conditions and faces of zero area."""

import numpy as np
import pytest

from geomhw.errors import FieldError, MeshError
from geomhw.geodesic.auto_time import time_step
from geomhw.geodesic.heat_method import HeatDistance, heat_distance
from geomhw.mesh.triangle_mesh import TriangleMesh
from support.meshes import grid_of, zoo_mesh


@pytest.mark.parametrize(
    "bad", ["0", "-1", "nan", "inf", "1e999*h2", "9" * 5000, "soon", "2*h", "h2*2", "-1*h2", "", "x*h2"]
)
def test_time_refusals(bad: str) -> None:
    """Times that are not positive raise."""
    with pytest.raises(FieldError, match=r"time step"):
        time_step(bad, grid_of(1.0))


@pytest.mark.parametrize(
    ("sources", "words"),
    [
        ([], "no source"),
        ([325], r"source 325 is not a vertex: .*0 to 324"),
        ([-1], "source -1"),
        ([1.5], "whole number"),
        ([162], "belongs to no face"),
    ],
)
def test_source_refusals(sources: list[int], words: str) -> None:
    """Sources that are not vertices of the surface raise."""
    with pytest.raises(FieldError, match=words):
        HeatDistance(zoo_mesh("two_spheres")).from_vertices(sources)


def test_zero_area_is_refused() -> None:
    """A face of zero area raises, with its index and the remedy; with `robust` it is accepted."""
    flat = TriangleMesh([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0]], [[0, 1, 3], [0, 1, 2]])
    with pytest.raises(MeshError, match=r"face 1 .*zero area; collapse .* robust=True"):
        HeatDistance(flat)
    assert np.isfinite(heat_distance(flat, [0], robust=True)).all()


def test_boundary_refusals() -> None:
    """Sources on a cold boundary and unknown conditions raise; closed meshes ignore the condition."""
    mesh = zoo_mesh("grid")
    with pytest.raises(FieldError, match="kept cold"):
        HeatDistance(mesh, boundary="dirichlet").from_vertices([0])
    with pytest.raises(FieldError, match="neumann, dirichlet, average"):
        HeatDistance(mesh, boundary="robin")  # type: ignore[arg-type]
    sphere = zoo_mesh("sphere")
    assert HeatDistance(sphere, boundary="average").from_vertices([0]).report["boundary"] == "neumann"
