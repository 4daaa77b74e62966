"""Identities of geometry and topology, on every mesh of the zoo."""

import pickle

import numpy as np
import pytest

from geomhw.arrays import pieces, scatter_add
from geomhw.flow.passive_scalar import OneRings
from geomhw.geodesic.heat_method import HeatDistance
from geomhw.mesh.geometry import corner_sum
from geomhw.mesh.primitives import icosphere
from geomhw.mesh.topology import unique_edges
from geomhw.mesh.triangle_mesh import TriangleMesh
from support.meshes import CLOSED, zoo_mesh

BALL = icosphere(2)


def test_pickles() -> None:
    """A pickle holds vertices and faces only; its mesh has the same derived arrays."""
    mesh = icosphere(3)
    small = len(pickle.dumps(mesh))
    assert mesh.vertex_normals.any()
    copy = pickle.loads(pickle.dumps(mesh))
    assert len(pickle.dumps(mesh)) == small
    assert np.array_equal(copy.vertex_normals, mesh.vertex_normals)
    assert not copy.vertices.flags.writeable


def test_gauss_bonnet(mesh: TriangleMesh) -> None:
    """Angle defects, with geodesic curvature on the boundary, sum to 2π χ."""
    angle_sums = np.bincount(mesh.faces.ravel(), weights=mesh.angles.ravel(), minlength=mesh.n_vertices)
    full = np.full(mesh.n_vertices, 2 * np.pi)
    full[mesh.boundary_vertices] = np.pi
    full[mesh.unreferenced_vertices] = 0
    assert (full - angle_sums).sum() == pytest.approx(2 * np.pi * mesh.euler_characteristic, abs=1e-9)


def test_area_by_three_routes(mesh: TriangleMesh) -> None:
    """Areas of faces, of vertices and ½ |e1

    e2| sin α agree.
    """
    lengths = np.linalg.norm(mesh.opposite_edges, axis=2)
    by_sine = np.roll(lengths, 1, axis=1) * np.roll(lengths, -1, axis=1) * np.sin(mesh.angles) / 2
    np.testing.assert_allclose(by_sine, np.repeat(mesh.face_areas[:, None], 3, axis=1), rtol=1e-12)
    assert mesh.vertex_areas.sum() == pytest.approx(mesh.face_areas.sum(), rel=1e-13)


def test_face_normals_and_angles(mesh: TriangleMesh) -> None:
    """Normals are unit and perpendicular to edges; angles sum to π; cotangents match the angles."""
    np.testing.assert_allclose(np.linalg.norm(mesh.face_normals, axis=1), 1, atol=1e-14)
    across = np.einsum("fx,fkx->fk", mesh.face_normals, mesh.opposite_edges)
    np.testing.assert_allclose(across, 0, atol=1e-13 * mesh.edge_lengths.max())
    np.testing.assert_allclose(mesh.angles.sum(axis=1), np.pi, atol=1e-13)
    np.testing.assert_allclose(mesh.cotangents * np.sin(mesh.angles), np.cos(mesh.angles), atol=1e-13)


def test_tangent_frames(mesh: TriangleMesh) -> None:
    """Frames are orthonormal and right-handed about the vertex normal."""
    e1, e2 = mesh.tangent_frames.transpose(1, 0, 2)
    on_surface = np.setdiff1d(np.arange(mesh.n_vertices), mesh.unreferenced_vertices)
    np.testing.assert_allclose(np.cross(e1, e2)[on_surface], mesh.vertex_normals[on_surface], atol=1e-14)
    np.testing.assert_allclose(np.linalg.norm(e1, axis=1), 1, atol=1e-14)


def test_edges_count_their_faces(mesh: TriangleMesh) -> None:
    """Each face has three edges; the edge opposite a corner does not contain it."""
    table = mesh.edge_table
    assert table.face_counts.sum() == 3 * mesh.n_faces
    ends = mesh.edges[table.of_faces]
    assert not (ends == mesh.faces[:, :, None]).any()
    others = np.stack([np.roll(mesh.faces, -1, axis=1), np.roll(mesh.faces, -2, axis=1)], axis=2)
    assert np.array_equal(ends, np.sort(others, axis=2))


def test_edges_of_a_soup() -> None:
    """Edges of random faces equal those of a comparison sort, also with thousands at one vertex."""
    rng = np.random.default_rng(0)
    faces = np.array([rng.permutation(60)[:3] for _ in range(4000)], dtype=np.int32)
    faces[::2, 1] = 60
    edges = unique_edges(faces)
    pairs = np.stack([np.roll(faces, -1, axis=1), np.roll(faces, -2, axis=1)], axis=2).reshape(-1, 2)
    expected, which, counts = np.unique(np.sort(pairs), axis=0, return_inverse=True, return_counts=True)
    np.testing.assert_array_equal(edges.vertices, expected)
    np.testing.assert_array_equal(edges.of_faces.ravel(), which.ravel())
    np.testing.assert_array_equal(edges.face_counts, counts)
    upward = np.where(pairs[:, 0] < pairs[:, 1], 1, -1)
    np.testing.assert_array_equal(edges.orientation_sums, np.bincount(which.ravel(), upward))


def test_sums_at_corners() -> None:
    """Values per face sum at the vertices as the same values given per corner."""
    mesh = icosphere(2)
    values = np.random.default_rng(2).normal(size=mesh.n_faces)
    expected = np.bincount(mesh.faces.ravel(), np.repeat(values, 3))
    for given in (values, values[:, None], np.repeat(values[:, None], 3, axis=1)):
        np.testing.assert_allclose(corner_sum(given, mesh.faces, mesh.n_vertices), expected, rtol=0, atol=1e-13)


def test_sums_at_places() -> None:
    """`scatter_add` equals `bincount` to the last bit, also for complex values."""
    rng = np.random.default_rng(1)
    places, values = rng.integers(0, 50, 1000).astype(np.int32), rng.normal(size=1000)
    np.testing.assert_array_equal(scatter_add(values, places, 60), np.bincount(places, values, 60))
    both = scatter_add(values + 2j * values, places, 60)
    np.testing.assert_array_equal(both.imag, 2 * both.real)


def test_pieces_are_all() -> None:
    """Pieces cover a range once, in order."""
    whole = np.arange(100_000)
    np.testing.assert_array_equal(np.concatenate([whole[piece] for piece in pieces(len(whole))]), whole)
    assert len(list(pieces(len(whole)))) > 3
    assert list(pieces(0)) == []


def test_work_in_pieces(monkeypatch: pytest.MonkeyPatch) -> None:
    """Results do not depend on the size of the pieces, to the last bit."""
    answers = []
    for size in (7, 100, 1 << 20):
        monkeypatch.setattr("geomhw.arrays.PIECE", size)
        mesh = TriangleMesh(*(np.array(part) for part in (BALL.vertices, BALL.faces)))
        fields = HeatDistance(mesh).from_vertices([3]).fields
        answers.append([mesh.edge_lengths, mesh.cotangents, mesh.opposite_edges, *(field.values for field in fields)])
    for other in answers[:2]:
        for one, expected in zip(other, answers[2], strict=True):
            np.testing.assert_array_equal(one, expected)


@pytest.mark.parametrize("name", CLOSED)
def test_genus(name: str) -> None:
    """Closed meshes have the genus that they are built with."""
    mesh = zoo_mesh(name)
    assert mesh.is_closed
    assert mesh.boundary_loops == []
    assert mesh.genus == CLOSED[name]
    assert mesh.euler_characteristic == 2 - 2 * CLOSED[name]


def test_components_and_unreferenced() -> None:
    """Two spheres have two components; the vertex without faces is separate."""
    mesh = zoo_mesh("two_spheres")
    assert mesh.n_components == 2
    assert mesh.unreferenced_vertices.tolist() == [162]
    assert mesh.genus == 0
    assert len(np.unique(mesh.components)) == 3


def test_boundary_loops_follow_their_faces() -> None:
    """The outer loop is counterclockwise, the inner one clockwise; each boundary vertex appears once."""
    mesh = zoo_mesh("annulus")
    assert sorted(len(loop) for loop in mesh.boundary_loops) == [12, 36]
    assert np.array_equal(np.sort(np.concatenate(mesh.boundary_loops)), mesh.boundary_vertices)
    for loop in mesh.boundary_loops:
        x, y = mesh.vertices[loop, :2].T
        signed = (x * np.roll(y, -1) - y * np.roll(x, -1)).sum() / 2
        assert signed > 0 if len(loop) == 36 else signed < 0


def test_loops_that_touch_are_two() -> None:
    """Two triangles with one common vertex have two boundary loops."""
    mesh = TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]], [[0, 1, 2], [0, 3, 4]])
    assert [len(loop) for loop in mesh.boundary_loops] == [3, 3]


def test_moebius_band_is_not_orientable() -> None:
    """A Möbius band is one-sided, with one boundary loop and no genus."""
    n = 12
    angle = np.linspace(0, 2 * np.pi, n, endpoint=False)
    half = np.stack([np.cos(angle / 2) * np.cos(angle), np.cos(angle / 2) * np.sin(angle), np.sin(angle / 2)], axis=1)
    middle = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    vertices = np.concatenate([middle - 0.3 * half, middle + 0.3 * half])
    i = np.arange(n)
    low, high = np.append(i[1:], n), np.append(i[1:] + n, 0)
    faces = np.concatenate([np.stack([i, low, high], axis=1), np.stack([i, high, i + n], axis=1)])
    mesh = TriangleMesh(vertices, faces)
    assert not mesh.is_orientable
    assert mesh.genus is None
    assert [sorted(loop.tolist()) for loop in mesh.boundary_loops] == [list(range(2 * n))]


def test_flipped_face_is_orientable_but_not_oriented() -> None:
    """A flipped face breaks the orientation, but not the orientability."""
    ball = icosphere(1)
    faces = ball.faces.copy()
    faces[3] = faces[3, ::-1]
    mesh = TriangleMesh(ball.vertices, faces)
    assert not mesh.is_oriented
    assert mesh.is_orientable
    assert mesh.genus == 0


@pytest.mark.parametrize("factor", [1e-6, 1e6])
def test_degeneracy_is_scale_free(factor: float) -> None:
    """A face of height 1e-9 is not degenerate, one of zero area is, at any scale."""
    thin = np.array([[0, 0, 0], [1, 0, 0], [0.5, 1e-9, 0]])
    assert TriangleMesh(thin * factor, [[0, 1, 2]]).degenerate_faces.size == 0
    flat = np.array([[0, 0, 0], [1, 0, 0], [0.5, 0, 0]])
    assert TriangleMesh(flat * factor + 0.1 * factor, [[0, 1, 2]]).degenerate_faces.tolist() == [0]
    rounded = TriangleMesh((np.outer([0, 1, 0.3], [0.3, 0.7, 0.1]) + 0.1) * factor, [[0, 1, 2]])
    assert rounded.face_areas[0] > 0
    assert rounded.degenerate_faces.tolist() == [0]


def test_one_rings(mesh: TriangleMesh) -> None:
    """The largest value of each vertex neighborhood equals that by the adjacency matrix."""
    values = np.random.default_rng(2).normal(size=(mesh.n_vertices, 2))
    linked = np.eye(mesh.n_vertices, dtype=bool)
    linked[mesh.edges[:, 0], mesh.edges[:, 1]] = linked[mesh.edges[:, 1], mesh.edges[:, 0]] = True
    expected = np.where(linked[:, :, None], values[None], -np.inf).max(axis=1)
    rings = OneRings(mesh.edges, mesh.n_vertices)
    np.testing.assert_array_equal(rings.largest(values), expected)
    np.testing.assert_array_equal(rings.largest(values[:, 1]), expected[:, 1])
