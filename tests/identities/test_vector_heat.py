"""Vector diffusion equals the 3n x 3n system; invariances of transport."""

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.sparse.linalg import spsolve

from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.connection_laplacian import connection_stiffness
from geomhw.options import Connection
from geomhw.transport.vector_heat import VectorHeat, random_tangent, tangent_at
from support.meshes import zoo_mesh
from support.reference import needs_reference, reference

CONNECTIONS: tuple[Connection, ...] = ("normals", "intrinsic")


def by_large_system(mesh: TriangleMesh, t: float, source: int, vector: np.ndarray) -> np.ndarray:
    """Solve (M + tC) Y = Y0, 3n × 3n."""
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
    """The complex system gives the solution of the 3n × 3n system, tangent to rounding."""
    check_large_system(zoo_mesh(name), time)


@needs_reference
@pytest.mark.parametrize("time", ["0.01", "sqrt-h", "100"])
@pytest.mark.parametrize("name", ["moomoo.off", "spherers.off", "torus5k_surface.off", "spot.obj"])
def test_diffusion_on_real_meshes(name: str, time: str) -> None:
    """The same holds on real meshes."""
    from geomhw.io import read_mesh

    check_large_system(read_mesh(reference(f"meshes/closed/{name}")), time)


def test_order_of_sources_does_not_matter() -> None:
    """The field does not depend on the order of sources."""
    mesh = zoo_mesh("torus")
    v, w = tangent_at(mesh, 40, 10), 2 * tangent_at(mesh, 7, 200)
    solver = VectorHeat(mesh)
    first = solver.from_vertices([40, 7], [v, w])["transported"]
    np.testing.assert_array_equal(first, solver.from_vertices([7, 40], [w, v])["transported"])


@pytest.mark.parametrize("connection", CONNECTIONS)
@pytest.mark.parametrize("factor", [1e-6, 1e6])
def test_scaling_and_turning(connection: Connection, factor: float) -> None:
    """Transport is invariant under scaling, and rotates with the mesh."""
    mesh = zoo_mesh("crumpled_torus")
    turn = np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]])
    vector = tangent_at(mesh, 3, 50)
    before = VectorHeat(mesh, "h2", connection).from_vertices([3], [vector])["transported"]
    moved = TriangleMesh(factor * mesh.vertices @ turn.T, mesh.faces)
    after = VectorHeat(moved, "h2", connection).from_vertices([3], [turn @ vector])["transported"]
    np.testing.assert_allclose(after, before @ turn.T, atol=1e-9)


def test_unreachable_is_zero() -> None:
    """Unreachable vertices have zero vectors; the report counts those with faces."""
    result = VectorHeat(zoo_mesh("two_spheres")).from_vertices([0], [tangent_at(zoo_mesh("two_spheres"), 0, 0)])
    assert not result["transported"][162:].any()
    assert not result["diffused"][162:].any()
    np.testing.assert_allclose(np.linalg.norm(result["transported"][:162], axis=1), 1)
    assert result.report["unreachable_vertices"] == 162


@pytest.mark.parametrize("name", ["sphere", "torus"])
def test_robust_on_a_delaunay_mesh(name: str) -> None:
    """On a Delaunay mesh, `robust` changes the field by rounding only."""
    mesh = zoo_mesh(name)
    vector = tangent_at(mesh, 5, 20)
    plain, robust = (VectorHeat(mesh, "h2", robust=r).from_vertices([5], [vector]) for r in (False, True))
    size = np.abs(plain["diffused"]).max()
    np.testing.assert_allclose(robust["diffused"], plain["diffused"], rtol=0, atol=1e-12 * size)


def test_same_source_and_vector_twice() -> None:
    """A repeated source with its vector counts once."""
    mesh = zoo_mesh("grid")
    once = VectorHeat(mesh).from_vertices([4], [[1, 2, 0]])["transported"]
    np.testing.assert_array_equal(VectorHeat(mesh).from_vertices([4, 4], [[1, 2, 0], [1, 2, 0]])["transported"], once)
