"""Vector diffusion and transport: the 3n x 3n system, exact transport on the sphere, reach, blending, refusals."""

import numpy as np
import pytest
import scipy.sparse as sp
from conftest import needs_reference, reference, sheared, split_diagonals, zoo_mesh
from scipy.sparse.linalg import spsolve

from geomhw.errors import FieldError
from geomhw.geodesic.heat_method import HeatDistance
from geomhw.mesh.primitives import icosphere, strip, torus
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.connection_laplacian import connection_stiffness
from geomhw.options import Connection
from geomhw.transport.vector_heat import VectorHeat, random_tangent, tangent_at

CONNECTIONS: tuple[Connection, ...] = ("normals", "intrinsic")


def by_large_system(mesh: TriangleMesh, t: float, source: int, vector: np.ndarray) -> np.ndarray:
    """(M + tC) Y = Y0 as it stands in the design, 3n x 3n."""
    A = sp.diags_array(np.repeat(mesh.vertex_areas, 3)) + t * connection_stiffness(mesh)
    Y0 = np.zeros((mesh.n_vertices, 3))
    Y0[source] = vector
    return spsolve(A.tocsc(), Y0.ravel()).reshape(-1, 3)


def check_large_system(mesh: TriangleMesh, time: str) -> None:
    solver = VectorHeat(mesh, time)
    vector = random_tangent(mesh, 5, seed=0)
    expected = by_large_system(mesh, solver.time.t, 5, vector)
    Y = solver.from_vertices([5], [vector])["diffused"]
    size = np.abs(expected).max()
    np.testing.assert_allclose(Y, expected, rtol=0, atol=1e-9 * size)
    assert np.abs(np.einsum("vx,vx->v", Y, mesh.vertex_normals)).max() < 1e-10 * size


@pytest.mark.parametrize("time", ["0.01", "sqrt-h", "100"])
@pytest.mark.parametrize("name", ["crumpled_sphere", "crumpled_torus", "grid", "strip"])
def test_diffusion_is_the_large_system(name: str, time: str) -> None:
    """The complex system gives the 3n x 3n answer, tangent to rounding."""
    check_large_system(zoo_mesh(name), time)


@needs_reference
@pytest.mark.parametrize("time", ["0.01", "sqrt-h", "100"])
@pytest.mark.parametrize("name", ["moomoo.off", "spherers.off", "torus5k_surface.off", "spot.obj"])
def test_diffusion_on_real_meshes(name: str, time: str) -> None:
    """The same on real meshes."""
    from geomhw.io import read_mesh

    check_large_system(read_mesh(reference(f"meshes/closed/{name}")), time)


def along_great_circles(mesh: TriangleMesh, source: int, vector: np.ndarray) -> np.ndarray:
    """Exact transport on the unit sphere: the rotation that takes the source to each vertex; unit, tangent."""
    a, x = mesh.vertices[source], mesh.vertices
    axis, cosine = np.cross(a, x), x @ a
    moved = vector * cosine[:, None] + np.cross(axis, vector)
    moved += axis * (axis @ vector)[:, None] / np.maximum(1 + cosine, 1e-12)[:, None]
    moved -= np.einsum("vx,vx->v", moved, mesh.vertex_normals)[:, None] * mesh.vertex_normals
    return moved / np.linalg.norm(moved, axis=1)[:, None]


def mean_angle_error(level: int, connection: Connection) -> float:
    """Degrees, over vertices not within 10° of the antipode, averaged over sources of five and six neighbors."""
    mesh = icosphere(level)
    solver = VectorHeat(mesh, "h2", connection)
    errors = []
    for source in (0, 12, 42, 100, 300, 641):
        vector = random_tangent(mesh, source, seed=1)
        X = solver.from_vertices([source], [vector])["transported"]
        np.testing.assert_allclose(np.linalg.norm(X, axis=1), 1, atol=1e-12)
        exact = along_great_circles(mesh, source, vector)
        angle = np.arctan2(np.linalg.norm(np.cross(X, exact), axis=1), np.einsum("vx,vx->v", X, exact))
        kept = mesh.vertices @ mesh.vertices[source] > -np.cos(np.radians(10))
        errors.append(np.degrees(angle[kept]).mean())
    return float(np.mean(errors))


@pytest.mark.parametrize("connection", CONNECTIONS)
def test_transport_on_the_sphere(connection: Connection) -> None:
    """Mean angle error against transport along great circles on 642, 2,562 and 10,242 vertices."""
    errors = [mean_angle_error(level, connection) for level in (3, 4, 5)]
    assert all(error <= bound for error, bound in zip(errors, (0.3, 0.2, 0.12), strict=True)), errors


@pytest.mark.parametrize("connection", CONNECTIONS)
def test_reach(connection: Connection) -> None:
    """At the far end of a strip of 3000 cells the vector is still the one at the source, with its length."""
    mesh = strip(3000)
    X = VectorHeat(mesh, connection=connection).from_vertices([0], [[1.2, 1.6, 0.0]])["transported"]
    np.testing.assert_allclose(X, np.broadcast_to([1.2, 1.6, 0.0], X.shape), atol=1e-9)


def test_reach_with_several_lengths() -> None:
    """Far from two sources of different lengths, between and beyond: each end keeps its own."""
    mesh = strip(3000)
    ends = [int(mesh.vertices[:, 0].argmin()), int(mesh.vertices[:, 0].argmax())]
    X = VectorHeat(mesh).from_vertices(ends, [[1.0, 0.0, 0.0], [3.0, 0.0, 0.0]])["transported"]
    x = mesh.vertices[:, 0] - mesh.vertices[:, 0].min()
    np.testing.assert_allclose(X[x < 1450, 0], 1, atol=1e-6)
    np.testing.assert_allclose(X[x > 1550, 0], 3, atol=1e-6)


def test_two_sources_keep_their_own() -> None:
    """Lengths 1 and 3: each rules round itself, and no vector is shorter or longer than both."""
    mesh = icosphere(4)
    a, b = 0, int((mesh.vertices @ mesh.vertices[0]).argmin())
    vectors = [tangent_at(mesh, a, 20), 3 * tangent_at(mesh, b, 70)]
    X = VectorHeat(mesh).from_vertices([a, b], vectors)["transported"]
    length = np.linalg.norm(X, axis=1)
    assert length.min() >= 1 - 1e-12
    assert length.max() <= 3 + 1e-12
    height = mesh.vertices @ mesh.vertices[a]
    np.testing.assert_allclose(length[height > 0.5], 1, atol=1e-3)
    np.testing.assert_allclose(length[height < -0.5], 3, atol=1e-3)
    np.testing.assert_allclose(X[[a, b]], vectors, atol=1e-12)


def test_order_of_sources_does_not_matter() -> None:
    """Sources with their vectors in another order give the same field."""
    mesh = zoo_mesh("torus")
    v, w = tangent_at(mesh, 40, 10), 2 * tangent_at(mesh, 7, 200)
    solver = VectorHeat(mesh)
    first = solver.from_vertices([40, 7], [v, w])["transported"]
    np.testing.assert_array_equal(first, solver.from_vertices([7, 40], [w, v])["transported"])


def test_scalar_extension() -> None:
    """Values spread to where their source is nearest, and stay between the least and the largest."""
    mesh = icosphere(4)
    a, b = 0, int((mesh.vertices @ mesh.vertices[0]).argmin())
    values = VectorHeat(mesh).extend([b, a], [-2.0, 5.0])
    height = mesh.vertices @ mesh.vertices[a]
    np.testing.assert_allclose(values[height > 0.5], 5, atol=1e-2)
    np.testing.assert_allclose(values[height < -0.5], -2, atol=1e-2)
    assert values.min() >= -2
    assert values.max() <= 5
    assert np.isnan(VectorHeat(zoo_mesh("two_spheres")).extend([0], [1.0])[162:]).all()


@pytest.mark.parametrize("connection", CONNECTIONS)
@pytest.mark.parametrize("factor", [1e-6, 1e6])
def test_scaling_and_turning(connection: Connection, factor: float) -> None:
    """Transport turns with the mesh and does not feel its scale."""
    mesh = zoo_mesh("crumpled_torus")
    turn = np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]])
    vector = tangent_at(mesh, 3, 50)
    before = VectorHeat(mesh, "h2", connection).from_vertices([3], [vector])["transported"]
    moved = TriangleMesh(factor * mesh.vertices @ turn.T, mesh.faces)
    after = VectorHeat(moved, "h2", connection).from_vertices([3], [turn @ vector])["transported"]
    np.testing.assert_allclose(after, before @ turn.T, atol=1e-9)


def test_unreachable_is_zero() -> None:
    """Another component, and a vertex of no face, get no vector; the report counts the former."""
    result = VectorHeat(zoo_mesh("two_spheres")).from_vertices([0], [tangent_at(zoo_mesh("two_spheres"), 0, 0)])
    assert not result["transported"][162:].any()
    assert not result["diffused"][162:].any()
    np.testing.assert_allclose(np.linalg.norm(result["transported"][:162], axis=1), 1)
    assert result.report["unreachable_vertices"] == 162


def test_large_and_small_times() -> None:
    """For dt → 0 the transport tends to that along shortest paths; for large dt to the smoothest field, whatever dt."""
    mesh = torus(48, 24)
    vector = tangent_at(mesh, 12, 30)

    def field(dt: str) -> np.ndarray:
        return VectorHeat(mesh, dt).from_vertices([12], [vector])["transported"]

    def gap(a: np.ndarray, b: np.ndarray) -> float:
        return float(np.degrees(np.arccos(np.clip(np.einsum("vx,vx->v", a, b), -1, 1))).mean())

    assert 3 * gap(field("h2"), field("0.5*h2")) < gap(field("h2"), field("1e3"))
    assert gap(field("1e3"), field("1e4")) < 0.1


@pytest.mark.parametrize(
    ("sources", "vectors", "words"),
    [
        ([0, 0], [[1, 0, 0], [0, 1, 0]], "source 0 is given twice, with different vectors"),
        ([0], [[0, 0, 0]], "zero"),
        ([0], [[0, np.nan, 0]], "not finite"),
        ([0], [[np.inf, 0, 0]], "not finite"),
        ([0], [[0, 0, 2]], "normal to the surface"),
        ([0, 1], [[1, 0, 0]], "2 sources need as many vectors"),
        ([999], [[1, 0, 0]], "source 999 is not a vertex"),
    ],
)
def test_refusals(sources: list[int], vectors: list[list[float]], words: str) -> None:
    """Each bad vector or source has its own sentence."""
    with pytest.raises(FieldError, match=words):
        VectorHeat(zoo_mesh("grid")).from_vertices(sources, vectors)


@pytest.mark.parametrize("name", ["sphere", "torus"])
def test_robust_on_a_delaunay_mesh(name: str) -> None:
    """Where there is nothing to flip nor to mend, the robust answer differs by rounding."""
    mesh = zoo_mesh(name)
    vector = tangent_at(mesh, 5, 20)
    plain, robust = (VectorHeat(mesh, "h2", robust=r).from_vertices([5], [vector]) for r in (False, True))
    size = np.abs(plain["diffused"]).max()
    np.testing.assert_allclose(robust["diffused"], plain["diffused"], rtol=0, atol=1e-12 * size)


def test_robust_on_a_flat_mesh() -> None:
    """In the plane transport changes nothing, over slivers and faces without area too; |Y| is the heat itself."""
    for mesh in (split_diagonals(), sheared()):
        result = VectorHeat(mesh, "h2", robust=True).from_vertices([40], [[0.6, -0.8, 0]])
        np.testing.assert_allclose(
            result["transported"], np.broadcast_to([0.6, -0.8, 0], mesh.vertices.shape), atol=1e-9
        )
        heat = HeatDistance(mesh, "h2", robust=True).from_vertices([40])["heat"]
        np.testing.assert_allclose(result["diffused"] @ [0.6, -0.8, 0], heat, rtol=1e-6)


def test_robust_on_slivers() -> None:
    """On a sphere whose vertices crowd at the equator it halves the error of the plain method."""
    points = icosphere(3).vertices * [1, 1, 0.1]
    mesh = TriangleMesh(points / np.linalg.norm(points, axis=1)[:, None], icosphere(3).faces)
    gaps = [0.0, 0.0]
    for robust in (False, True):
        solver = VectorHeat(mesh, "h2", robust=robust)
        for source in (0, 30, 100, 200):
            vector = tangent_at(mesh, source, 30)
            moved = solver.from_vertices([source], [vector])["transported"]
            cosines = np.einsum("vx,vx->v", moved, along_great_circles(mesh, source, vector))
            gaps[robust] += np.arccos(np.clip(cosines, -1, 1)).mean()
    assert 2 * gaps[True] < gaps[False]


def test_robust_has_normals_only() -> None:
    """The intrinsic connection is refused on a robust triangulation."""
    with pytest.raises(FieldError, match=r"no intrinsic connection; use"):
        VectorHeat(zoo_mesh("sphere"), connection="intrinsic", robust=True)


def test_same_source_and_vector_twice() -> None:
    """Said twice, it counts once."""
    mesh = zoo_mesh("grid")
    once = VectorHeat(mesh).from_vertices([4], [[1, 2, 0]])["transported"]
    np.testing.assert_array_equal(VectorHeat(mesh).from_vertices([4, 4], [[1, 2, 0], [1, 2, 0]])["transported"], once)
