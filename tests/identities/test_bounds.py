"""What plain distances are clamped to, and how many vertices that concerns."""

import numpy as np
import pytest

from geomhw.geodesic import HeatDistance, edge_path_distance
from geomhw.mesh.named_points import vertex_points
from support.meshes import sheared, zoo_mesh


@pytest.mark.parametrize("name", ["sphere", "crumpled_torus", "grid", "strip", "two_spheres"])
def test_without_the_bound_distances_are_those_of_algorithm_1(name: str) -> None:
    """S φ = -Div X holds for unbounded distances; clamping them gives the bounded ones, as counted in the report."""
    from geomhw.operators import stiffness

    mesh = zoo_mesh(name)
    free, bounded = (HeatDistance(mesh, "h2", bound=bound).from_vertices([3]) for bound in (False, True))
    phi, found = np.asarray(free["distance"]), np.asarray(bounded["distance"])
    known = np.isfinite(phi)
    div, S = np.asarray(free["divergence"]), stiffness(mesh)[known][:, known]
    left = S @ phi[known] + div[known]
    assert np.abs(left).max() <= 1e-10 * np.abs(div).max()
    paths = edge_path_distance(mesh, np.array([3]))
    positive = known & (phi > 0)
    np.testing.assert_array_equal(found[positive], np.minimum(phi, paths)[positive])
    longer = positive & (phi > paths * (1 + 1e-12))
    assert free.report.get("beyond_edge_paths", {"vertices": 0})["vertices"] == np.count_nonzero(longer)
    assert bounded.report.get("beyond_edge_paths") == free.report.get("beyond_edge_paths")


def test_rows_without_the_bound() -> None:
    """Blocks of sources leave the bound out, too."""
    mesh = zoo_mesh("crumpled_torus")
    solver = HeatDistance(mesh, "h2", bound=False, queries=100)
    queries = [vertex_points(mesh, [v]) for v in range(9)]
    alone = np.stack([solver.from_sources(query)["distance"] for query in queries])
    np.testing.assert_allclose(solver.rows(queries), alone, rtol=1e-9, atol=1e-12)


def test_slivers_are_counted() -> None:
    """Heat below zero on slivers, and distances beyond edge paths after a long time: the report counts the vertices."""
    report = HeatDistance(sheared(), "h2").from_vertices([0]).report
    assert report["non_positive_heat"] > 0
    longer = HeatDistance(zoo_mesh("genus_two"), "10*h2").from_vertices([0]).report["beyond_edge_paths"]
    assert longer["vertices"] > 1000
    assert 0.07 < longer["most"] < 0.09
    assert "non_positive_heat" not in HeatDistance(zoo_mesh("sphere"), "h2").from_vertices([0]).report
