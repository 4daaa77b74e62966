"""Exact distances: enumeration, symmetry, triangle inequality, bounds, motion, numbering, limits, several sources."""

import numpy as np
import pytest
from scipy.spatial import Delaunay

from geomhw.geodesic.edge_paths import edge_path_distance
from geomhw.geodesic.exact import ExactDistance
from geomhw.mesh.named_points import face_point, vertex_points
from geomhw.mesh.primitives import grid, icosphere, moebius_band, torus
from geomhw.mesh.surface_points import SurfacePoints, concatenate
from geomhw.mesh.triangle_mesh import TriangleMesh
from support.hostile import HOSTILE, hostile
from support.meshes import ZOO, crumpled, zoo_mesh
from support.shortest_paths import enumerated_distances

#: Names of the hostile meshes that are within the range of coordinates.
VALID = sorted(name for name in HOSTILE if not name.endswith(("_150", "_310")))


def exact(mesh: TriangleMesh, *sources: int) -> np.ndarray:
    """Return the distances from vertices."""
    return np.asarray(ExactDistance(mesh).from_vertices(sources)["distance"])


def random_triangles(seed: int) -> TriangleMesh:
    """Return up to eleven random triangles between up to eight points: edges with several faces, pinched vertices."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(4, 9))
    faces = np.array([np.sort(rng.choice(n, 3, replace=False)) for _ in range(rng.integers(2, 12))])
    return TriangleMesh(rng.normal(size=(n, 3)), np.unique(faces, axis=0))


def t_junctions(seed: int, height: float) -> TriangleMesh:
    """Return a grid with points on its edges, moved by a height, between edge and faces of nearly zero area."""
    rng = np.random.default_rng(seed)
    mesh = grid(4, 4)
    points, faces = mesh.vertices.tolist(), mesh.faces.tolist()
    for _ in range(8):
        f, share = int(rng.integers(len(faces))), rng.choice([0.5, 0.3, 1e-9, 0.0])
        a, b, c = faces[f]
        place = (1 - share) * np.array(points[a]) + share * np.array(points[b])
        points.append((place + height * rng.normal(size=3)).tolist())
        faces[f] = [a, len(points) - 1, c]
        faces += [[len(points) - 1, b, c], [a, b, len(points) - 1]]
    return TriangleMesh(points, faces)


SMALL = {
    "tetrahedron": lambda: hostile("tetrahedron"),
    "touching_edge": lambda: hostile("touching_edge"),
    "icosahedron": lambda: icosphere(0),
    "torus": lambda: torus(3, 3),
    "moebius": lambda: moebius_band(5, 1),
    "maze": lambda: TriangleMesh(grid(4, 4).vertices, np.delete(grid(4, 4).faces, [4, 9, 13, 18, 23, 27], axis=0)),
} | {f"random_{seed}": (lambda seed=seed: random_triangles(seed)) for seed in range(20)}


@pytest.mark.parametrize("name", SMALL)
def test_against_enumeration(name: str) -> None:
    """Distances equal the shortest of all straight lines over all sequences of faces."""
    mesh = SMALL[name]()
    expected = enumerated_distances(mesh)
    for source in np.unique(mesh.faces):
        found = exact(mesh, source)
        np.testing.assert_allclose(found, expected[source], rtol=0, atol=1e-12 * found[np.isfinite(found)].max())


def assert_metric(mesh: TriangleMesh, count: int = 8) -> None:
    """Assert bounds, symmetry and the triangle inequality of the distances between vertices."""
    vertices = np.unique(mesh.faces)
    vertices = vertices[np.linspace(0, len(vertices) - 1, min(count, len(vertices))).astype(int)]
    solver = ExactDistance(mesh)
    rows = np.array([solver.from_vertices([v])["distance"] for v in vertices])
    paths = np.array([edge_path_distance(mesh, np.array([v])) for v in vertices])
    finite = np.isfinite(rows)
    assert np.array_equal(finite, np.isfinite(paths))
    rounding = 1e-12 * rows[finite].max()
    assert (rows[finite] <= paths[finite] + rounding).all()
    chords = np.linalg.norm(mesh.vertices - mesh.vertices[vertices, None], axis=2)
    assert (rows[finite] >= chords[finite] - rounding).all()
    rows = np.where(finite, rows, 1e300)
    between = rows[:, vertices]
    np.testing.assert_allclose(between, between.T, rtol=0, atol=rounding)
    assert (rows[:, None] <= between[:, :, None] + rows + rounding).all()


@pytest.mark.parametrize("name", sorted(ZOO))
def test_metric(name: str) -> None:
    assert_metric(zoo_mesh(name))


@pytest.mark.parametrize("name", VALID)
def test_metric_hostile(name: str) -> None:
    assert_metric(hostile(name))


@pytest.mark.parametrize("height", [0.0, 1e-17, 1e-13, 1e-9, 1e-6, 1e-3])
def test_metric_at_t_junctions(height: float) -> None:
    """Faces of zero area and needles lose no path along them."""
    for seed in range(12):
        assert_metric(t_junctions(seed, height))


def collapsed(seed: int, length: float) -> TriangleMesh:
    """Return a sphere with ten edges of nearly zero length."""
    rng = np.random.default_rng(seed)
    mesh = icosphere(2)
    points = mesh.vertices.copy()
    for a, b, _ in mesh.faces[rng.choice(mesh.n_faces, 10)]:
        points[a] = points[b] + length * rng.normal(size=3)
    return TriangleMesh(points, mesh.faces)


@pytest.mark.parametrize(
    "make",
    [
        lambda: crumpled(icosphere(2)),
        lambda: hostile("book_3"),
        lambda: t_junctions(3, 0.0),
        lambda: t_junctions(4, 1e-10),
        lambda: collapsed(0, 1e-15),
        lambda: collapsed(13, 1e-15),
        lambda: collapsed(122, 1e-15),
    ],
)
def test_numbering_motion_and_scale(make) -> None:  # type: ignore[no-untyped-def]
    """Distances change by rounding only if the mesh is scaled, turned, renumbered, or its faces are flipped."""
    mesh = make()
    rng = np.random.default_rng(1)
    expected = exact(mesh, 5)
    for scale in (1e-20, 1e20):
        found = exact(TriangleMesh(mesh.vertices * scale, mesh.faces), 5) / scale
        np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)
    rotation = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    np.testing.assert_allclose(
        exact(TriangleMesh(mesh.vertices @ rotation, mesh.faces), 5), expected, rtol=1e-12, atol=1e-12
    )
    order = rng.permutation(mesh.n_vertices)
    number = np.argsort(order)
    faces = rng.permutation(number[mesh.faces])
    faces[::2] = faces[::2, ::-1]
    found = exact(TriangleMesh(mesh.vertices[order], faces), int(number[5]))
    np.testing.assert_allclose(found[number], expected, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("seed", range(10))
def test_several_sources(seed: int) -> None:
    """From several sources, in faces, on edges and at vertices, the distance is the least of those from each."""
    mesh = t_junctions(seed, 0.0) if seed % 2 else crumpled(icosphere(2))
    rng = np.random.default_rng(seed)
    faces = rng.choice(mesh.n_faces, 3)
    weights: list[list[float]] = [[0.2, 0.3, 0.5], [0, 0.4, 0.6], [0.5, 0.5, 0]]
    points = [face_point(mesh, int(f), w) for f, w in zip(faces, weights, strict=True)] + [vertex_points(mesh, [4])]
    solver = ExactDistance(mesh)
    rows = [solver.from_sources(point)["distance"] for point in points]
    found = solver.from_sources(concatenate(points))["distance"]
    np.testing.assert_allclose(found, np.min(rows, axis=0), rtol=1e-12, atol=1e-12)


def test_point_in_face_is_vertex_of_finer_mesh() -> None:
    """A source within a face gives the distances from the vertex that divides the face there."""
    mesh = crumpled(icosphere(2))
    a, b, c = mesh.faces[7]
    point = face_point(mesh, 7, [0.2, 0.3, 0.5])
    n = mesh.n_vertices
    faces = np.concatenate([np.delete(mesh.faces, 7, axis=0), [[a, b, n], [b, c, n], [c, a, n]]])
    finer = TriangleMesh(np.concatenate([mesh.vertices, point.positions(mesh)]), faces)
    found = ExactDistance(mesh).from_sources(point)["distance"]
    np.testing.assert_allclose(found, exact(finer, n)[:-1], rtol=1e-12)


def test_point_on_edge_is_same_in_all_faces() -> None:
    """A point on an edge gives the same distances as a point of any face there."""
    mesh = hostile("book_3")
    spine = next(edge for edge in mesh.edges if sum(set(edge) <= set(face) for face in mesh.faces.tolist()) == 3)
    rows = []
    for f, face in enumerate(mesh.faces):
        if set(spine) <= set(face):
            weights = np.where(face == spine[0], 0.3, np.where(face == spine[1], 0.7, 0.0))
            rows.append(ExactDistance(mesh).from_sources(face_point(mesh, f, weights))["distance"])
    assert len(rows) == 3
    np.testing.assert_allclose(rows[1:], [rows[0]] * 2, rtol=1e-12)


@pytest.mark.parametrize("name", ["crumpled_sphere", "crumpled_torus", "genus_two", "annulus"])
def test_turning_directions(name: str) -> None:
    """Paths that may turn in any direction at all vertices are no shorter than those restricted by angles."""
    mesh = zoo_mesh(name)
    used = np.unique(mesh.faces)
    for source in used[:: max(9, len(used) // 60)]:
        solver = ExactDistance(mesh)
        solver.surface.totals[:] = np.inf
        found = solver.from_vertices([source])["distance"]
        np.testing.assert_allclose(exact(mesh, source), found, rtol=1e-13, atol=0)


@pytest.mark.parametrize("share", [0.0, 0.1, 0.5, 1.0])
def test_limit(share: float) -> None:
    """Up to the limit distances are those without one, and inf beyond."""
    mesh = zoo_mesh("crumpled_torus")
    expected = exact(mesh, 3)
    limit = share * expected.max()
    found = ExactDistance(mesh).from_vertices([3], limit=limit)["distance"]
    np.testing.assert_array_equal(found, np.where(expected <= limit, expected, np.inf))


def test_targets() -> None:
    """Distances at targets are bit for bit those without targets, and all given distances are final."""
    mesh = zoo_mesh("crumpled_torus")
    expected = exact(mesh, 3)
    targets = np.argsort(expected)[[20, 7]]
    found = ExactDistance(mesh).from_vertices([3], targets=targets)["distance"]
    there = np.isfinite(found)
    np.testing.assert_array_equal(found[there], expected[there])
    assert there[targets].all()
    assert np.count_nonzero(there) < mesh.n_vertices / 2


def test_arrivals_are_lengths_of_straight_lines() -> None:
    """The straight line into a vertex has the length by which its distance exceeds that of its origin."""
    mesh = zoo_mesh("annulus")
    found = ExactDistance(mesh).arrivals(vertex_points(mesh, [0]))
    there = np.isfinite(found.distance)
    np.testing.assert_array_equal(found.origin[~there], np.flatnonzero(~there))
    length = found.distance[there] - found.distance[found.origin[there]]
    chord = np.linalg.norm(mesh.vertices - mesh.vertices[found.origin], axis=1)[there]
    assert (length >= chord * (1 - 1e-12)).all()
    beside = found.halfedge[there] < 0
    np.testing.assert_allclose(length[beside], chord[beside], rtol=1e-12)


def test_duplicate_faces_change_nothing() -> None:
    """Sources in a duplicate face, and distances over it, are those of the first face."""
    mesh = crumpled(icosphere(1))
    double = TriangleMesh(mesh.vertices, np.concatenate([mesh.faces, mesh.faces[3:5, ::-1]]))
    sources: list[SurfacePoints] = [face_point(mesh, 3), face_point(double, mesh.n_faces)]
    rows = [ExactDistance(m).from_sources(s)["distance"] for m, s in zip((mesh, double), sources, strict=True)]
    np.testing.assert_allclose(rows[1], rows[0], rtol=1e-12)


def thin_terrain(seed: int) -> TriangleMesh:
    """Return a rough strip, 10,000 times as long as wide: windows are cut far from their nearest points."""
    rng = np.random.default_rng(seed)
    points = rng.random((70, 2))
    faces = Delaunay(points).simplices
    return TriangleMesh(np.column_stack([points * [1, 1e-4], 0.05 * rng.normal(size=70)]), faces)


@pytest.mark.parametrize("seed", range(6))
def test_limit_on_thin_terrain(seed: int) -> None:
    """No window within the limit is lost where its nearest point was cut off."""
    mesh = thin_terrain(seed)
    solver = ExactDistance(mesh)
    for source in range(0, 70, 5):
        expected = solver.from_vertices([source])["distance"]
        for limit in np.quantile(expected, [0.2, 0.5, 0.8]):
            found = solver.from_vertices([source], limit=limit)["distance"]
            inside, outside = expected <= limit * (1 - 1e-12), expected > limit * (1 + 1e-12)
            np.testing.assert_allclose(found[inside], expected[inside], rtol=1e-13)
            assert np.isinf(found[outside]).all()


def test_source_beside_face_of_zero_area() -> None:
    """From one of two vertices at one place in the middle of an edge, rays pass the edge in all directions."""
    points = [[0.2, 0.6, 0], [0.4, 0.6, 0], [0.6, 0.6, 0], [0.4, 0.8, 0], [0.5, 0.7, 0], [0.5, 0.7, 0]]
    mesh = TriangleMesh(points, [[0, 1, 3], [3, 1, 2], [3, 2, 4], [4, 2, 5]])
    assert exact(mesh, 5)[0] == pytest.approx(np.hypot(0.3, 0.1), rel=1e-12)


@pytest.mark.parametrize("name", ["crumpled_sphere", "strip", "two_spheres", "book_3", "loose_middle", "flat_vertex"])
@pytest.mark.parametrize("share", [0.3, 1.0])
def test_matrix(name: str, share: float) -> None:
    """The matrix is symmetric, and stores the distances within the limit, zeros included."""
    mesh = hostile(name) if name in HOSTILE else zoo_mesh(name)
    solver = ExactDistance(mesh)
    vertices = np.unique(mesh.faces)
    rows = solver.rows([vertex_points(mesh, [v]) for v in vertices])[:, vertices]
    limit = share * rows[np.isfinite(rows)].max()
    found = solver.matrix(limit)[vertices][:, vertices]
    stored = found.copy()
    stored.data[:] = 1
    clear = abs(rows - limit) > 1e-12 * limit
    np.testing.assert_array_equal(stored.toarray()[clear], rows[clear] <= limit)
    np.testing.assert_allclose(found.toarray()[clear], np.where(rows <= limit, rows, 0)[clear], rtol=1e-12, atol=1e-15)
    assert abs(found - found.T).nnz == 0
