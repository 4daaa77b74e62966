"""Meshes cut along isolines and curves: the same surface, arrays and topology, in pieces."""

import numpy as np
import pytest

from geomhw.curves import SplitMesh, isolines, split_mesh, trace_polyline
from geomhw.errors import FieldError
from geomhw.mesh import TriangleMesh, grid, icosphere, insert_curves, torus
from geomhw.results import Field
from support.hostile import HOSTILE, hostile
from support.meshes import ZOO, book, two_spheres, zoo_mesh

#: Duplicate faces share their edges, so their copies are no further pieces; the others have no room between numbers.
LEFT_OUT = {"huge_150", "tiny_150", "tiny_310", "far", "far_lost", "one_point", "sheared_6"}
NAMES = [
    *(name for name in ZOO if name != "genus_two"),
    *(name for name in HOSTILE if name not in ZOO and name not in LEFT_OUT),
]


def mesh_of(name: str) -> TriangleMesh:
    """Return a mesh of the zoo or a hostile one."""
    return zoo_mesh(name) if name in ZOO else hostile(name)


def check(found: SplitMesh) -> None:
    """Areas and integrals add up, each face is covered by its parts, and joining the copies gives a closed-up mesh."""
    mesh = found.original
    area = mesh.face_areas.sum()
    report = found.report()
    assert sum(item["area"] for item in report["pieces"]) == pytest.approx(area, rel=1e-12)
    parts = np.bincount(found.parents, np.abs(np.linalg.det(found.corners)), mesh.n_faces)
    np.testing.assert_allclose(parts, 1, rtol=1e-12)
    assert (np.linalg.det(found.corners) > 0).all()
    u = np.random.default_rng(0).normal(size=mesh.n_vertices)
    (field,) = found.carried([Field("u", "vertex", u)])
    before = (mesh.face_areas * u[mesh.faces].mean(axis=1)).sum()
    after = found.mesh.face_areas * field.values[found.mesh.faces].mean(axis=1)
    assert after.sum() == pytest.approx(before, rel=1e-12, abs=1e-12 * area)
    # Joined again: the faces and vertices of the divided mesh, whose topology is that of the original.
    again = found.original_vertices[found.mesh.faces]
    np.testing.assert_array_equal(again, found.joined.faces)
    np.testing.assert_array_equal(found.mesh.vertices, found.joined.vertices[found.original_vertices])
    np.testing.assert_array_equal(found.joined.vertices[: mesh.n_vertices], mesh.vertices)
    chi = report["euler_characteristic"]
    assert chi["pieces"] == found.mesh.euler_characteristic
    if not len(mesh.duplicate_faces):
        cut = report["cut"]
        assert found.joined.euler_characteristic == chi["mesh"]
        assert chi["pieces"] == chi["mesh"] + cut["copied_vertices"] - cut["copied_edges"]
        assert len(found.joined.boundary_loops) == len(mesh.boundary_loops)


def test_edges_of_zero_length() -> None:
    """Isolines and shortest paths through faces of zero area cut the mesh like any others."""
    square = grid(5, 5)
    for seed in range(40):
        rng, vertices = np.random.default_rng(seed), square.vertices.copy()
        for one, other in rng.permutation(square.edges)[: 1 + seed % 4]:
            vertices[other] = vertices[one]
        mesh = TriangleMesh(vertices, square.faces)
        values = np.round(1.5 * rng.normal(size=mesh.n_vertices)) if seed % 2 else vertices[:, 0]
        lines = isolines(mesh, values, [values[rng.integers(mesh.n_vertices)]])
        path = trace_polyline(mesh, vertices[rng.choice(mesh.n_vertices, 4, replace=False)]).path
        for curves in (lines.curves, [(path.faces, path.weights)]):
            report = split_mesh(mesh, curves).report()
            chi, cut = report["euler_characteristic"], report["cut"]
            assert sum(item["area"] for item in report["pieces"]) == pytest.approx(mesh.face_areas.sum(), rel=1e-12)
            assert chi["pieces"] == chi["mesh"] + cut["copied_vertices"] - cut["copied_edges"]
        assert split_mesh(mesh, lines.curves).report()["cut"]["length"] == pytest.approx(lines.lengths.sum(), rel=1e-9)


@pytest.mark.parametrize("ties", [False, True])
@pytest.mark.parametrize("name", NAMES)
def test_cut_along_isolines(name: str, ties: bool) -> None:
    """No face is on both sides of a level, also where vertices, edges and faces are at it."""
    mesh = mesh_of(name)
    values = np.random.default_rng(2).normal(size=mesh.n_vertices)
    values = np.round(values) if ties else values
    levels = [0.0, 1.0] if ties else np.quantile(values[np.unique(mesh.faces)], [0.3, 0.6]).tolist()
    levels = levels[: 1 if mesh.n_faces > 300 else 2]
    lines = isolines(mesh, values, levels)
    found = split_mesh(mesh, lines.curves)
    check(found)
    assert found.report()["cut"]["length"] == pytest.approx(lines.lengths.sum(), rel=1e-9)
    if not len(mesh.duplicate_faces):
        (field,) = found.carried([Field("u", "vertex", values)])
        corners = field.values[found.mesh.faces]
        for level in levels:
            assert not ((corners.max(axis=1) > level + 1e-9) & (corners.min(axis=1) < level - 1e-9)).any()


def test_pieces_of_a_torus() -> None:
    """One meridian opens a torus to a cylinder, two cut it in two."""
    ring = torus(24, 12)
    lines = isolines(ring, ring.vertices[:, 0], [0.01])
    for count, pieces in ((1, 1), (2, 2)):
        found = split_mesh(ring, lines.curves[:count])
        check(found)
        assert (found.n_pieces, found.report()["euler_characteristic"]["pieces"]) == (pieces, 0)
        assert len(found.mesh.boundary_loops) == 2 * count


def test_crossing_curves() -> None:
    """Curves that cross each other within faces get a vertex there: four pieces of a square, seven with a star."""
    square = grid(3, 3, diagonal="uniform")
    lines = [
        trace_polyline(square, points).path for points in ([[0, 0.4, 0], [1, 0.55, 0]], [[0.45, 0, 0], [0.6, 1, 0]])
    ]
    found = split_mesh(square, [(path.faces, path.weights) for path in lines])
    check(found)
    assert found.n_pieces == 4
    turn = np.pi / 2 + 4 * np.pi / 5 * np.arange(6)
    star = np.stack([0.5 + 0.4 * np.cos(turn), 0.5 + 0.4 * np.sin(turn), 0 * turn], axis=1)
    path = trace_polyline(square, star).path
    found = split_mesh(square, [(path.faces, path.weights)])
    check(found)
    assert found.n_pieces == 7
    assert path.length == pytest.approx(5 * 0.8 * np.cos(np.pi / 10), rel=1e-9)


def test_random_curves_in_one_face() -> None:
    """Many segments that cross each other, in one face and in two."""
    rng = np.random.default_rng(5)
    for mesh in (TriangleMesh([[0, 0, 0], [1, 0, 0], [0.3, 1, 0]], [[0, 1, 2]]), grid(1, 1)):
        for _ in range(20):
            weights = rng.dirichlet([0.7] * 3, 12)
            face = np.zeros(12, dtype=int)
            found = insert_curves(mesh, [(face, weights)])
            assert found.mesh.euler_characteristic == 1
            assert found.mesh.face_areas.sum() == pytest.approx(mesh.face_areas.sum(), rel=1e-12)
            length = np.linalg.norm(np.diff(weights @ mesh.vertices[mesh.faces[0]], axis=0), axis=1).sum()
            chain = found.mesh.vertices[found.chains[0]]
            assert np.linalg.norm(np.diff(chain, axis=0), axis=1).sum() == pytest.approx(length, rel=1e-9)
            assert set(map(tuple, np.sort(np.stack([found.chains[0][:-1], found.chains[0][1:]]), axis=0).T)) <= set(
                map(tuple, found.mesh.edges.tolist())
            )


def test_open_curve_is_a_slit() -> None:
    """A curve with two ends separates nothing; its inner vertices are copied."""
    ball = icosphere(2)
    path = trace_polyline(ball, ball.vertices[[3, 50]]).path
    found = split_mesh(ball, [(path.faces, path.weights)])
    check(found)
    assert found.n_pieces == 1
    assert len(found.mesh.boundary_loops) == 1


def test_edges() -> None:
    """Cutting all edges leaves single faces; points that a curve puts on them are kept."""
    square = grid(2, 2)
    found = split_mesh(square, [], np.arange(square.n_edges))
    check(found)
    assert found.n_pieces == square.n_faces
    path = trace_polyline(square, [[0.1, 0.3, 0], [0.9, 0.3, 0]]).path
    both = split_mesh(square, [(path.faces, path.weights)], np.arange(square.n_edges))
    check(both)
    assert both.report()["cut"]["length"] == pytest.approx(square.edge_lengths.sum() + 0.8)


def test_kinds_of_arrays() -> None:
    """Numbers are interpolated, labels take the nearest corner, faces copy, and the level is exact on the cut."""
    ball = icosphere(3)
    z = ball.vertices[:, 2]
    fields = [
        Field("z", "vertex", z),
        Field("place", "vertex", ball.vertices),
        Field("label", "vertex", (z > 0.5).astype(np.int32) * 7),
        Field("face", "face", np.arange(ball.n_faces)),
    ]
    found = split_mesh(ball, isolines(ball, z, [0.3]).curves)
    result = found.result(fields, {"z": 0.3})
    np.testing.assert_allclose(result["place"], found.mesh.vertices, atol=1e-15)
    assert set(np.unique(result["label"])) == {0, 7}
    np.testing.assert_array_equal(result["face"], found.parents)
    on_cut = np.unique(found.joined.edges[found.cut_edges])
    assert (np.asarray(result["z"])[np.isin(found.original_vertices, on_cut)] == 0.3).all()
    parts = [found.piece(k, result) for k in range(found.n_pieces)]
    assert sum(part.mesh.n_faces for part in parts) == found.mesh.n_faces
    assert [part.mesh.euler_characteristic for part in parts] == [1, 1]
    assert [len(part.mesh.unreferenced_vertices) for part in parts] == [0, 0]
    np.testing.assert_allclose(parts[1]["place"], parts[1].mesh.vertices, atol=1e-15)


def test_infinite_values_stay_where_they_are() -> None:
    """New vertices take values from the ends of their edge only."""
    square = grid(8, 8)
    values = square.vertices[:, 1].copy()
    values[square.vertices[:, 0] > 0.7] = np.inf
    found = split_mesh(square, isolines(square, values, [0.4]).curves)
    result = found.result([Field("u", "vertex", values)], {"u": 0.4})
    assert not np.isnan(result["u"]).any()
    finite = np.isfinite(result["u"])
    np.testing.assert_allclose(np.asarray(result["u"])[finite], found.mesh.vertices[finite, 1], atol=1e-12)


def test_traced_polylines() -> None:
    """Points beside the surface move to it; far points, one point, and several components are errors."""
    ball = icosphere(3)
    turn = np.linspace(0, 2 * np.pi, 200)
    ring = np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)
    ring[-1] = ring[0]
    traced = trace_polyline(ball, ring)
    assert traced.closed
    assert traced.path.length == pytest.approx(2 * np.pi, rel=0.01)
    assert traced.distance < 0.02
    for points, words in (
        (3 * ring, "from the surface"),
        (ring[:1], "one point"),
        (ring[[0, 0]], "one point"),
        (np.empty((0, 3)), "no point"),
        (np.where(ring > 0.999, np.nan, ring), r"point 0 of the ring .*finite"),
        (1e12 * ring, r"point \d+ of the ring is 1e\+12 from the surface"),
        (1.7e308 * ring, "from the surface"),
    ):
        with pytest.raises(FieldError, match=words):
            trace_polyline(ball, points, "the ring")
    balls = two_spheres()
    with pytest.raises(FieldError, match="different components"):
        trace_polyline(balls, [[1, 0, 0], [3.5, 0, 0]])


def test_curve_across_an_edge_of_three_faces() -> None:
    """A curve from one page of a book to another crosses the spine; the cut leaves the third page whole."""
    pages = book(3)
    path = trace_polyline(pages, [[0.5, 0, 0.4], [-0.25, 0.433, 0.4]]).path
    found = split_mesh(pages, [(path.faces, path.weights)])
    check(found)
    assert found.n_pieces == 1
