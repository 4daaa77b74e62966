"""Distances and vectors from points within faces, curves and boundaries, against exact solutions."""

from collections.abc import Callable

import numpy as np
import pytest

from geomhw.arrays import Floats
from geomhw.geodesic.heat_method import HeatDistance
from geomhw.geodesic.source_conditions import known_distances
from geomhw.mesh.closest_faces import closest_faces
from geomhw.mesh.named_points import face_point, vertex_points
from geomhw.mesh.nearest import nearest_point, nearest_points
from geomhw.mesh.primitives import grid, icosphere, strip
from geomhw.mesh.surface_points import SurfacePoints, concatenate
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.transport.source_vectors import source_frames, unit_vectors
from geomhw.transport.vector_heat import VectorHeat
from support.exact import INSIDE, errors
from support.meshes import sheared, split_diagonals, zoo_mesh


def great_circles(mesh: TriangleMesh, sources: SurfacePoints) -> np.ndarray:
    """Return exact distances on the unit sphere from the nearest source, projected to the sphere."""
    a = mesh.vertices
    ends = sources.positions(mesh)
    ends /= np.linalg.norm(ends, axis=1, keepdims=True)
    return np.min([np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), a @ b) for b in ends], axis=0)


def straight_lines(mesh: TriangleMesh, sources: SurfacePoints) -> np.ndarray:
    """Return exact distances on a convex flat mesh."""
    return np.min([np.linalg.norm(mesh.vertices - b, axis=1) for b in sources.positions(mesh)], axis=0)


@pytest.mark.parametrize(("time", "bounds"), [("h2", (0.075, 0.06, 0.18)), ("sqrt-h", (0.065, 0.06, 0.16))])
def test_distance_from_a_great_circle(time: str, bounds: tuple[float, ...]) -> None:
    """From all vertices of the equator, the distance is the latitude, at either diffusion time."""
    mesh = icosphere(4)
    latitude = np.abs(np.arcsin(mesh.vertices[:, 1]))
    equator = np.flatnonzero(latitude < 1e-9)
    assert len(equator) == 64
    latitude[equator] = 0
    found = errors(mesh, vertex_points(mesh, equator), latitude, time)
    assert all(error <= bound for error, bound in zip(found, bounds, strict=True)), found


def test_distance_from_the_end_of_a_band() -> None:
    """On a cylinder, the distance from one end is the height above it."""
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
    """From one end of a strip of 3000 cells, and from both, the distance is that along the strip."""
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
    """From a point within a face, mean errors near and far and the largest error are bounded in units of h."""
    mesh = build()
    for face in faces:
        for weights in (None, INSIDE, [0.05, 0.9, 0.05], [0.5, 0.5, 0.0]):
            point = face_point(mesh, face, weights)
            found = errors(mesh, point, exact(mesh, point))
            assert all(error <= bound for error, bound in zip(found, bounds, strict=True)), (face, weights, found)


def test_corners_are_exact() -> None:
    """Distances at the corners of a source's face, or of both faces at an edge, are the straight lines."""
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
    """In the plane, refined distances from points within faces are straight lines, even over degenerate faces."""
    flat = split_diagonals()
    for mesh, face in [(sheared(12, 20.0), 70), *[(flat, f) for f in (70, flat.degenerate_faces[40]) if robust]]:
        for weights in (INSIDE, [0.5, 0.0, 0.5]):
            point = face_point(mesh, int(face), weights)
            found = HeatDistance(mesh, "h2", robust=robust, refine=True).from_sources(point)["distance"]
            np.testing.assert_allclose(found, straight_lines(mesh, point), rtol=1e-9, atol=1e-14)


def test_refined_on_the_sphere() -> None:
    """On the sphere, refined distances have less than a tenth of the mean error."""
    mesh = icosphere(4)
    sources = concatenate([face_point(mesh, 900, INSIDE), vertex_points(mesh, [3]), face_point(mesh, 4000)])
    exact = great_circles(mesh, sources)
    plain, refined = (
        np.abs(HeatDistance(mesh, "h2", refine=refine).from_sources(sources)["distance"] - exact).mean()
        for refine in (False, True)
    )
    assert refined < 0.1 * plain


def test_corner_nearer_to_another_source() -> None:
    """A corner nearer to another source takes that distance, if the other source is a vertex beside it.

    If the other source lies two faces away, the error decreases by at least a fifth.
    """
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


def test_a_pile_of_sheets() -> None:
    """Of sheets stacked so that each corner is nearer to another sheet's source, one corner has a known distance."""
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


# -- places --------------------------------------------------------------------------------------------------------


def test_nearest_point_of_the_surface() -> None:
    """The nearest point of a sphere is found from points off a face, above an edge, at and above a vertex."""
    mesh = zoo_mesh("sphere")
    for face in (0, 300, 1279):
        for weights in (INSIDE, [0.9, 0.05, 0.05]):
            place = face_point(mesh, face, weights).positions(mesh)[0]
            for height in (0.0, 0.02, -0.01):
                (found,), (b,) = closest_faces(mesh, (place + height * mesh.face_normals[face])[None])
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


@pytest.mark.parametrize("name", ["crumpled_torus", "strip", "triangle", "two_spheres"])
def test_nearest_points_are_those_of_all_faces(name: str) -> None:
    """The tree of boxes finds what a search of all faces finds, near the surface and far from it."""
    mesh = zoo_mesh(name)
    rng = np.random.default_rng(0)
    places = (
        mesh.vertices.mean(axis=0) + np.ptp(mesh.vertices) * rng.normal(size=(12, 3)) * np.logspace(-1, 1, 12)[:, None]
    )
    found = nearest_points(mesh, places).positions(mesh)
    corners = mesh.vertices[mesh.faces]
    for place, position in zip(places, found, strict=True):
        best = min(np.linalg.norm(closest_in_triangle(place, triangle) - place) for triangle in corners)
        assert np.linalg.norm(position - place) == pytest.approx(best, rel=1e-12)


def closest_in_triangle(p: Floats, triangle: Floats) -> Floats:
    """Return the closest point of a triangle by quadratic minimization on its interior and its edges."""
    a, b, c = triangle
    system = np.stack([b - a, c - a], axis=1)
    s, t = np.linalg.lstsq(system, p - a, rcond=None)[0]
    ends = [(a, b), (b, c), (c, a)]
    points = [u + np.clip((p - u) @ (v - u) / ((v - u) @ (v - u)), 0, 1) * (v - u) for u, v in ends]
    points += [a + system @ [s, t]] if min(s, t, 1 - s - t) >= 0 else []
    return min(points, key=lambda point: float(np.linalg.norm(point - p)))


# -- vectors -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("robust", [False, True])
def test_vector_within_a_face_of_a_plane(robust: bool) -> None:
    """In the plane transport is the identity, from any source; the diffused field integrates to the vector."""
    mesh = zoo_mesh("grid")
    vector = np.array([0.6, -0.8, 0.0])
    result = VectorHeat(mesh, "h2", robust=robust).from_sources(face_point(mesh, 20, INSIDE), vector)
    np.testing.assert_allclose(result["transported"], np.broadcast_to(vector, mesh.vertices.shape), atol=1e-12)
    np.testing.assert_allclose(mesh.vertex_areas @ result["diffused"], vector, atol=1e-12)


@pytest.mark.parametrize("connection", ["normals", "intrinsic"])
def test_vector_within_a_face_of_the_sphere(connection: str) -> None:
    """From a point within a face, the mean angle to transport along great circles is below 0.25°."""
    mesh = icosphere(4)
    found = []
    for face in (0, 900, 3000):
        point = face_point(mesh, face, INSIDE)
        vector = unit_vectors(source_frames(mesh, point), [70.0])
        X = VectorHeat(mesh, "h2", connection).from_sources(point, vector)["transported"]  # type: ignore[arg-type]
        np.testing.assert_allclose(np.linalg.norm(X, axis=1), 1, atol=1e-12)
        start = point.positions(mesh)[0] / np.linalg.norm(point.positions(mesh)[0])
        across = vector[0] - (vector[0] @ start) * start
        exact = across - (mesh.vertices @ across / (1 + mesh.vertices @ start))[:, None] * (mesh.vertices + start)
        angle = np.degrees(np.arctan2(np.linalg.norm(np.cross(X, exact), axis=1), np.einsum("vx,vx->v", X, exact)))
        found.append(angle[mesh.vertices @ start > -np.cos(np.radians(10))].mean())
    assert np.mean(found) < 0.25, found


def test_lengths_at_points_within_faces() -> None:
    """Vectors of lengths 1 and 3 on opposite sides keep their lengths, each on its own side."""
    mesh = icosphere(4)
    points = [nearest_point(mesh, [0.02, 0.97, 0.05]), nearest_point(mesh, [-0.03, -0.97, 0.01])]
    sources = concatenate(points)
    vectors = unit_vectors(source_frames(mesh, sources), [20.0, 70.0]) * [[1.0], [3.0]]
    length = np.linalg.norm(VectorHeat(mesh).from_sources(sources, vectors)["transported"], axis=1)
    height = mesh.vertices[:, 1]
    np.testing.assert_allclose(length[height > 0.5], 1, atol=1e-3)
    np.testing.assert_allclose(length[height < -0.5], 3, atol=1e-3)
