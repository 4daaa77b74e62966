"""Sources of all kinds: equivalent specs, invariances, and bounds for any sources."""

import numpy as np
import pytest

from geomhw.geodesic.edge_paths import edge_path_distance
from geomhw.geodesic.heat_method import HeatDistance
from geomhw.geodesic.source_conditions import known_distances
from geomhw.mesh.named_points import extreme_vertex, face_point, vertex_points
from geomhw.mesh.nearest import nearest_point
from geomhw.mesh.primitives import grid, icosphere
from geomhw.mesh.surface_points import SurfacePoints, concatenate
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.transport.source_vectors import source_frames, spread_to_corners, unit_vectors
from geomhw.transport.vector_heat import VectorHeat
from support.exact import INSIDE
from support.meshes import sheared, two_spheres, zoo_mesh


def test_zero_at_all_sources_and_nowhere_else(mesh: TriangleMesh) -> None:
    """Distance is zero at every fifth vertex, the sources, and positive elsewhere."""
    wanted = np.setdiff1d(np.arange(0, mesh.n_vertices, 5), mesh.unreferenced_vertices)
    distance = HeatDistance(mesh, "h2").from_vertices(wanted)["distance"]
    assert np.flatnonzero(distance <= 0).tolist() == wanted.tolist()


def test_sources_are_equally_warm() -> None:
    """u is equal at all sources; (M + tS) u sums to their number and is zero elsewhere."""
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


def test_paths_along_edges_start_at_the_corners() -> None:
    """The edge path from several starts is the least of the single ones, and bounds the distance."""
    mesh = zoo_mesh("crumpled_torus")
    sources = concatenate([face_point(mesh, 17, INSIDE), vertex_points(mesh, [200])])
    known = known_distances(mesh, sources)
    first = np.flatnonzero(np.isfinite(known))
    path = edge_path_distance(mesh, first, known)
    single = [known[vertex] + edge_path_distance(mesh, np.array([vertex])) for vertex in first]
    np.testing.assert_allclose(path, np.min(single, axis=0), rtol=1e-14)
    assert (HeatDistance(mesh, "20*h2").from_sources(sources)["distance"] <= path).all()


def test_corner_is_the_vertex() -> None:
    """A point with all weight on one corner is that vertex, to the last bit."""
    mesh = zoo_mesh("sphere")
    vertex = HeatDistance(mesh).from_vertices([mesh.faces[17, 1]])
    for weights in ([0, 1, 0], [1e-12, 1 - 2e-12, 1e-12]):
        corner = HeatDistance(mesh).from_sources(face_point(mesh, 17, weights))
        assert corner.report["sources"] == [mesh.faces[17, 1]]
        np.testing.assert_array_equal(corner["distance"], vertex["distance"])


def test_edge_belongs_to_both_faces() -> None:
    """A point on an edge is the same source in either face."""
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
    """Return vertices and points within faces, two in one face, one on an edge."""
    return [
        vertex_points(mesh, [9]),
        face_point(mesh, 30),
        face_point(mesh, 30, INSIDE),
        vertex_points(mesh, [200, 3]),
        face_point(mesh, 90, [0.5, 0.0, 0.5]),
    ]


@pytest.mark.parametrize("robust", [False, True])
def test_order_and_repetition_do_not_matter(robust: bool) -> None:
    """Fields and report do not depend on the order and repetition of sources."""
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
    """Distances from mixed sources are invariant under renumbering, and scale with the mesh."""
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
    """On a Delaunay mesh, `robust` changes fields by rounding only, for points within faces too."""
    mesh = icosphere(3)
    sources = concatenate([face_point(mesh, 5, INSIDE), vertex_points(mesh, [100, 101])])
    one, other = (HeatDistance(mesh, "h2", robust=r, refine=False).from_sources(sources) for r in (False, True))
    for field in one.fields:
        size = np.abs(field.values).max()
        np.testing.assert_allclose(other[field.name], field.values, rtol=0, atol=1e-10 * size)


def test_two_components() -> None:
    """Distances on one component do not depend on a source on the other."""
    mesh = two_spheres()
    point, other = face_point(mesh, 5, INSIDE), face_point(mesh, 500)
    alone = HeatDistance(mesh, "h2").from_sources(point)["distance"]
    both = HeatDistance(mesh, "h2").from_sources(concatenate([point, other]))["distance"]
    np.testing.assert_allclose(both[:162], alone[:162], rtol=1e-12)
    assert np.isinf(alone[163:]).all()
    assert np.isfinite(both[163:]).all()


def test_faces_between_sources_have_no_direction() -> None:
    """A face whose corners are all sources has no direction."""
    mesh = zoo_mesh("sphere")
    wanted = np.unique(mesh.faces[np.isin(mesh.faces, mesh.faces[0]).any(axis=1)])
    lengths = np.linalg.norm(HeatDistance(mesh, "h2").from_vertices(wanted)["direction"], axis=1)
    level = np.isin(mesh.faces, wanted).all(axis=1)
    assert level.sum() >= 10
    assert not lengths[level].any()
    np.testing.assert_allclose(lengths[~level], 1, atol=1e-14)


def test_sources_of_another_sheet_do_not_count() -> None:
    """Of two sheets close to each other, known distances stay on the source's own sheet."""
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


def test_what_comes_out_below_zero_is_told() -> None:
    """On slivers, distances below zero are raised to the straight line, and counted in the report."""
    mesh = sheared(24, 20.0)
    result = HeatDistance(mesh, "h2").from_vertices([312, 313])
    raised = result.report["below_zero"]
    assert raised["vertices"] > 0
    assert raised["lowest"] < 0
    assert (np.delete(result["distance"], [312, 313]) > 0).all()
    assert "below_zero" not in HeatDistance(mesh, "h2", robust=True).from_vertices([312, 313]).report


def test_nearest_is_no_farther_than_any_sample() -> None:
    """No sample of the surface is nearer than the point found."""
    from geomhw.mesh.sampling import area_samples, points_on

    mesh = zoo_mesh("crumpled_torus")
    samples = points_on(mesh, *area_samples(mesh, 20_000))
    for point in np.random.default_rng(0).normal(size=(20, 3)):
        found = nearest_point(mesh, point).positions(mesh)[0]
        assert np.linalg.norm(found - point) <= np.linalg.norm(samples - point, axis=1).min() + 1e-12


def test_extreme_vertices() -> None:
    """The extreme vertex has the lowest index on a tie, and has faces."""
    square = grid(4, 4)
    assert [extreme_vertex(square, axis, sign) for axis, sign in ((0, 1), (0, -1), (1, 1), (1, -1))] == [4, 0, 20, 0]
    balls = two_spheres()
    assert balls.vertices[extreme_vertex(balls, 1, 1), 1] == pytest.approx(1, abs=0.1)


def test_weights_are_normalized() -> None:
    """Weights rounded to two digits are normalized."""
    np.testing.assert_allclose(face_point(zoo_mesh("sphere"), 3, [0.33, 0.33, 0.33]).weights, 1 / 3, rtol=1e-15)


def test_corner_of_a_face_is_the_vertex_for_vectors() -> None:
    """With all weight on a corner, the diffused field is that of the vertex."""
    mesh = zoo_mesh("sphere")
    vertex = int(mesh.faces[8, 2])
    one = VectorHeat(mesh).from_vertices([vertex], [[0.3, 0.2, 0.9]])
    other = VectorHeat(mesh).from_sources(face_point(mesh, 8, [0, 0, 1]), [[0.3, 0.2, 0.9]])
    np.testing.assert_array_equal(one["diffused"], other["diffused"])


def test_shares_keep_their_length() -> None:
    """The share of each corner has the length of its weight."""
    mesh = zoo_mesh("tetrahedron")
    point = face_point(mesh, 2, INSIDE)
    vector = 2 * unit_vectors(source_frames(mesh, point), [25.0])
    shares = spread_to_corners(mesh, point, vector)
    np.testing.assert_allclose(np.abs(shares[mesh.faces[2]]), 2 * np.array(INSIDE), rtol=1e-14)
