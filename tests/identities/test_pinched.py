"""Pinched vertices, where several fans of faces meet: results do not depend on the numbering."""

from collections.abc import Callable
from typing import get_args

import numpy as np
import pytest

from geomhw.errors import MeshError
from geomhw.flow.harmonic import harmonic_basis
from geomhw.flow.helmholtz import HelmholtzDecomposition
from geomhw.flow.tangent_fields import energy
from geomhw.io import read_mesh
from geomhw.mesh.cut import cut_at_pinched_vertices
from geomhw.mesh.named_points import face_point
from geomhw.mesh.primitives import grid
from geomhw.mesh.topology import pinched_vertices
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.options import Connection
from geomhw.transport.vector_heat import VectorHeat
from support.hostile import Arrays, arrays, far_away, flipped, pinched_meshes, renumbered, rotated_corners
from support.meshes import book, folded
from support.reference import needs_reference, reference

MESHES = pinched_meshes()
GENUS = {"pinched_torus": 1, "pinched_twice": 1}
LOOPS = {"bow_tie": [3, 3], "pinched_grid": [22], "pinched_bands": [8, 8, 8, 8]}
#: A sheet in the plane, and a vector at a vertex of it.
SHEET = TriangleMesh(grid(8, 4, 8.0, 4.0).vertices - [4.0, 0.0, 0.0], grid(8, 4).faces)
SOURCE = int(np.flatnonzero((SHEET.vertices == [2.0, 2.0, 0.0]).all(axis=1))[0])
VECTOR = np.array([[1.0, 2.0, 0.0]])
MOVES: dict[str, Callable[[Arrays], Arrays]] = {"flipped": flipped, "far away": far_away, "corners": rotated_corners}


def parts_of(mesh: Arrays, field: np.ndarray) -> tuple[dict[str, np.ndarray], dict[str, float]]:
    """Return the decomposition of a field, and the shares of the energy."""
    result = HelmholtzDecomposition(TriangleMesh(*mesh))(field)
    return {item.name: np.asarray(item.values) for item in result.fields}, result.report["energy_shares"]


def field_on(name: str) -> np.ndarray:
    return np.random.default_rng(1).normal(size=(len(MESHES[name][1]), 3))


@pytest.mark.parametrize("name", MESHES)
def test_helmholtz(name: str) -> None:
    """The parts are those of the mesh before renumbering, flipping and moving; they are orthogonal and sum to V."""
    mesh, V = MESHES[name], field_on(name)
    parts, shares = parts_of(mesh, V)
    assert sum(shares[part] for part in ("curl_free", "coexact", "harmonic")) == pytest.approx(1, abs=1e-10)
    given = TriangleMesh(*mesh)
    product = np.einsum("f,fx,fx", given.face_areas, parts["coexact"], parts["harmonic"])
    assert abs(product) < 1e-10 * energy(given, parts["field"])
    assert (shares["harmonic"] > 1e-6) == (name in GENUS)
    for seed in range(3):
        other, places, order = renumbered(mesh, seed)
        same = parts_of(other, V[order])[0]
        for part in ("curl_free", "coexact", "harmonic"):
            np.testing.assert_allclose(same[part], parts[part][order], atol=1e-9)
        np.testing.assert_allclose(same["potential"], parts["potential"][places], atol=1e-9)
    for move in MOVES.values():
        same = parts_of(move(mesh), V)[0]
        for part in ("curl_free", "coexact", "harmonic", "potential"):
            np.testing.assert_allclose(same[part], parts[part], atol=1e-6)


@pytest.mark.parametrize("name", MESHES)
def test_topology(name: str) -> None:
    """Genus and boundary loops are those of the mesh that is cut open, in any numbering."""
    for mesh in (MESHES[name], flipped(MESHES[name]), *(renumbered(MESHES[name], seed)[0] for seed in range(4))):
        pinched = TriangleMesh(*mesh)
        assert pinched.genus == GENUS.get(name, 0)
        assert sorted(map(len, pinched.boundary_loops)) == LOOPS.get(name, [])
        cut, original = cut_at_pinched_vertices(pinched)
        np.testing.assert_array_equal(original[cut.faces], pinched.faces)
        assert cut.genus == pinched.genus
        assert len(pinched_vertices(cut.faces, cut.edge_table)) == 0
        assert cut_at_pinched_vertices(cut)[0] is cut


def test_loops_of_non_manifold_meshes() -> None:
    """The boundary of a book of three pages is a chain a page, in any numbering."""
    mesh = arrays(book(3))
    for seed in range(6):
        other = TriangleMesh(*flipped(renumbered(mesh, seed)[0], seed))
        assert [len(loop) for loop in other.boundary_loops] == [19, 19, 19]


@pytest.mark.parametrize("name", MESHES)
def test_harmonic_basis(name: str) -> None:
    """There are two harmonic fields for each handle of the mesh that is cut open, without divergence."""
    mesh = TriangleMesh(*MESHES[name])
    basis = harmonic_basis(mesh)
    assert len(basis) == 2 * GENUS.get(name, 0)
    result = HelmholtzDecomposition(mesh)
    for h in basis:
        np.testing.assert_allclose(result(h)["curl_free"], 0, atol=1e-12)


def transported(mesh: Arrays, source: int, connection: Connection = "normals") -> tuple[np.ndarray, np.ndarray]:
    """Return the diffused and the transported vectors of (1, 2, 3) at a vertex."""
    result = VectorHeat(TriangleMesh(*mesh), "h2", connection).from_vertices([source], [[1.0, 2.0, 3.0]])
    return result["diffused"], result["transported"]


@pytest.mark.parametrize("connection", get_args(Connection))
@pytest.mark.parametrize("name", MESHES)
def test_transport(name: str, connection: Connection) -> None:
    """Diffused and transported vectors are those before renumbering, flipping and moving, from any vertex."""
    mesh = MESHES[name]
    for source in (0, len(mesh[0]) // 3):  # pinched and not
        given = transported(mesh, source, connection)
        for seed in range(2):
            other, places, _ = renumbered(mesh, seed)
            same = transported(other, int(np.argsort(places)[source]), connection)
            for vectors, before in zip(same, given, strict=True):
                np.testing.assert_allclose(vectors, before[places], atol=1e-9)
        for move in MOVES.values():
            for vectors, before in zip(transported(move(mesh), source, connection), given, strict=True):
                np.testing.assert_allclose(vectors, before, atol=1e-6)


def test_transport_does_not_pass() -> None:
    """Vectors stay on the part of their source; one at the pinched vertex starts in each, and values extend alike."""
    mesh = TriangleMesh(*MESHES["hourglass"])
    heat, upper, lower = VectorHeat(mesh), mesh.vertices[:, 2] > 1e-9, mesh.vertices[:, 2] < -1e-9
    source = int(mesh.vertices[:, 2].argmax())
    result = heat.from_vertices([source], [[1.0, 0.0, 0.0]])
    length = np.linalg.norm(result["transported"], axis=1)
    np.testing.assert_allclose(length[upper], 1)
    assert not result["transported"][lower].any()
    assert length[0] == pytest.approx(1)
    assert (result.report["unreachable_vertices"], result.report["non_manifold_vertices"]) == (lower.sum(), 1)
    both = heat.from_vertices([0], [[2.0, 0.0, 1.0]])
    np.testing.assert_allclose(np.linalg.norm(both["transported"], axis=1), 2)
    np.testing.assert_allclose(both["transported"][0], [2, 0, 0], atol=1e-9)
    values = heat.extend([source], [7.0])
    assert np.isnan(values[lower]).all()
    np.testing.assert_allclose(values[~lower], 7)


@pytest.mark.parametrize("robust", [False, True])
def test_transport_does_not_pass_a_fold(robust: bool) -> None:
    """Where a sheet is folded on itself vectors are zero, and no vector reaches the other side."""
    sheet = folded(SHEET)
    result = VectorHeat(sheet, robust=robust).from_vertices([SOURCE], VECTOR)
    x = SHEET.vertices[:, 0]
    np.testing.assert_allclose(result["transported"], VECTOR * (x > 0)[:, None], atol=1e-6)
    counts = result.report["vertices_without_normal"], result.report["unreachable_vertices"]
    assert counts == ((x == 0).sum(), (x < 0).sum())


def test_intrinsic_transport_passes_a_fold() -> None:
    """The connection of angles does not see a fold: vectors are those on the flat sheet, with the other side turned."""
    flat, over = (VectorHeat(sheet, connection="intrinsic") for sheet in (SHEET, folded(SHEET)))
    given, found = (method.from_vertices([SOURCE], VECTOR)["transported"] for method in (flat, over))
    x = SHEET.vertices[:, 0]
    np.testing.assert_allclose(found[x > 0], given[x > 0], atol=1e-9)
    np.testing.assert_allclose(found[x < 0], given[x < 0] * [-1, 1, 1], atol=1e-9)
    assert not found[x == 0].any()  # no plane is tangent there
    assert over.from_vertices([SOURCE], VECTOR).report["vertices_without_normal"] == (x == 0).sum()


def test_no_vector_starts_where_faces_cancel() -> None:
    """A source at a fold is refused."""
    sheet = TriangleMesh([[0, 0, 0], [0, 1, 0], [1, 0, 0], [1, 0, 0]], [[0, 2, 1], [1, 3, 0]])
    with pytest.raises(MeshError, match="vertex 1 has no normal"):
        VectorHeat(sheet).from_vertices([1], [[1.0, 0.0, 0.0]])


def test_transport_does_not_pass_an_edge_of_three_faces() -> None:
    """A vector in a page of a book is that of the page alone, flipped or not; the other pages have none."""
    mesh = book()
    page = np.arange(mesh.n_faces) < mesh.n_faces // 3
    source = int(mesh.faces[page].max())
    alone = VectorHeat(TriangleMesh(mesh.vertices, mesh.faces[page])).from_vertices([source], [[1.0, 2.0, 3.0]])
    for given in (mesh, TriangleMesh(*flipped(arrays(mesh)))):
        result = VectorHeat(given).from_vertices([source], [[1.0, 2.0, 3.0]])
        np.testing.assert_allclose(result["transported"], alone["transported"], atol=1e-12)
        assert result.report["non_manifold_edges"] == 6
        assert result.report["unreachable_vertices"] == mesh.n_vertices - len(np.unique(mesh.faces[page]))


def test_transport_from_within_a_face() -> None:
    """A vector in a face at a pinched vertex goes to the fan of that face only."""
    mesh = TriangleMesh(*MESHES["hourglass"])
    face = int(np.flatnonzero((mesh.faces == 0).any(axis=1))[0])
    result = VectorHeat(mesh).from_sources(face_point(mesh, face), [mesh.opposite_edges[face, 0]])
    side = mesh.vertices[:, 2] * mesh.face_centers[face, 2]
    assert (np.linalg.norm(result["transported"], axis=1) > 0).tolist() == (side >= 0).tolist()


@needs_reference
def test_touching_squares() -> None:
    """Two numberings of two squares that touch in a vertex have the same parts."""
    meshes = [read_mesh(reference(f"meshes/reported/30_pinched_bowtie_{k}.off")) for k in "ab"]
    fields = [np.load(reference(f"meshes/reported/30_pinched_bowtie_{k}_field.npy")) for k in "ab"]
    parts = [HelmholtzDecomposition(mesh)(field) for mesh, field in zip(meshes, fields, strict=True)]
    for name in ("curl_free", "coexact", "harmonic"):
        by_place = [part[name][np.lexsort(mesh.face_centers.T)] for mesh, part in zip(meshes, parts, strict=True)]
        np.testing.assert_allclose(by_place[0], by_place[1], atol=1e-12)
    assert [(mesh.genus, len(mesh.boundary_loops)) for mesh in meshes] == [(0, 2), (0, 2)]
