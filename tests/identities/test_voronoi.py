"""Voronoi cells and samples: equal to their definitions by exact distances from each point."""

import numpy as np
import pytest

from geomhw.arrays import Floats
from geomhw.errors import ArgumentError, MeshError
from geomhw.geodesic import ExactDistance, farthest_points, poisson_disks, voronoi_cells
from geomhw.mesh import TriangleMesh, concatenate, face_point, grid, icosphere, insert_points, torus, vertex_points
from geomhw.mesh.surface_points import SurfacePoints
from support.meshes import crumpled, two_spheres

MESHES = {"sphere": icosphere(2), "crumpled": crumpled(torus(16, 13)), "two": two_spheres(), "grid": grid(8, 8)}


def rows(mesh: TriangleMesh, points: SurfacePoints) -> Floats:
    """Distances of all vertices from each point."""
    return ExactDistance(mesh).rows(points.split())


def some_points(mesh: TriangleMesh, k: int) -> SurfacePoints:
    """Vertices and points within faces, k of each."""
    random = np.random.default_rng(k)
    vertices = vertex_points(mesh, random.permutation(np.unique(mesh.faces))[:k])
    faces = random.integers(mesh.n_faces, size=k)
    return concatenate([vertices, *(face_point(mesh, int(f), random.dirichlet([1, 1, 1])) for f in faces)])


@pytest.mark.parametrize("k", [1, 4, 20])
@pytest.mark.parametrize("name", MESHES)
def test_labels(name: str, k: int) -> None:
    """Labels are the nearest sites, of several the lowest; the areas of cells sum to that of the surface."""
    mesh = MESHES[name]
    sites = some_points(mesh, k)
    cells, exact = voronoi_cells(mesh, sites), rows(mesh, sites)
    least = exact.min(axis=0)
    reached = np.isfinite(least)
    np.testing.assert_array_equal(cells.label, np.where(reached, np.argmax(exact <= least * (1 + 1e-10), axis=0), -1))
    np.testing.assert_allclose(cells.distance[reached], least[reached], rtol=1e-12)
    assert cells.areas.sum() == pytest.approx(mesh.face_areas[reached[mesh.faces].all(axis=1)].sum(), rel=1e-12)
    assert (cells.areas >= -1e-14).all()


@pytest.mark.parametrize("name", MESHES)
def test_dual_edges(name: str) -> None:
    """Cells are neighbors if an edge joins them, and in no other case; borders lie in their faces."""
    mesh = MESHES[name]
    cells = voronoi_cells(mesh, some_points(mesh, 3))
    ends = np.sort(cells.label[mesh.edges], axis=1)
    joined = np.unique(ends[ends[:, 0] != ends[:, 1]], axis=0)
    assert set(map(tuple, cells.dual_edges.tolist())) <= set(map(tuple, joined.tolist()))
    assert len(cells.dual_edges) >= len(joined) - 3  # cells may meet in one point
    assert cells.border_lengths.sum() == pytest.approx(
        np.linalg.norm(np.diff(cells.borders, axis=1)[:, 0], axis=1).sum()
    )


def test_square() -> None:
    """The corners of a square, where vertices between are equally near: quarters; the lower site has them."""
    mesh = grid(8, 8)
    cells = voronoi_cells(mesh, vertex_points(mesh, [0, 8, 72, 80]))
    np.testing.assert_allclose(cells.areas, 0.25, atol=1e-12)
    assert cells.label.reshape(9, 9)[4].tolist() == [0] * 5 + [1] * 4
    assert cells.dual_edges.tolist() == [[0, 1], [0, 2], [1, 3], [2, 3]]
    np.testing.assert_allclose(cells.border_lengths, 0.5, atol=1e-12)


def test_area_in_a_plane() -> None:
    """Areas and borders of cells approach those in the plane, of second order in the mesh size."""
    errors = []
    for n in (8, 16, 32):
        mesh = grid(n, n)
        places = [[0.25, 0.5, 0], [0.75, 0.625, 0]]
        sites = vertex_points(mesh, [int(np.abs(mesh.vertices - place).sum(axis=1).argmin()) for place in places])
        # The bisector x + y/4 = 0.640625 cuts the square at y = 0 and y = 1.
        cells = voronoi_cells(mesh, sites)
        errors.append(abs(cells.areas[0] - (0.640625 - 0.125)))
        assert np.abs(cells.borders @ [1, 0.25, 0] - 0.640625).max() < 0.5 / n**2
    assert errors[-1] < 1e-4
    assert errors[-1] < errors[0] / 8


def test_same_sites() -> None:
    """A site at the place of another one has an empty cell."""
    mesh = icosphere(1)
    cells = voronoi_cells(mesh, vertex_points(mesh, [3, 7, 3]))
    assert set(cells.label.tolist()) == {0, 1}
    assert cells.areas[2] == 0


@pytest.mark.parametrize("name", MESHES)
def test_farthest_points(name: str) -> None:
    """Each point is the farthest vertex from those before, of equally far ones the lowest."""
    mesh = MESHES[name]
    samples = farthest_points(mesh, 25, first=3)
    used = np.unique(mesh.faces)
    exact = rows(mesh, vertex_points(mesh, used))[:, used]
    distance, k, expected, gaps = np.full(len(used), np.inf), 3, list[int](), list[float]()
    for _ in range(25):
        expected.append(used[k])
        gaps.append(float(distance[k]))
        distance = np.minimum(distance, exact[k])
        k = int(np.argmax(distance >= distance.max() * (1 - 1e-10)))
    assert samples.points.vertices.tolist() == expected
    np.testing.assert_allclose(samples.gaps, gaps, rtol=1e-12)
    assert samples.radius == pytest.approx(distance.max(), rel=1e-12)


def test_spacing() -> None:
    """With a spacing, points are at least so far apart and all vertices are nearer to one."""
    mesh = MESHES["crumpled"]
    samples = farthest_points(mesh, spacing=0.5)
    assert samples.spacing >= 0.5 > samples.radius
    assert len(farthest_points(mesh, 7, spacing=0.5).points) == 7


@pytest.mark.parametrize("name", MESHES)
def test_poisson_disks(name: str) -> None:
    """Random points within faces: exact distances of at least the spacing, no room at a vertex, the same each time."""
    mesh = MESHES[name]
    samples = poisson_disks(mesh, 0.3, seed=5)
    inserted = insert_points(mesh, samples.points)
    exact = rows(inserted.mesh, vertex_points(inserted.mesh, inserted.vertices))
    apart = exact[:, inserted.vertices] + np.where(np.eye(len(exact)), np.inf, 0)
    assert apart.min() == pytest.approx(samples.spacing, rel=1e-12)
    assert samples.spacing >= 0.3 > samples.radius
    assert exact[:, np.unique(mesh.faces)].min(axis=0).max() == pytest.approx(samples.radius, rel=1e-12)
    assert 0.5 < len(samples.points) * 0.3**2 / mesh.face_areas.sum() < 1.2
    np.testing.assert_array_equal(samples.points.weights, poisson_disks(mesh, 0.3, seed=5).points.weights)
    assert not np.array_equal(samples.points.faces[:9], poisson_disks(mesh, 0.3, seed=6).points.faces[:9])


def test_poisson_count() -> None:
    """With a count, the spacing is as large as fits that number."""
    mesh = icosphere(2)
    samples = poisson_disks(mesh, count=60)
    assert len(samples.points) == 60
    assert 0.5 < 60 * samples.spacing**2 / mesh.face_areas.sum() < 1


def test_refusals() -> None:
    """Counts and spacings that have no samples."""
    mesh = icosphere(1)
    for make in (farthest_points, poisson_disks):
        with pytest.raises(ArgumentError, match="count"):
            make(mesh)
        with pytest.raises(ArgumentError, match="count"):
            make(mesh, spacing=-1.0)
    with pytest.raises(ArgumentError, match="42 distinct"):
        farthest_points(mesh, 43)
    with pytest.raises(ArgumentError, match="1000000 points"):
        poisson_disks(mesh, 1e-9)
    flat = TriangleMesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]])
    with pytest.raises(MeshError, match="zero area"):
        poisson_disks(flat, 0.1)
