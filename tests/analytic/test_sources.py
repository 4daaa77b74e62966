"""Sources of all kinds: what they are, that distances are right at and beside them, far away, and in any order."""

from collections.abc import Callable

import numpy as np
import pytest
from conftest import sheared, split_diagonals, two_spheres, zoo_mesh

from geomhw.errors import FieldError
from geomhw.geodesic.edge_paths import edge_path_distance
from geomhw.geodesic.heat_method import HeatDistance
from geomhw.geodesic.source_conditions import known_distances
from geomhw.mesh.nearest import nearest_on_surface
from geomhw.mesh.primitives import grid, icosphere, strip
from geomhw.mesh.surface_points import (
    SurfacePoints,
    boundary_points,
    concatenate,
    extreme_vertex,
    face_point,
    nearest_point,
    vertex_points,
    vertex_range,
)
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.transport.source_vectors import source_frames, spread_to_corners, turned
from geomhw.transport.vector_heat import VectorHeat

INSIDE = [0.2, 0.3, 0.5]


def great_circles(mesh: TriangleMesh, sources: SurfacePoints) -> np.ndarray:
    """Exact distance on the unit sphere from the nearest of the sources, brought onto it."""
    a = mesh.vertices
    ends = sources.positions(mesh)
    ends /= np.linalg.norm(ends, axis=1, keepdims=True)
    return np.min([np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), a @ b) for b in ends], axis=0)


def straight_lines(mesh: TriangleMesh, sources: SurfacePoints) -> np.ndarray:
    """Exact distance on a convex flat mesh."""
    return np.min([np.linalg.norm(mesh.vertices - b, axis=1) for b in sources.positions(mesh)], axis=0)


def errors(
    mesh: TriangleMesh, sources: SurfacePoints, exact: np.ndarray, time: str = "h2"
) -> tuple[float, float, float]:
    """Mean error within 3 h of the sources, mean and largest farther away, all in h."""
    h = mesh.mean_edge_length
    error = np.abs(HeatDistance(mesh, time).from_sources(sources)["distance"] - exact) / h
    near = (exact > 0) & (exact < 3 * h)
    far = exact >= 3 * h
    return float(error[near].mean()), float(error[far].mean()), float(error[far].max())


# -- several vertices ----------------------------------------------------------------------------------------------


def test_zero_at_all_sources_and_nowhere_else(mesh: TriangleMesh) -> None:
    """On every mesh of the zoo, from every fifth vertex: 0 at these, positive elsewhere."""
    wanted = np.setdiff1d(np.arange(0, mesh.n_vertices, 5), mesh.unreferenced_vertices)
    distance = HeatDistance(mesh, "h2").from_vertices(wanted)["distance"]
    assert np.flatnonzero(distance <= 0).tolist() == wanted.tolist()


def test_sources_are_equally_warm() -> None:
    """u is the same at all source vertices; (M + tS) u sums to one each, and is zero elsewhere."""
    from geomhw.operators.laplacian import stiffness
    from geomhw.operators.mass import lumped_mass

    mesh = zoo_mesh("crumpled_torus")
    wanted = [3, 4, 5, 90, 200]
    solver = HeatDistance(mesh, "h2")
    u = solver.from_vertices(wanted)["heat"]
    np.testing.assert_allclose(u[wanted], u[3], rtol=1e-12)
    started = lumped_mass(mesh) @ u + solver.time.t * (stiffness(mesh) @ u)
    assert started.sum() == pytest.approx(len(wanted), rel=1e-12)
    assert np.abs(np.delete(started, wanted)).max() < 1e-12


@pytest.mark.parametrize(("time", "bounds"), [("h2", (0.075, 0.06, 0.18)), ("sqrt-h", (0.065, 0.06, 0.16))])
def test_distance_from_a_great_circle(time: str, bounds: tuple[float, ...]) -> None:
    """From the vertices of the equator, the latitude; the circle sheds heat straight at any time step."""
    mesh = icosphere(4)
    latitude = np.abs(np.arcsin(mesh.vertices[:, 1]))
    equator = np.flatnonzero(latitude < 1e-9)
    assert len(equator) == 64
    latitude[equator] = 0
    found = errors(mesh, vertex_points(mesh, equator), latitude, time)
    assert all(error <= bound for error, bound in zip(found, bounds, strict=True)), found


def test_distance_from_the_boundary() -> None:
    """In a square, the distance from the nearest side: right beside it, and better on a finer mesh."""
    relative = []
    for cells in (16, 32, 64):
        mesh = grid(cells, cells)
        exact = np.minimum(mesh.vertices, 1 - mesh.vertices)[:, :2].min(axis=1)
        near, far, largest = errors(mesh, boundary_points(mesh), exact)
        assert near < 0.04
        assert far < 0.03
        assert largest < 0.6
        relative.append(far * mesh.mean_edge_length)
    rates = np.log2(np.array(relative[:-1]) / relative[1:])
    assert (rates > 0.9).all(), rates


def test_distance_from_the_end_of_a_band() -> None:
    """On a cylinder, the height above one end."""
    flat = grid(40, 40, 2 * np.pi, 2 * np.pi)
    angle, height = flat.vertices[:, 0], flat.vertices[:, 1]
    seam = np.arange(flat.n_vertices) - np.where(np.arange(flat.n_vertices) % 41 == 40, 40, 0)
    kept, names = np.unique(seam, return_inverse=True)
    mesh = TriangleMesh(np.stack([np.cos(angle), height, np.sin(angle)], axis=1)[kept], names[flat.faces])
    height = mesh.vertices[:, 1]
    found = errors(mesh, vertex_points(mesh, np.flatnonzero(height == 0)), height)
    assert found[0] < 0.02
    assert found[1] < 0.05
    assert found[2] < 0.14


def test_curve_beyond_the_reach_of_doubles() -> None:
    """From one end of a strip of 3000 cells, and from both, each point's distance is along the strip."""
    mesh = strip(3000)
    x = mesh.vertices[:, 0]
    ends = np.flatnonzero(x == 0), np.flatnonzero((x == 0) | (x == x.max()))
    for wanted, exact in zip(ends, (x, np.minimum(x, x.max() - x)), strict=True):
        distance = HeatDistance(mesh).from_vertices(wanted)["distance"]
        np.testing.assert_allclose(distance, exact, atol=0.04, rtol=0.01)


# -- points within faces -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("build", "exact", "faces", "bounds"),
    [
        (lambda: icosphere(3), great_circles, (0, 200, 700), (0.09, 0.1, 0.2)),
        (lambda: icosphere(4), great_circles, (0, 900, 3000), (0.09, 0.15, 0.33)),
        (lambda: grid(24, 24), straight_lines, (500, 560, 630), (0.16, 0.37, 1.15)),
    ],
)
def test_point_within_a_face(
    build: Callable[[], TriangleMesh],
    exact: Callable[[TriangleMesh, SurfacePoints], np.ndarray],
    faces: tuple[int, ...],
    bounds: tuple[float, ...],
) -> None:
    """On the sphere and in the plane: mean error near, mean and largest far away, in h (from vertices 0.07 to 0.14,
    0.13 to 0.3, 0.31 to 0.92)."""
    mesh = build()
    for face in faces:
        for weights in (None, INSIDE, [0.05, 0.9, 0.05], [0.5, 0.5, 0.0]):
            point = face_point(mesh, face, weights)
            found = errors(mesh, point, exact(mesh, point))
            assert all(error <= bound for error, bound in zip(found, bounds, strict=True)), (face, weights, found)


def test_corners_are_exact() -> None:
    """The corners of the face are as far as the straight lines to them; on an edge those of both faces."""
    mesh = zoo_mesh("crumpled_torus")
    for weights, count in ((INSIDE, 3), ([0.25, 0.0, 0.75], 4)):
        point = face_point(mesh, 17, weights)
        distance = HeatDistance(mesh, "h2").from_sources(point)["distance"]
        straight = np.linalg.norm(mesh.vertices - point.positions(mesh), axis=1)
        ring = mesh.faces[
            np.isin(mesh.faces, mesh.faces[17][np.array(weights) > 0]).sum(axis=1) == np.sum(point.weights > 0)
        ]
        assert len(np.unique(ring)) == count
        np.testing.assert_allclose(distance[ring], straight[ring], rtol=1e-12)
        assert (distance > 0).all()


@pytest.mark.parametrize("robust", [False, True])
def test_refined_from_within_faces(robust: bool) -> None:
    """In the plane, refined distances from points within faces are straight lines, over slivers and, if robust, faces
    without area too, in one of which a point may lie."""
    flat = split_diagonals()
    for mesh, face in [(sheared(12, 20.0), 70), *[(flat, f) for f in (70, flat.degenerate_faces[40]) if robust]]:
        for weights in (INSIDE, [0.5, 0.0, 0.5]):
            point = face_point(mesh, int(face), weights)
            found = HeatDistance(mesh, "h2", robust=robust, refine=True).from_sources(point)["distance"]
            np.testing.assert_allclose(found, straight_lines(mesh, point), rtol=1e-9, atol=1e-14)


def test_refined_on_the_sphere() -> None:
    """Refined, distances from points within faces and vertices are several times closer to the great circles."""
    mesh = icosphere(4)
    sources = concatenate([face_point(mesh, 900, INSIDE), vertex_points(mesh, [3]), face_point(mesh, 4000)])
    exact = great_circles(mesh, sources)
    plain, refined = (
        np.abs(HeatDistance(mesh, "h2", refine=refine).from_sources(sources)["distance"] - exact).mean()
        for refine in (False, True)
    )
    assert refined < 0.1 * plain


def test_paths_along_edges_start_at_the_corners() -> None:
    """From several starts, each with its own length, the shortest of all paths; no distance is longer."""
    mesh = zoo_mesh("crumpled_torus")
    sources = concatenate([face_point(mesh, 17, INSIDE), vertex_points(mesh, [200])])
    known = known_distances(mesh, sources)
    first = np.flatnonzero(np.isfinite(known))
    path = edge_path_distance(mesh, first, known)
    single = [known[vertex] + edge_path_distance(mesh, np.array([vertex])) for vertex in first]
    np.testing.assert_allclose(path, np.min(single, axis=0), rtol=1e-14)
    assert (HeatDistance(mesh, "20*h2").from_sources(sources)["distance"] <= path).all()


def test_corner_is_the_vertex() -> None:
    """With all weight on one corner a point is that vertex, to the last bit; so is one a rounding away."""
    mesh = zoo_mesh("sphere")
    vertex = HeatDistance(mesh).from_vertices([mesh.faces[17, 1]])
    for weights in ([0, 1, 0], [1e-12, 1 - 2e-12, 1e-12]):
        corner = HeatDistance(mesh).from_sources(face_point(mesh, 17, weights))
        assert corner.report["sources"] == [mesh.faces[17, 1]]
        np.testing.assert_array_equal(corner["distance"], vertex["distance"])


def test_edge_belongs_to_both_faces() -> None:
    """A point on an edge, named by either face, is one source with one answer."""
    mesh = zoo_mesh("crumpled_sphere")
    face, corner = 40, 0
    edge = mesh.edge_table.of_faces[face, corner]
    (other,) = np.setdiff1d(np.flatnonzero((mesh.edge_table.of_faces == edge).any(axis=1)), [face])
    a, b = mesh.faces[face, [1, 2]]
    names = [
        face_point(mesh, f, np.where(mesh.faces[f] == a, 0.3, np.where(mesh.faces[f] == b, 0.7, 0.0)))
        for f in (face, other)
    ]
    assert len(concatenate(names).distinct()[0]) == 1
    one, again = (HeatDistance(mesh, "h2").from_sources(name)["distance"] for name in names)
    np.testing.assert_allclose(one, again, rtol=1e-12)


def mixed(mesh: TriangleMesh) -> list[SurfacePoints]:
    """Vertices and points within faces, two in one face, one given twice."""
    return [
        vertex_points(mesh, [9]),
        face_point(mesh, 30),
        face_point(mesh, 30, INSIDE),
        vertex_points(mesh, [200, 3]),
        face_point(mesh, 90, [0.5, 0.0, 0.5]),
    ]


@pytest.mark.parametrize("robust", [False, True])
def test_order_and_repetition_do_not_matter(robust: bool) -> None:
    """Every field and the report are the same for sources in any order, some of them given twice."""
    mesh = zoo_mesh("torus")
    parts = mixed(mesh)
    solver = HeatDistance(mesh, robust=robust)
    first = solver.from_sources(concatenate(parts))
    assert len(first.report["sources"]) == 6
    for order in ([4, 3, 2, 1, 0], [2, 4, 2, 0, 3, 0, 1]):
        again = solver.from_sources(concatenate([parts[k] for k in order]))
        assert again.report == first.report
        for field in first.fields:
            np.testing.assert_array_equal(again[field.name], field.values)


def test_mixed_sources_renumbered_and_scaled() -> None:
    """Distances belong to places: another numbering, another scale, the same answer."""
    mesh = zoo_mesh("torus")
    sources = concatenate(mixed(mesh))
    before = HeatDistance(mesh, "h2").from_sources(sources)["distance"]
    order = np.random.default_rng(1).permutation(mesh.n_vertices)
    name = np.argsort(order)
    other = TriangleMesh(1e5 * mesh.vertices[order], name[mesh.faces])
    renamed = SurfacePoints(sources.faces, name[sources.corners], sources.weights)
    after = HeatDistance(other, "h2").from_sources(renamed)["distance"]
    np.testing.assert_allclose(after, 1e5 * before[order], atol=1e-6)


def test_robust_agrees_on_a_delaunay_mesh() -> None:
    """With nothing to flip, --robust changes rounding only, for points within faces too."""
    mesh = icosphere(3)
    sources = concatenate([face_point(mesh, 5, INSIDE), vertex_points(mesh, [100, 101])])
    one, other = (HeatDistance(mesh, "h2", robust=r, refine=False).from_sources(sources) for r in (False, True))
    for field in one.fields:
        size = np.abs(field.values).max()
        np.testing.assert_allclose(other[field.name], field.values, rtol=0, atol=1e-10 * size)


def test_two_components() -> None:
    """A point on each ball: what one has does not depend on the other."""
    mesh = two_spheres()
    point, other = face_point(mesh, 5, INSIDE), face_point(mesh, 500)
    alone = HeatDistance(mesh, "h2").from_sources(point)["distance"]
    both = HeatDistance(mesh, "h2").from_sources(concatenate([point, other]))["distance"]
    np.testing.assert_allclose(both[:162], alone[:162], rtol=1e-12)
    assert np.isinf(alone[163:]).all()
    assert np.isfinite(both[163:]).all()


def test_faces_between_sources_have_no_direction() -> None:
    """Where all three corners are sources, heat is level: no direction, rather than that of its rounding."""
    mesh = zoo_mesh("sphere")
    wanted = np.unique(mesh.faces[np.isin(mesh.faces, mesh.faces[0]).any(axis=1)])
    lengths = np.linalg.norm(HeatDistance(mesh, "h2").from_vertices(wanted)["direction"], axis=1)
    level = np.isin(mesh.faces, wanted).all(axis=1)
    assert level.sum() >= 10
    assert not lengths[level].any()
    np.testing.assert_allclose(lengths[~level], 1, atol=1e-14)


def test_corner_nearer_to_another_source() -> None:
    """A corner of the point's face that is nearer to another source: right if that is a vertex beside it, and not held
    at what is too far if that is a point two faces away."""
    mesh = grid(24, 24)
    longest = int(np.argmax(np.linalg.norm(mesh.opposite_edges[600], axis=1)))
    c, a, b = np.roll(mesh.faces[600], -longest)
    point = face_point(mesh, 600, np.roll([0.06, 0.92, 0.02], longest))
    straight = np.linalg.norm(mesh.vertices[b] - point.positions(mesh)[0])
    beyond = np.flatnonzero(((mesh.vertices - mesh.vertices[b]) @ (mesh.vertices[b] - mesh.vertices[a])) > 0)
    vertex = beyond[np.argmin(np.linalg.norm(mesh.vertices[beyond] - mesh.vertices[b], axis=1))]
    away = np.flatnonzero(~np.isin(mesh.faces, [a, b, c]).any(axis=1))
    face = away[np.argmin(np.linalg.norm(mesh.face_centers[away] - mesh.vertices[b], axis=1))]
    near = np.linalg.norm(mesh.vertices[mesh.faces[face]] - mesh.vertices[b], axis=1)
    far = face_point(mesh, face, np.where(near == near.min(), 0.94, 0.03))
    for other, bound in ((vertex_points(mesh, [vertex]), 1e-12), (far, 0.8)):
        sources = concatenate([point, other])
        exact = straight_lines(mesh, sources)
        assert exact[b] < 0.9 * straight  # else this says nothing
        distance = HeatDistance(mesh, "h2").from_sources(sources)["distance"]
        assert abs(distance[b] - exact[b]) < bound * (straight - exact[b]), (distance[b], exact[b], straight)
        assert abs(distance[c] - exact[c]) < 1e-12


def test_sources_of_another_sheet_do_not_count() -> None:
    """Two sheets a hundredth of an edge apart: each has the corners of its own source's face known."""
    sheet = grid(6, 6)
    n = sheet.n_vertices
    both = TriangleMesh(
        np.concatenate([sheet.vertices, sheet.vertices + np.array([0, 0, 1e-3])]),
        np.concatenate([sheet.faces, sheet.faces + n]),
    )
    sources = concatenate([face_point(both, 30), face_point(both, 30 + sheet.n_faces, [0.1, 0.1, 0.8])])
    known = known_distances(both, sources)
    assert np.count_nonzero(np.isfinite(known)) == 6
    for place, face in zip(sources.positions(both), both.faces[[30, 30 + sheet.n_faces]], strict=True):
        np.testing.assert_allclose(known[face], np.linalg.norm(both.vertices[face] - place, axis=1), rtol=1e-14)


def test_a_pile_of_sheets() -> None:
    """Where through space every corner is nearer to a source of another sheet, one is held all the same."""
    turn = np.radians(90 * np.arange(4)[:, None] + [60, 180, 300])
    height = np.broadcast_to(1e-3 * np.arange(4)[:, None], turn.shape)
    corners = np.stack([np.cos(turn), np.sin(turn), height], axis=2).reshape(-1, 3)
    sheets = np.arange(12).reshape(4, 3)
    straps = np.stack([sheets[:, 0], np.full(4, 12), sheets[:, 1]], axis=1)
    mesh = TriangleMesh([*corners, [0, 0, 5]], [*sheets, *straps])
    middle = np.radians(90 * np.arange(4))
    shifted = 0.01 * np.stack([np.cos(middle), np.sin(middle), 0 * middle], axis=1)
    weights = 1 / 3 + 2 / 3 * np.einsum("sx,skx->sk", shifted, corners.reshape(4, 3, 3))
    sources = concatenate([face_point(mesh, k, weights[k]) for k in range(4)])
    known = known_distances(mesh, sources)
    (held,) = np.flatnonzero(np.isfinite(known))
    assert known[held] == pytest.approx(1, abs=0.02)
    distance = HeatDistance(mesh, "h2").from_sources(sources)["distance"]
    assert (distance > 0).all()


def test_what_comes_out_below_zero_is_told() -> None:
    """On slivers the plain method goes far below zero: raised to the chord, and counted in the report."""
    mesh = sheared(24, 20.0)
    result = HeatDistance(mesh, "h2").from_vertices([312, 313])
    raised = result.report["below_zero"]
    assert raised["vertices"] > 0
    assert raised["lowest"] < 0
    assert (np.delete(result["distance"], [312, 313]) > 0).all()
    assert "below_zero" not in HeatDistance(mesh, "h2", robust=True).from_vertices([312, 313]).report


# -- places --------------------------------------------------------------------------------------------------------


def test_nearest_point_of_the_surface() -> None:
    """Off a sphere's face along its normal, back at the point; above an edge or a corner, on it; far away, the top."""
    mesh = zoo_mesh("sphere")
    for face in (0, 300, 1279):
        for weights in (INSIDE, [0.9, 0.05, 0.05]):
            place = face_point(mesh, face, weights).positions(mesh)[0]
            for height in (0.0, 0.02, -0.01):
                found, b = nearest_on_surface(mesh, place + height * mesh.face_normals[face])
                assert found == face
                np.testing.assert_allclose(b, weights, atol=1e-10)
    a, b = mesh.edges[70]
    middle = mesh.vertices[[a, b]].mean(axis=0)
    on_edge = nearest_point(mesh, 1.5 * middle)
    np.testing.assert_allclose(on_edge.positions(mesh)[0], middle, atol=1e-12)
    assert np.count_nonzero(on_edge.weights) == 2
    for vertex in (0, 77):
        assert nearest_point(mesh, mesh.vertices[vertex]).report() == [vertex]
        assert nearest_point(mesh, 9 * mesh.vertices[vertex]).report() == [vertex]


def test_nearest_is_no_farther_than_any_sample() -> None:
    """No point of a dense sample of the surface is nearer than the one found, from anywhere."""
    from geomhw.mesh.sampling import area_samples, points_on

    mesh = zoo_mesh("crumpled_torus")
    samples = points_on(mesh, *area_samples(mesh, 20_000))
    for point in np.random.default_rng(0).normal(size=(20, 3)):
        found = nearest_point(mesh, point).positions(mesh)[0]
        assert np.linalg.norm(found - point) <= np.linalg.norm(samples - point, axis=1).min() + 1e-12


def test_extreme_vertices() -> None:
    """The lowest index on a tie, and never a vertex of no face."""
    square = grid(4, 4)
    assert [extreme_vertex(square, axis, sign) for axis, sign in ((0, 1), (0, -1), (1, 1), (1, -1))] == [4, 0, 20, 0]
    balls = two_spheres()
    assert balls.vertices[extreme_vertex(balls, 1, 1), 1] == pytest.approx(1, abs=0.1)


def test_weights_are_normalized() -> None:
    """Thirds rounded to two digits are thirds."""
    np.testing.assert_allclose(face_point(zoo_mesh("sphere"), 3, [0.33, 0.33, 0.33]).weights, 1 / 3, rtol=1e-15)


@pytest.mark.parametrize(
    ("place", "words"),
    [
        (lambda m: face_point(m, 640), r"face 640 does not exist: the mesh has 640 faces \(0 to 639\)"),
        (lambda m: face_point(m, -1), "face -1 does not exist"),
        (lambda m: face_point(m, 3, [0.5, 0.7, -0.2]), "0.5, 0.7, -0.2 lie outside of face 3; none may be negative"),
        (lambda m: face_point(m, 3, [0.5, 0.2, 0.2]), r"sum to 0\.9; they must sum to 1"),
        (lambda m: face_point(m, 3, [0.5, 0.5]), "three barycentric coordinates"),
        (lambda m: face_point(m, 3, [np.nan, 0.5, 0.5]), "three barycentric coordinates"),
        (lambda m: vertex_range(m, 3, 10**15), "source 1000000000000000 is not a vertex"),
        (lambda m: vertex_range(m, 160, 163), "source 162 belongs to no face"),
        (boundary_points, "no boundary"),
        (lambda m: nearest_point(m, [0, np.inf, 0]), "finite coordinates"),
    ],
)
def test_refusals(place: Callable[[TriangleMesh], SurfacePoints], words: str) -> None:
    """Each place that is none has its own sentence."""
    with pytest.raises(FieldError, match=words):
        place(zoo_mesh("two_spheres"))


# -- vectors -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("robust", [False, True])
def test_vector_within_a_face_of_a_plane(robust: bool) -> None:
    """In the plane transport changes nothing, wherever the vector is given; its shares add up to it."""
    mesh = zoo_mesh("grid")
    vector = np.array([0.6, -0.8, 0.0])
    result = VectorHeat(mesh, "h2", robust=robust).from_sources(face_point(mesh, 20, INSIDE), vector)
    np.testing.assert_allclose(result["transported"], np.broadcast_to(vector, mesh.vertices.shape), atol=1e-12)
    np.testing.assert_allclose(mesh.vertex_areas @ result["diffused"], vector, atol=1e-12)


@pytest.mark.parametrize("connection", ["normals", "intrinsic"])
def test_vector_within_a_face_of_the_sphere(connection: str) -> None:
    """Transport along great circles from the point: the angle is right within a degree on average."""
    mesh = icosphere(4)
    found = []
    for face in (0, 900, 3000):
        point = face_point(mesh, face, INSIDE)
        vector = turned(source_frames(mesh, point), [70.0])
        X = VectorHeat(mesh, "h2", connection).from_sources(point, vector)["transported"]  # type: ignore[arg-type]
        np.testing.assert_allclose(np.linalg.norm(X, axis=1), 1, atol=1e-12)
        start = point.positions(mesh)[0] / np.linalg.norm(point.positions(mesh)[0])
        across = vector[0] - (vector[0] @ start) * start
        exact = across - (mesh.vertices @ across / (1 + mesh.vertices @ start))[:, None] * (mesh.vertices + start)
        angle = np.degrees(np.arctan2(np.linalg.norm(np.cross(X, exact), axis=1), np.einsum("vx,vx->v", X, exact)))
        found.append(angle[mesh.vertices @ start > -np.cos(np.radians(10))].mean())
    assert np.mean(found) < 0.25, found


def test_lengths_at_points_within_faces() -> None:
    """Lengths 1 and 3 within faces of opposite sides: each rules round itself."""
    mesh = icosphere(4)
    points = [nearest_point(mesh, [0.02, 0.97, 0.05]), nearest_point(mesh, [-0.03, -0.97, 0.01])]
    sources = concatenate(points)
    vectors = turned(source_frames(mesh, sources), [20.0, 70.0]) * [[1.0], [3.0]]
    length = np.linalg.norm(VectorHeat(mesh).from_sources(sources, vectors)["transported"], axis=1)
    height = mesh.vertices[:, 1]
    np.testing.assert_allclose(length[height > 0.5], 1, atol=1e-3)
    np.testing.assert_allclose(length[height < -0.5], 3, atol=1e-3)


def test_corner_of_a_face_is_the_vertex_for_vectors() -> None:
    """With all weight on a corner, the field of that vertex."""
    mesh = zoo_mesh("sphere")
    vertex = int(mesh.faces[8, 2])
    one = VectorHeat(mesh).from_vertices([vertex], [[0.3, 0.2, 0.9]])
    other = VectorHeat(mesh).from_sources(face_point(mesh, 8, [0, 0, 1]), [[0.3, 0.2, 0.9]])
    np.testing.assert_array_equal(one["diffused"], other["diffused"])


def test_shares_keep_their_length() -> None:
    """At each corner the share of a vector is as long as its weight says, however steep the corner's plane is."""
    mesh = zoo_mesh("tetrahedron")
    point = face_point(mesh, 2, INSIDE)
    vector = 2 * turned(source_frames(mesh, point), [25.0])
    shares = spread_to_corners(mesh, point, vector)
    np.testing.assert_allclose(np.abs(shares[mesh.faces[2]]), 2 * np.array(INSIDE), rtol=1e-14)


def test_vectors_within_faces_refused() -> None:
    """Normal to the face, or two vectors at one point."""
    mesh = zoo_mesh("sphere")
    point = face_point(mesh, 7)
    with pytest.raises(FieldError, match=r"source face 7 \(0.333333, .* is normal to the surface"):
        VectorHeat(mesh).from_sources(point, mesh.face_normals[[7]])
    with pytest.raises(FieldError, match=r"source face 7 .* is given twice, with different vectors"):
        VectorHeat(mesh).from_sources(concatenate([point, point]), [[1, 0, 0], [0, 1, 0]])
