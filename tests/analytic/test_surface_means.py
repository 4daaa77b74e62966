"""Karcher mean, geometric median and centroidal Voronoi cells where symmetry or a plane gives the answer."""

from collections.abc import Callable

import numpy as np
import pytest
from attack.families import random_mesh

from geomhw.errors import FieldError
from geomhw.geodesic import ExactDistance, farthest_points, voronoi_cells
from geomhw.mesh import TriangleMesh, concatenate, cylinder_band, grid, icosphere, nearest_point, torus, vertex_points
from geomhw.mesh.surface_points import SurfacePoints
from geomhw.transport import SurfaceMean, geometric_median, karcher_mean, relaxed_sites
from support.meshes import two_spheres

Mean = Callable[[TriangleMesh, SurfacePoints], SurfaceMean]


def points(mesh: TriangleMesh, places: list) -> SurfacePoints:
    """Points at places of the surface."""
    return concatenate([nearest_point(mesh, place) for place in places])


def orbit(place: np.ndarray, axes: list) -> list:
    """Mirror images of a place."""
    return [place * signs for signs in axes]


@pytest.mark.parametrize("mean", [karcher_mean, geometric_median])
@pytest.mark.parametrize("level", [2, 3])
def test_sphere(mean: Mean, level: int) -> None:
    """Mirror images in two planes: the pole between."""
    place = np.array([0.35, 0.2, 0.9])
    images = orbit(place, [(1, 1, 1), (-1, 1, 1), (1, -1, 1), (-1, -1, 1)])
    found = mean(icosphere(level), points(icosphere(level), images))
    np.testing.assert_allclose(found.point.positions(icosphere(level))[0], [0, 0, 1], atol=1e-6)
    assert found.others is None


def test_torus() -> None:
    """Mirror images in two planes: on the outer or the inner equator, whichever is nearer."""
    mesh = torus(24, 12)
    a, b = 0.4, 0.7
    for outer in (1, -1):
        radius = 1 + 0.4 * np.cos(b) * outer
        place = np.array([radius * np.cos(a), radius * np.sin(a), 0.4 * np.sin(b)])
        images = orbit(place, [(1, 1, 1), (1, -1, 1), (1, 1, -1), (1, -1, -1)])
        found = karcher_mean(mesh, points(mesh, images))
        np.testing.assert_allclose(found.point.positions(mesh)[0], [1 + 0.4 * outer, 0, 0], atol=1e-6)


def test_cylinder() -> None:
    """On a flat surface the mean is that of the unrolled points, also within faces."""
    mesh = cylinder_band(24, 8)
    corner = mesh.vertices[:24] * [1, 1, 0]

    def at(u: float, height: float) -> np.ndarray:
        """The place at a height and a coordinate along the polygon, whose sides have length 1."""
        i, share = int(u), u % 1
        return (1 - share) * corner[i] + share * corner[i + 1] + [0, 0, height - 0.5]

    given = np.array([(1.2, 0.2), (3.7, 0.3), (4.4, 0.75), (2.9, 0.9)])
    found = karcher_mean(mesh, points(mesh, [at(*place) for place in given]))
    np.testing.assert_allclose(found.point.positions(mesh)[0], at(*given.mean(axis=0)), atol=1e-9)


def test_plane() -> None:
    """In a plane, the mean is the centroid, and the median of the corners of a quadrilateral where diagonals cross."""
    mesh = grid(7, 7)
    places = np.array([[0.1, 0.2, 0], [0.8, 0.3, 0], [0.35, 0.9, 0]])
    found = karcher_mean(mesh, points(mesh, list(places)))
    np.testing.assert_allclose(found.point.positions(mesh)[0], places.mean(axis=0), atol=1e-12)
    assert found.value == pytest.approx(((places - places.mean(axis=0)) ** 2).sum(), rel=1e-12)
    quadrilateral = [[0.1, 0.1, 0], [0.7, 0.3, 0], [0.9, 0.9, 0], [0.3, 0.7, 0]]
    found = geometric_median(mesh, points(mesh, quadrilateral))
    np.testing.assert_allclose(found.point.positions(mesh)[0], [0.5, 0.5, 0], atol=1e-6)


def test_median_at_a_point() -> None:
    """The median is a given point if it is in the triangle of the others with angles of 120 degrees or more."""
    mesh = grid(7, 7)
    places = [[0.1, 0.1, 0], [0.9, 0.9, 0], [0.41, 0.47, 0]]
    found = geometric_median(mesh, points(mesh, places))
    np.testing.assert_allclose(found.point.positions(mesh)[0], places[2], atol=1e-12)
    assert found.last_step == 0


def test_several_minima() -> None:
    """Opposite points of a torus have several means, and of a vertex of a sphere it is the vertex."""
    mesh = torus(24, 12)
    found = karcher_mean(mesh, points(mesh, [[1.4, 0, 0], [-1.4, 0, 0]]))
    assert found.others is not None
    only = karcher_mean(icosphere(2), vertex_points(icosphere(2), [5]))
    assert (only.point.report(), only.value, only.others) == ([5], 0.0, None)


def test_components() -> None:
    """Points on several components have no mean."""
    mesh = two_spheres()
    with pytest.raises(FieldError, match="no path connects point 0 with point 1"):
        karcher_mean(mesh, vertex_points(mesh, [0, mesh.n_vertices - 1]))


def test_relaxation() -> None:
    """Relaxed cells of 12 sites on a sphere have nearly equal areas; on a square one site is in the middle."""
    mesh = icosphere(3)
    sites = farthest_points(mesh, 12).points
    spread = [np.ptp(voronoi_cells(mesh, relaxed_sites(mesh, sites, k)).areas) for k in (0, 4)]
    assert spread[1] < spread[0] / 2
    square = grid(6, 6)
    middle = relaxed_sites(square, vertex_points(square, [2]), 1).positions(square)
    np.testing.assert_allclose(middle, [[0.5, 0.5, 0]], atol=1e-12)


@pytest.mark.parametrize("seed", [602, 604])
def test_two_points_on_a_spiky_sphere(seed: int) -> None:
    """The mean of two points is the middle of their shortest path, also among vertices with angles far from 2π."""
    rng = np.random.default_rng(seed)
    ball = icosphere(2)
    mesh = TriangleMesh(ball.vertices * rng.uniform(1, 2.5, (ball.n_vertices, 1)), ball.faces)
    solver = ExactDistance(mesh)
    for a, b in rng.choice(mesh.n_vertices, (8, 2), replace=False).tolist():
        distance = solver.from_vertices([a])["distance"][b]
        assert karcher_mean(mesh, vertex_points(mesh, [a, b])).value == pytest.approx(distance**2 / 2, rel=1e-3)


def test_order_of_faces() -> None:
    """The mean does not depend on the order of vertices and faces, on rough terrain."""
    rng, flat = np.random.default_rng(4), grid(5, 5)
    mesh = TriangleMesh(flat.vertices + np.outer(rng.uniform(0, 0.4, 36), [0, 0, 1]), flat.faces)
    given, order = rng.choice(36, 3, replace=False), rng.permutation(36)
    rank = np.argsort(order)
    turned = [np.roll(face, rng.integers(3)) for face in rank[mesh.faces][rng.permutation(mesh.n_faces)]]
    other = TriangleMesh(mesh.vertices[order], np.array(turned))
    expected = karcher_mean(mesh, vertex_points(mesh, given)).point.positions(mesh)
    found = karcher_mean(other, vertex_points(other, rank[given])).point.positions(other)
    np.testing.assert_allclose(found, expected, atol=1e-9)


@pytest.mark.parametrize("side", [1, -1])
def test_along_the_boundary(side: int) -> None:
    """Where the mean is on the boundary, the iteration follows it, for either orientation of the faces."""
    vertices, faces = random_mesh("moebius", 908)
    mesh = TriangleMesh(vertices, faces[:, ::side])
    found = karcher_mean(mesh, vertex_points(mesh, [faces[len(faces) // 2, 0], *faces[len(faces) // 3, :2]]))
    assert found.last_step < 1e-9 * found.distances.max()
