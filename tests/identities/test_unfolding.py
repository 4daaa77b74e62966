"""Distances by unfolding: bounds by chord and edge path, independence of order, scaling."""

import numpy as np
import pytest

from geomhw.geodesic.edge_paths import edge_path_distance
from geomhw.geodesic.heat_method import HeatDistance
from geomhw.geodesic.unfolding import Unfolding
from geomhw.mesh.curvature import angle_defects
from geomhw.mesh.primitives import icosphere
from geomhw.mesh.triangle_mesh import TriangleMesh
from support.exact import unfolded
from support.meshes import ZOO, crumpled, zoo_mesh


@pytest.mark.parametrize("name", sorted(ZOO))
def test_between_chord_and_path(name: str) -> None:
    """Distances lie between the straight line and the edge path, and are inf where unreachable."""
    mesh = zoo_mesh(name)
    found, path = unfolded(mesh, [0]), edge_path_distance(mesh, np.array([0]))
    assert np.array_equal(np.isinf(found), np.isinf(path))
    there = np.isfinite(path)
    assert (found[there] <= path[there] * (1 + 1e-12)).all()
    chord = np.linalg.norm(mesh.vertices - mesh.vertices[0], axis=1)
    assert (found[there] >= chord[there] * (1 - 1e-12)).all()
    assert found[0] == 0
    assert (found[1:] > 0).all()


@pytest.mark.parametrize("name", ["sphere", "torus", "genus_two", "annulus"])
def test_order_does_not_matter(name: str) -> None:
    """The order of the vertices changes distances by less than 0.5 %."""
    mesh = zoo_mesh(name)
    start = np.full(mesh.n_vertices, np.inf)
    start[3] = 0
    unfold = Unfolding(mesh, angle_defects(mesh))
    expected = unfold(start, edge_path_distance(mesh, np.array([3])))
    for guess in (np.ones(mesh.n_vertices), np.asarray(HeatDistance(mesh).from_vertices([3])["distance"])):
        np.testing.assert_allclose(unfold(start, guess), expected, rtol=5e-3)


def test_scale() -> None:
    """Distances scale with the mesh, bit for bit for powers of two."""
    mesh = crumpled(icosphere(2))
    large = TriangleMesh(mesh.vertices * 1024, mesh.faces)
    np.testing.assert_array_equal(unfolded(large, [5]), 1024 * unfolded(mesh, [5]))
