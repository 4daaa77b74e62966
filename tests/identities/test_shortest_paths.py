"""Shortest paths: lengths are exact distances, segments lie in faces and are straight across edges and at vertices."""

from functools import cache

import numpy as np
import pytest

from geomhw.geodesic import ExactDistance, ShortestPaths
from geomhw.mesh import TriangleMesh, grid, icosphere
from geomhw.mesh.named_points import face_point, region_points, vertex_points
from geomhw.mesh.surface_points import SurfacePoints, concatenate
from support.hostile import hostile
from support.meshes import book, crumpled, sheared, spiky, split_diagonals, zoo_mesh
from support.paths import lies_in_faces, turns

MESHES = ["tetrahedron", "sphere", "crumpled_sphere", "crumpled_torus", "genus_two", "grid", "annulus", "two_spheres"]
OTHERS = {"book": book, "sheared": sheared, "split_diagonals": split_diagonals, "spiky": spiky}


@cache
def mesh_of(name: str) -> TriangleMesh:
    return OTHERS[name]() if name in OTHERS else zoo_mesh(name)


def points_in_faces(mesh: TriangleMesh, count: int, rng: np.random.Generator) -> SurfacePoints:
    """Return vertices, points in faces and points on edges, in turn."""
    parts = []
    faces = np.setdiff1d(np.arange(mesh.n_faces), mesh.degenerate_faces)
    for k, face in enumerate(rng.choice(faces, count).tolist()):
        weights = rng.dirichlet([1, 1, 1])
        weights[: (0, 1, 2)[k % 3]] = 0
        parts.append(face_point(mesh, face, weights / weights.sum()))
    return concatenate(parts)


@pytest.mark.parametrize("name", [*MESHES, *OTHERS])
def test_length_is_the_exact_distance(name: str) -> None:
    """From points of any kind to vertices, on surfaces with boundary, needles and edges of three faces."""
    mesh, rng = mesh_of(name), np.random.default_rng(3)
    paths, exact = ShortestPaths(mesh), ExactDistance(mesh)
    for source in points_in_faces(mesh, 6, rng).split():
        distance = np.asarray(exact.from_sources(source)["distance"])
        targets = rng.permutation(np.flatnonzero(np.isfinite(distance)))[:10]
        for v, path in zip(targets, paths.to_nearest(source, vertex_points(mesh, targets)), strict=True):
            assert path.length == pytest.approx(distance[v], rel=1e-12)
            assert lies_in_faces(path)
            assert path.vertices[-1] == v


@pytest.mark.parametrize("name", ["crumpled_sphere", "crumpled_torus", "annulus"])
def test_straight(name: str) -> None:
    """A path is straight across edges, and turns at inner vertices of total angle at least 2π only."""
    mesh, rng = mesh_of(name), np.random.default_rng(4)
    total = np.bincount(mesh.faces.ravel(), mesh.angles.ravel())
    for path in ShortestPaths(mesh).between(points_in_faces(mesh, 30, rng), points_in_faces(mesh, 30, rng)):
        np.testing.assert_allclose(turns(path), 0, atol=1e-6)
        at = np.setdiff1d(path.vertices, [*path.end(0).vertices, *path.end(-1).vertices, *mesh.boundary_vertices])
        assert (total[at] > 2 * np.pi - 1e-9).all()


def test_symmetric() -> None:
    """The path back is as long, between points in faces too."""
    mesh, rng = mesh_of("crumpled_torus"), np.random.default_rng(5)
    a, b = points_in_faces(mesh, 20, rng), points_in_faces(mesh, 20, rng)
    paths = ShortestPaths(mesh)
    there, back = ([path.length for path in paths.between(*ends)] for ends in ((a, b), (b, a)))
    np.testing.assert_allclose(there, back, rtol=1e-12)


def test_nearest_source() -> None:
    """Each target gets the path from its nearest source."""
    mesh = icosphere(3)
    sources, targets = vertex_points(mesh, [0, 30, 200]), vertex_points(mesh, [5, 70, 300, 400])
    paths = ShortestPaths(mesh)
    nearest = paths.to_nearest(sources, targets)
    for k, path in enumerate(nearest):
        each = [paths.to_nearest(source, targets.split()[k])[0].length for source in sources.split()]
        assert path.length == pytest.approx(min(each), rel=1e-12)
        assert path.end(0).report()[0] == sources.report()[int(np.argmin(each))]


@pytest.mark.parametrize("name", [*MESHES, *OTHERS])
def test_from_filled_region(name: str) -> None:
    """Paths start at the nearest point of the region, mostly inside its border edges; within it, at their ends."""
    mesh, rng = mesh_of(name), np.random.default_rng(4)
    solver = ExactDistance(mesh)
    near = solver.from_vertices([int(mesh.faces[0, 0])])["distance"]
    inside = np.flatnonzero(near <= np.quantile(near[np.isfinite(near)], 0.15))
    region, ends = region_points(mesh, inside), rng.choice(np.flatnonzero(np.isfinite(near)), 20)
    expected = solver.from_sources(region)["distance"]
    paths = ShortestPaths(mesh).to_nearest(region, vertex_points(mesh, ends))
    for end, path in zip(ends.tolist(), paths, strict=True):
        assert path.length == pytest.approx(expected[end], rel=1e-9, abs=1e-12 * mesh.mean_edge_length)
        used = path.weights[0] > 0
        assert np.isin(mesh.faces[path.faces[0]][used], inside).all()
    (path,) = ShortestPaths(mesh).to_nearest(region_points(mesh, mesh.faces[0]), face_point(mesh, 0))
    assert path.length == 0


def test_through() -> None:
    """A path through points is as long as its parts; a closed one ends where it starts."""
    mesh = crumpled(icosphere(2))
    stops = concatenate([vertex_points(mesh, [0]), face_point(mesh, 40), vertex_points(mesh, [77])])
    paths = ShortestPaths(mesh)
    legs = [paths.between(stops[np.array([i])], stops[np.array([j])])[0].length for i, j in ((0, 1), (1, 2), (2, 0))]
    assert paths.through(stops).length == pytest.approx(sum(legs[:2]), rel=1e-12)
    loop = paths.through(stops, closed=True)
    assert loop.length == pytest.approx(sum(legs), rel=1e-12)
    np.testing.assert_array_equal(loop.positions[0], loop.positions[-1])
    assert lies_in_faces(loop)


def test_no_way() -> None:
    """A path from a point to itself is one point; along an edge it has two."""
    mesh = grid(2, 2)
    (path,) = ShortestPaths(mesh).between(vertex_points(mesh, [4]), vertex_points(mesh, [4]))
    assert (path.length, len(path.faces)) == (0, 1)
    (path,) = ShortestPaths(mesh).between(vertex_points(mesh, [0]), vertex_points(mesh, [1]))
    assert (path.length, len(path.faces)) == (0.5, 2)


def test_pinched() -> None:
    """A path passes through a vertex where two fans meet."""
    mesh = hostile("bow_tie")
    (path,) = ShortestPaths(mesh).between(face_point(mesh, 0), face_point(mesh, mesh.n_faces - 1))
    assert len(path.vertices) == 1


@pytest.mark.parametrize("seed", [0, 3, 80, 120])
def test_among_vertices_in_one_place(seed: int) -> None:
    """Paths to vertices that edges of zero length join, by whichever of them the path arrives, have the distance."""
    rng, ball = np.random.default_rng(seed), icosphere(2)
    points = np.array(ball.vertices)
    for _ in range(12):
        corners = ball.faces[rng.integers(ball.n_faces)][: rng.integers(2, 4)]
        points[corners] = points[corners[0]]
    mesh = TriangleMesh(points, ball.faces)
    paths, exact = ShortestPaths(mesh), ExactDistance(mesh)
    for _ in range(20):
        pair = rng.integers(mesh.n_vertices, size=2)
        (path,) = paths.between(vertex_points(mesh, pair[:1]), vertex_points(mesh, pair[1:]))
        assert path.length == pytest.approx(exact.from_vertices(pair[:1])["distance"][pair[1]], abs=1e-12)


@pytest.mark.parametrize("noise", [1e-9, 1e-8, 1e-7, 1e-4])
def test_crowded_poles(noise: float) -> None:
    """On a globe of rows and columns, whose poles are rows of vertices in nearly one place, paths have their length."""
    rows, columns = 9, 12
    south, east = np.meshgrid(np.linspace(0, np.pi, rows), np.linspace(0, 2 * np.pi, columns), indexing="ij")
    ball = np.stack([np.sin(south) * np.cos(east), np.sin(south) * np.sin(east), np.cos(south)], axis=-1).reshape(-1, 3)
    points = (ball + noise * np.random.default_rng(0).normal(size=ball.shape)).astype(np.float32).astype(float)
    first = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    quads = first[:, None] + np.array([0, columns, columns + 1, 1])
    mesh = TriangleMesh(points, np.concatenate([quads[:, [0, 1, 3]], quads[:, [3, 1, 2]]]))
    poles = np.concatenate([np.arange(columns), mesh.n_vertices - 1 - np.arange(columns)])
    paths = ShortestPaths(mesh)
    for source in (0, columns // 2, mesh.n_vertices // 2, mesh.n_vertices - 1):
        distance = np.asarray(paths.exact().from_sources(vertex_points(mesh, [source]))["distance"])
        targets = np.setdiff1d(poles, source)
        found = paths.between(*(vertex_points(mesh, ids) for ids in ([source] * len(targets), targets)))
        np.testing.assert_allclose([path.length for path in found], distance[targets], rtol=1e-6, atol=1e-6)
