"""Identities of the heat method: the systems it solves, invariances, and equal ways to one answer."""

from pathlib import Path

import numpy as np
import pytest

from geomhw.geodesic.auto_time import time_step
from geomhw.geodesic.edge_paths import edge_path_distance
from geomhw.geodesic.heat_method import HeatDistance, heat_distance
from geomhw.geodesic.heat_step import HeatStep
from geomhw.mesh.named_points import default_source
from geomhw.mesh.primitives import icosphere, strip
from geomhw.mesh.triangle_mesh import TriangleMesh
from support.meshes import grid_of, sheared, zoo_mesh
from support.reference import needs_reference, reference


@needs_reference
@pytest.mark.parametrize("time", ["sqrt-h", "h2"])
@pytest.mark.parametrize(
    "name", ["moomoo.off", "spot.obj", "kitten.obj", "3holes.off", "eight.off", "fandisk.obj", "armadillo.obj"]
)
def test_real_meshes(name: str, time: str) -> None:
    """Distances are finite, and zero only at the source."""
    from geomhw.io import read_mesh

    distance = heat_distance(read_mesh(reference(f"meshes/closed/{name}")), [0], time)
    assert np.isfinite(distance).all()
    assert np.flatnonzero(distance <= 0).tolist() == [0]


def test_heat_step_is_solved(mesh: TriangleMesh) -> None:
    """(M + tS) u = δ, u integrates to 1, and directions are unit vectors along -∇u."""
    from geomhw.operators.gradient import gradient_of
    from geomhw.operators.laplacian import stiffness
    from geomhw.operators.mass import lumped_mass

    solver = HeatDistance(mesh, "h2")
    result = solver.from_vertices([0])
    u = result["heat"]
    residual = lumped_mass(mesh) @ u + solver.time.t * (stiffness(mesh) @ u)
    residual[0] -= 1
    assert np.abs(residual).max() < 1e-12
    assert (lumped_mass(mesh) @ u).sum() == pytest.approx(1, rel=1e-12)
    gradients = gradient_of(mesh, u)
    np.testing.assert_allclose(result["heat_gradient"], gradients, rtol=0, atol=1e-12 * np.abs(gradients).max())
    reached = np.isin(mesh.components, mesh.components[0])[mesh.faces[:, 0]]
    lengths = np.linalg.norm(result["direction"], axis=1)
    flat = np.ptp(u[mesh.faces], axis=1) <= 1e-12 * u[mesh.faces].max(axis=1)  # no way is down: no direction
    np.testing.assert_allclose(lengths, reached & ~flat, atol=1e-14)
    assert (flat & reached).sum() <= (mesh.n_vertices == 4)
    along = np.einsum("fx,fx->f", result["direction"], result["heat_gradient"])
    np.testing.assert_allclose(
        along, -np.linalg.norm(result["heat_gradient"], axis=1), atol=1e-12 * np.abs(along).max()
    )


def test_tetrahedron_is_symmetric() -> None:
    """On a tetrahedron all other vertices are equally far; the opposite face has no direction."""
    distance = heat_distance(zoo_mesh("tetrahedron"), [0], "h2")
    np.testing.assert_allclose(distance[1:], distance[1], rtol=1e-12)


@pytest.mark.parametrize("factor", [1e-6, 1e6])
def test_scaling_and_moving(factor: float) -> None:
    """Distance scales with the mesh, and is invariant under translation."""
    mesh = zoo_mesh("crumpled_torus")
    before = heat_distance(mesh, [3], "h2")
    scaled = heat_distance(TriangleMesh(mesh.vertices * factor, mesh.faces), [3], "h2")
    np.testing.assert_allclose(scaled, before * factor, rtol=1e-9)
    moved = heat_distance(TriangleMesh(mesh.vertices + np.array([1e3, -2e3, 500]), mesh.faces), [3], "h2")
    np.testing.assert_allclose(moved, before, rtol=0, atol=1e-9 * before.max())


def test_renumbering() -> None:
    """Distance is invariant under renumbering of vertices and faces."""
    mesh = zoo_mesh("crumpled_torus")
    rng = np.random.default_rng(1)
    order = rng.permutation(mesh.n_vertices)
    name = np.argsort(order)
    faces = name[mesh.faces[rng.permutation(mesh.n_faces)]]
    shuffled = heat_distance(TriangleMesh(mesh.vertices[order], faces), [int(name[3])], "h2")
    np.testing.assert_allclose(shuffled, heat_distance(mesh, [3], "h2")[order], rtol=0, atol=1e-11)


def test_beyond_reach_agrees_with_within() -> None:
    """Where doubles suffice, the scaled system gives the same heat."""
    from geomhw.operators.laplacian import stiffness
    from geomhw.operators.mass import lumped_mass
    from geomhw.solvers import log_scaled
    from geomhw.solvers.direct import DirectSolver

    mesh = strip(300)
    t = mesh.mean_edge_length**2
    A = (lumped_mass(mesh) + t * stiffness(mesh)).tocsr()
    rhs = np.zeros(mesh.n_vertices)
    rhs[0] = 1
    plain = DirectSolver(A)(rhs)
    arrival = edge_path_distance(mesh, np.array([0])) / np.sqrt(t)
    forgetful = np.where(plain > 1e-20, plain, 0.0)  # as if doubles ended at 1e-20
    old, log_scaled.REACH = log_scaled.REACH, 40.0
    try:
        far = log_scaled.solve_decaying(A, rhs, forgetful, arrival)
    finally:
        log_scaled.REACH = old
    np.testing.assert_allclose(far.log, np.log(plain), atol=1e-9)


def test_repeated_sources_count_once() -> None:
    """A repeated source counts once."""
    mesh = zoo_mesh("sphere")
    np.testing.assert_array_equal(heat_distance(mesh, [5, 5]), heat_distance(mesh, [5]))


def test_unreachable_is_infinite() -> None:
    """Unreachable vertices have distance inf; the report counts those with faces."""
    mesh = zoo_mesh("two_spheres")
    result = HeatDistance(mesh).from_vertices([0])
    assert np.isfinite(result["distance"][:162]).all()
    assert np.isinf(result["distance"][162:]).all()
    assert result.report["unreachable_vertices"] == 162
    both = heat_distance(mesh, [0, 200])
    assert np.flatnonzero(np.isinf(both)).tolist() == [162]
    np.testing.assert_allclose(both[:162], result["distance"][:162], rtol=1e-12)


def test_solver_answers_many() -> None:
    """One solver answers many sources with the same bits as single ones."""
    mesh = zoo_mesh("torus")
    solver = HeatDistance(mesh)
    for source in (0, 17, 200):
        np.testing.assert_array_equal(solver.from_vertices([source])["distance"], heat_distance(mesh, [source]))


def test_times_as_they_are_written() -> None:
    """√h, multiples of h² and numbers give those times, on grids of several mean edge lengths."""
    assert time_step("h2", grid_of(3.0)).t == pytest.approx(9)
    assert time_step("sqrt-h", grid_of(5.0)).t == pytest.approx(np.sqrt(5))
    assert time_step("0.5*h2", grid_of(3.0)).t == pytest.approx(4.5)
    assert time_step(0.25, grid_of(3.0)).t == 0.25
    assert time_step("1e-3", grid_of(3.0)).t == 1e-3


def test_robust_on_a_delaunay_mesh() -> None:
    """On a Delaunay mesh, `robust` changes fields by rounding only."""
    mesh = icosphere(4)
    plain, robust = HeatDistance(mesh, "h2"), HeatDistance(mesh, "h2", robust=True, refine=False)
    for sources in ([3], [3, 900]):
        one, other = plain.from_vertices(sources), robust.from_vertices(sources)
        for field in one.fields:
            size = np.abs(field.values).max()
            np.testing.assert_allclose(other[field.name], field.values, rtol=0, atol=1e-10 * size)


def test_robust_scales() -> None:
    """Robust distances scale with the mesh."""
    mesh = sheared(12, 3.0)
    before = heat_distance(mesh, [3], "h2", robust=True, refine=False)
    scaled = heat_distance(TriangleMesh(mesh.vertices * 1e6, mesh.faces), [3], "h2", robust=True, refine=False)
    np.testing.assert_allclose(scaled, 1e6 * before, rtol=1e-6)


@needs_reference
@pytest.mark.parametrize(
    "name",
    [
        "camelhead.off",
        "fan3.obj",
        "hourglass_ico.obj",
        "lego.ply",
        "moebius.obj",
        "ogre.obj",
        "platonic_shelf.obj",
        "stanford-bunny.obj",
        "tet.obj",
        "triple_vierbein.obj",
        "woody.obj",
    ],
)
def test_robust_on_hostile_meshes(name: str) -> None:
    """Robust heat is positive and distance finite on the source's component, and zero only at the source.

    Distances lie between 0.8 of the straight line and 1.2 of the edge path, up to h.
    """
    from geomhw.io import read_mesh

    mesh = read_mesh(reference(f"meshes/hostile/{name}"))
    source = int(mesh.faces[mesh.degenerate_faces[0] if mesh.degenerate_faces.size else 0, 0])
    result = HeatDistance(mesh, "h2", robust=True).from_vertices([source])
    near = mesh.components == mesh.components[source]
    distance = result["distance"]
    assert np.flatnonzero(distance <= 0).tolist() == [source]
    np.testing.assert_array_equal(np.isfinite(distance), near)
    assert (result["heat"][near] > 0).all()
    chord = np.linalg.norm(mesh.vertices - mesh.vertices[source], axis=1)
    path = edge_path_distance(mesh, np.array([source]))
    assert (distance[near] < 1.2 * path[near] + mesh.mean_edge_length).all()
    assert (distance[near] > 0.8 * chord[near] - mesh.mean_edge_length).all()


def test_default_source_is_highest(tmp_path: Path) -> None:
    """The default source has the largest y; the lowest index on a tie; and a face."""
    mesh = TriangleMesh([[0, 0, 0], [1, 1, 0], [0, 1, 1], [5, 9, 5]], [[0, 1, 2]])
    assert default_source(mesh) == 1


@pytest.mark.parametrize("name", ["grid", "annulus"])
def test_boundary_conditions(name: str) -> None:
    """Dirichlet heat is zero at the boundary and solves the inner system; the average is half the sum."""
    mesh = zoo_mesh(name)
    inner = np.setdiff1d(np.arange(mesh.n_vertices), mesh.boundary_vertices)
    source = int(inner[len(inner) // 2])
    impulse = np.zeros(mesh.n_vertices)
    impulse[source] = 1
    flows = {b: HeatStep(mesh, "h2", b) for b in ("neumann", "dirichlet", "average")}  # type: ignore[arg-type]
    heat = {b: flow.from_impulse(impulse).plain for b, flow in flows.items()}
    assert not heat["dirichlet"][mesh.boundary_vertices].any()
    np.testing.assert_allclose((flows["dirichlet"].matrix @ heat["dirichlet"])[inner], impulse[inner], atol=1e-12)
    np.testing.assert_allclose(heat["average"], (heat["neumann"] + heat["dirichlet"]) / 2, rtol=1e-12)
    assert np.delete(heat["neumann"], mesh.unreferenced_vertices).min() > 0
