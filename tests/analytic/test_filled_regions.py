"""Exact distances from filled regions, whose edges and faces are sources too: plane, cylinder, cube, a sphere's
symmetries.
"""

import numpy as np
import pytest
from analytic.test_exact_distance import box

from geomhw.geodesic.exact import ExactDistance
from geomhw.geodesic.heat_method import HeatDistance
from geomhw.mesh.named_points import region_points, vertex_points
from geomhw.mesh.primitives import cylinder_band, grid, icosphere
from geomhw.mesh.surface_points import concatenate
from geomhw.mesh.triangle_mesh import TriangleMesh
from support.hostile import flipped, renumbered


def filled(mesh: TriangleMesh, vertices: np.ndarray) -> np.ndarray:
    """Return the exact distances from a filled region."""
    return np.asarray(ExactDistance(mesh).from_sources(region_points(mesh, vertices))["distance"])


@pytest.mark.parametrize("cells", [4, 20])
def test_square_in_plane(cells: int) -> None:
    """Straight lines leave the sides of a square at right angles, over irregular faces."""
    mesh, rng = grid(cells, cells), np.random.default_rng(cells)
    points, (x, y, _) = mesh.vertices.copy(), mesh.vertices.T
    inside = (x >= 0.25) & (x <= 0.5) & (y >= 0.25) & (y <= 0.5)
    free = ~inside & (x > 0) & (x < 1) & (y > 0) & (y < 1)
    points[free, :2] += rng.uniform(-0.3, 0.3, (free.sum(), 2)) / cells
    mesh, (x, y, _) = TriangleMesh(points, mesh.faces), points.T
    exact = np.hypot(np.maximum(np.maximum(0.25 - x, x - 0.5), 0), np.maximum(np.maximum(0.25 - y, y - 0.5), 0))
    np.testing.assert_allclose(filled(mesh, np.flatnonzero(inside)), exact, atol=1e-14)


def test_ring_of_cylinder() -> None:
    """From a ring of vertices and the bands between, the distance is the difference of heights."""
    mesh = cylinder_band(23, 12)
    heights = mesh.vertices[:, 2] - mesh.vertices[:, 2].min()
    levels = np.unique(heights.round(9))
    for low, high in ((0, 0), (5, 5), (3, 6)):
        inside = (heights > levels[low] - 1e-6) & (heights < levels[high] + 1e-6)
        exact = np.maximum(np.maximum(levels[low] - heights, heights - levels[high]), 0)
        np.testing.assert_allclose(filled(mesh, np.flatnonzero(inside)), exact, atol=1e-8)
    turned = TriangleMesh(mesh.vertices * [1, 1, 3], mesh.faces)
    inside = np.flatnonzero(heights < 1e-9)
    np.testing.assert_allclose(filled(turned, inside), 3 * heights, atol=1e-13)


@pytest.mark.parametrize("cells", [1, 4])
def test_edge_of_cube(cells: int) -> None:
    """From an edge of a cube: over the two sides there, or round a corner of the two sides at its ends."""
    mesh = box(cells)
    x, y, z = mesh.vertices.T
    found = filled(mesh, np.flatnonzero((x == 0) & (y == 0)))
    beside, ends = (x == 0) | (y == 0), (z == 0) | (z == 1)
    np.testing.assert_allclose(found[beside], (x + y)[beside], atol=1e-14)
    np.testing.assert_allclose(found[ends], np.hypot(x, y)[ends], atol=1e-14)
    far = (x == 1) & (y == 1)
    height = np.minimum(z, 1 - z)
    np.testing.assert_allclose(found[far], np.minimum(2, np.hypot(1, 1 + height))[far], atol=1e-14)


def test_symmetry() -> None:
    """Caps and bands of a sphere have its mirror symmetries; numbering and orientation change nothing."""
    mesh = icosphere(3)
    order = np.lexsort(mesh.vertices.round(9).T)
    for inside in (abs(mesh.vertices[:, 2]) < 0.2, mesh.vertices[:, 2] > 0.7):
        found = filled(mesh, np.flatnonzero(inside))
        for k in (0, 1):
            mirrored = mesh.vertices * np.where(np.arange(3) == k, -1.0, 1.0)
            np.testing.assert_allclose(found[order], found[np.lexsort(mirrored.round(9).T)], atol=1e-14)
        arrays = np.asarray(mesh.vertices), np.asarray(mesh.faces)
        np.testing.assert_allclose(filled(TriangleMesh(*flipped(arrays)), np.flatnonzero(inside)), found, atol=1e-14)
        other, places, _ = renumbered(arrays)
        np.testing.assert_allclose(
            filled(TriangleMesh(*other), np.flatnonzero(inside[places])), found[places], atol=1e-14
        )


def test_finer_mesh_of_same_surface() -> None:
    """Edges of a region cut at their midpoints are the same region; distances are below those from its vertices."""
    rng, mesh = np.random.default_rng(4), icosphere(2)
    mesh = TriangleMesh(mesh.vertices * rng.uniform(0.7, 1.3, (mesh.n_vertices, 1)), mesh.faces)
    n, ends = mesh.n_vertices, mesh.vertices[mesh.edges]
    sides, corners = mesh.edge_table.of_faces + n, mesh.faces
    cut = [np.stack([corners[:, k], sides[:, k - 1], sides[:, k - 2]], axis=1) for k in range(3)]
    finer = TriangleMesh(np.concatenate([mesh.vertices, ends.mean(axis=1)]), np.concatenate([*cut, sides]))
    inside = mesh.vertices[:, 0] > 0.3
    middles = n + np.flatnonzero(inside[mesh.edges].all(axis=1))
    found = filled(mesh, np.flatnonzero(inside))
    np.testing.assert_allclose(filled(finer, np.append(np.flatnonzero(inside), middles))[:n], found, atol=1e-13)
    from_vertices = ExactDistance(mesh).from_vertices(np.flatnonzero(inside))["distance"]
    assert (found <= from_vertices + 1e-14).all()
    assert (found < from_vertices - 1e-3).any()


def test_region_beside_points() -> None:
    """A region and other sources: the shorter of the distances. Refined distances are the exact ones."""
    mesh = grid(8, 8)
    region, other = np.flatnonzero(mesh.vertices[:, 0] == 0), 80
    sources = concatenate([vertex_points(mesh, [other, 0]), region_points(mesh, region)])
    found = ExactDistance(mesh).from_sources(sources)["distance"]
    alone = ExactDistance(mesh).from_vertices([other])["distance"]
    np.testing.assert_allclose(found, np.minimum(mesh.vertices[:, 0], alone), atol=1e-14)
    refined = HeatDistance(mesh, refine=True).from_sources(sources)["distance"]
    np.testing.assert_allclose(refined, found, atol=1e-14)


def test_limit_from_region() -> None:
    """A limit cuts off the distances beyond it."""
    mesh = icosphere(3)
    region = np.flatnonzero(mesh.vertices[:, 2] > 0.8)
    exact = filled(mesh, region)
    found = ExactDistance(mesh).from_sources(region_points(mesh, region), limit=0.5)["distance"]
    np.testing.assert_array_equal(found, np.where(exact <= 0.5, exact, np.inf))
