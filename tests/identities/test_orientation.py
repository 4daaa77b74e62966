"""Orientation signs and covers: what does not depend on how faces are oriented."""

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.sparse.linalg import spsolve

from geomhw.errors import MeshError
from geomhw.flow.helmholtz import HelmholtzDecomposition
from geomhw.geodesic.heat_method import HeatDistance
from geomhw.intrinsic.intrinsic_mesh import IntrinsicMesh, mollified
from geomhw.mesh.curvature import angle_defects
from geomhw.mesh.named_points import face_point
from geomhw.mesh.orientation import orientation_cover, oriented, without_duplicate_faces
from geomhw.mesh.primitives import moebius_band
from geomhw.mesh.topology import pinched_vertices
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.connection_laplacian import complex_connection_stiffness, connection_stiffness
from geomhw.operators.mass import lumped_mass
from geomhw.transport.vector_heat import VectorHeat
from support.hostile import HOSTILE, doubled, hostile, hourglass, turned
from support.meshes import book, zoo_mesh


@pytest.fixture(params=["crumpled_sphere", "crumpled_torus", "grid", "two_spheres"])
def pair(request: pytest.FixtureRequest) -> tuple[TriangleMesh, TriangleMesh]:
    """A mesh, and the same with a third of its faces flipped."""
    mesh = zoo_mesh(request.param)
    return mesh, TriangleMesh(*turned((mesh.vertices, mesh.faces)))


@pytest.mark.parametrize("name", ["moebius", "klein"])
def test_cover_of_a_one_sided_surface(name: str) -> None:
    """The orientation cover is connected and oriented, with twice the Euler characteristic."""
    mesh = hostile(name)
    cover = orientation_cover(mesh)
    assert not mesh.is_orientable
    assert (cover.is_oriented, cover.is_edge_manifold, cover.n_components) == (True, True, 1)
    assert cover.euler_characteristic == 2 * mesh.euler_characteristic
    assert len(cover.boundary_loops) == 2 * len(mesh.boundary_loops)
    assert cover.genus == (1 if name == "klein" else 0)
    n = mesh.n_vertices
    np.testing.assert_array_equal(cover.vertices[:n], cover.vertices[n:])
    np.testing.assert_array_equal(np.sort(cover.faces[: mesh.n_faces] % n), np.sort(mesh.faces))
    np.testing.assert_allclose(cover.vertex_normals[:n], mesh.vertex_normals, atol=1e-14)
    np.testing.assert_allclose(cover.vertex_normals[n:], -mesh.vertex_normals, atol=1e-14)


def test_what_needs_no_cover(pair: tuple[TriangleMesh, TriangleMesh]) -> None:
    """An oriented mesh is its own cover; flipped faces are turned back; duplicate faces are dropped."""
    mesh, upset = pair
    assert orientation_cover(mesh) is oriented(mesh) is without_duplicate_faces(mesh) is mesh
    assert orientation_cover(upset).is_oriented
    assert ((oriented(upset).faces != upset.faces).any(axis=1) == (upset.faces != mesh.faces).any(axis=1)).all()
    again = TriangleMesh(*doubled((mesh.vertices, mesh.faces), slice(3, 30), flip=True))
    np.testing.assert_array_equal(without_duplicate_faces(again).faces, mesh.faces)
    np.testing.assert_array_equal(again.vertex_normals, mesh.vertex_normals)


def test_the_lesser_part_is_turned() -> None:
    """In each component the smaller part is flipped; of two equal parts the one without the lowest face."""
    mesh = hostile("two_ways")
    assert oriented(mesh) is mesh
    strip = TriangleMesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 3, 2]])
    assert oriented(strip).faces.tolist() == [[0, 1, 2], [0, 2, 3]]


def test_edge_signs() -> None:
    """With edge signs, normals at the ends of an edge of a one-sided surface agree; elsewhere signs are 1."""
    mesh = hostile("moebius")
    i, j = mesh.edges.T
    cosine = np.einsum("ex,ex->e", mesh.vertex_normals[i], mesh.vertex_normals[j])
    assert cosine.min() < -0.9
    assert (cosine * mesh.edge_signs).min() > 0.9
    assert (hostile("turned_torus").edge_signs == 1).all()


def test_vectors_do_not_depend_on_how_faces_are_turned(pair: tuple[TriangleMesh, TriangleMesh]) -> None:
    """Diffused and transported vectors do not depend on flipped faces, for both connections."""
    mesh, upset = pair
    vector = [[0.3, -0.5, 0.8]]
    for connection in ("normals", "intrinsic"):
        one, other = (VectorHeat(m, "h2", connection) for m in (mesh, upset))  # type: ignore[arg-type]
        for source in (7, 0):
            expected = one.from_sources(face_point(mesh, source), vector)
            found = other.from_sources(face_point(upset, source, [1 / 3] * 3), vector)
            np.testing.assert_allclose(found["diffused"], expected["diffused"], atol=1e-13)
        expected, found = one.from_vertices([7], vector), other.from_vertices([7], vector)
        np.testing.assert_allclose(found["diffused"], expected["diffused"], atol=1e-13)
        size = np.linalg.norm(expected["diffused"], axis=1)
        told = size > 1e-9 * size.max()  # where vectors cancel, opposite the source, no direction is left
        np.testing.assert_allclose(found["transported"][told], expected["transported"][told], atol=1e-6)


@pytest.mark.parametrize("name", ["moebius", "klein"])
def test_vectors_on_one_sided_surfaces(name: str) -> None:
    """On one-sided surfaces the system on the cover equals the 3n × 3n system."""
    mesh = hostile(name)
    heat = VectorHeat(mesh, "h2")
    start = np.zeros((mesh.n_vertices, 3))
    start[5] = np.cross(mesh.vertex_normals[5], [0.3, 0.5, 0.1])
    matrix = sp.kron(lumped_mass(mesh), sp.eye(3)) + heat.time.t * connection_stiffness(mesh)
    expected = spsolve(matrix.tocsc(), start.ravel()).reshape(-1, 3)
    np.testing.assert_allclose(heat.diffuse(start), expected, atol=1e-13 * np.abs(expected).max())
    with pytest.raises(MeshError, match="one-sided"):
        complex_connection_stiffness(mesh)


def test_a_turn_round_a_moebius_band_mirrors() -> None:
    """Round a Möbius band a vector along it returns unchanged, one across it reversed.

    Opposite the source, where both ways meet, the former add and the latter cancel.
    """
    mesh = moebius_band(60, 2, width=0.05)
    middle = np.flatnonzero(np.abs(np.linalg.norm(mesh.vertices[:, :2], axis=1) - 1) < 1e-9)
    source, along = int(middle[mesh.vertices[middle, 0].argmax()]), np.array([0.0, 1.0, 0.0])
    across = np.cross(mesh.vertex_normals[source], along)
    opposite = int(middle[mesh.vertices[middle, 0].argmin()])
    heat = VectorHeat(mesh, "1000*h2")
    sizes = [np.linalg.norm(heat.from_vertices([source], [v])["diffused"], axis=1) for v in (along, across)]
    assert sizes[0][opposite] > 100 * sizes[1][opposite]


@pytest.mark.parametrize("name", ["moebius", "klein"])
def test_distances_on_one_sided_surfaces(name: str) -> None:
    """Distances equal those on the cover from both lifts of the source."""
    mesh = hostile(name)
    cover = orientation_cover(mesh)
    n = mesh.n_vertices
    found = HeatDistance(mesh, refine=True).from_vertices([3])["distance"]
    expected = HeatDistance(cover, refine=True).from_vertices([3, 3 + n])["distance"]
    np.testing.assert_allclose(found, expected[:n], rtol=1e-9)
    np.testing.assert_allclose(found, expected[n:], rtol=1e-9)


def test_decomposition_does_not_depend_on_how_faces_are_turned(pair: tuple[TriangleMesh, TriangleMesh]) -> None:
    """All parts and the potential do not depend on flipped faces."""
    mesh, upset = pair
    V = np.random.default_rng(1).normal(size=(mesh.n_faces, 3))
    expected, found = HelmholtzDecomposition(mesh)(V), HelmholtzDecomposition(upset)(V)
    for name in ("curl_free", "coexact", "harmonic", "potential"):
        np.testing.assert_allclose(found[name], expected[name], atol=1e-11)
    assert found.mesh is upset


@pytest.mark.parametrize("name", ["bow_tie", "hourglass"])
def test_decomposition_where_only_a_vertex_joins(name: str) -> None:
    """Where components meet in one vertex only, nothing is harmonic."""
    mesh = hostile(name)
    parts = HelmholtzDecomposition(mesh)(np.random.default_rng(1).normal(size=(mesh.n_faces, 3)))
    np.testing.assert_allclose(parts["harmonic"], 0, atol=1e-12)


def test_curvature_of_what_is_no_fan() -> None:
    """The angle defect is zero at boundaries, non-manifold edges and pinched vertices; elsewhere Gauss-Bonnet holds."""
    pages = book(3)
    np.testing.assert_allclose(angle_defects(pages), 0, atol=1e-12)
    glass = TriangleMesh(*hourglass())
    defects = angle_defects(glass)
    assert defects[0] == 0
    assert pinched_vertices(glass.faces, glass.edge_table).tolist() == [0]
    # Each of two spheres lacks the defect at the common vertex.
    ball = zoo_mesh("sphere")
    assert angle_defects(ball).sum() == pytest.approx(4 * np.pi)
    assert defects.sum() < 8 * np.pi
    assert len(pinched_vertices(pages.faces, pages.edge_table)) == 0


def test_mollified_by_component() -> None:
    """A face of zero area lengthens edges of its own component only, in proportion to its size."""
    needle, ball = HOSTILE["needle_0"](), HOSTILE["inside_out"]()
    for scale in (1e-6, 1.0, 1e6):
        vertices = np.concatenate([needle[0] * scale, ball[0] + 9])
        mesh = TriangleMesh(vertices, np.concatenate([needle[1], ball[1] + 5]))
        grown, growth = mollified(IntrinsicMesh.of(mesh))
        alone = mollified(IntrinsicMesh.of(TriangleMesh(needle[0] * scale, needle[1])))[1]
        assert growth == pytest.approx(alone, rel=1e-12)
        here = mesh.edges[:, 0] < 5
        np.testing.assert_allclose(grown.lengths[here], mesh.edge_lengths[here] + growth)
        np.testing.assert_array_equal(grown.lengths[~here], mesh.edge_lengths[~here])
