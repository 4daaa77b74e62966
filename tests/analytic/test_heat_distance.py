"""The heat method: golden values, exact and analytic answers, convergence, reach, and what it refuses."""

from pathlib import Path

import numpy as np
import pytest
from conftest import book, needs_reference, reference, sheared, split_diagonals, zoo_mesh

from geomhw.errors import FieldError, MeshError
from geomhw.geodesic.diffusion_time import time_step
from geomhw.geodesic.edge_paths import edge_path_distance
from geomhw.geodesic.heat_method import HeatDistance, heat_distance
from geomhw.geodesic.heat_step import HeatStep
from geomhw.mesh.primitives import grid, icosphere, strip
from geomhw.mesh.surface_points import default_source
from geomhw.mesh.triangle_mesh import TriangleMesh


def great_circle(mesh: TriangleMesh, source: int) -> np.ndarray:
    """Exact distance on the unit sphere."""
    a, b = mesh.vertices, mesh.vertices[source]
    return np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), a @ b)


def mean_relative_error(level: int, time: str) -> float:
    """Over all vertices but the source, in %, averaged over sources of five and of six neighbors."""
    mesh = icosphere(level)
    solver = HeatDistance(mesh, time)
    errors = []
    for source in (0, 11, 12, 20, 42, 100, 300, 641):
        exact = great_circle(mesh, source)
        others = np.arange(mesh.n_vertices) != source
        distance = solver.from_vertices([source])["distance"]
        errors.append(np.mean(np.abs(distance - exact)[others] / exact[others]))
    return 100 * float(np.mean(errors))


@pytest.mark.parametrize(("time", "bounds"), [("h2", (1.8, 1.2, 0.8, 0.65)), ("sqrt-h", (1.7, 0.8, 0.4, 0.2))])
def test_error_on_the_sphere(time: str, bounds: tuple[float, ...]) -> None:
    """Mean relative error against the great circle, in %, on 642, 2,562, 10,242 and 40,962 vertices."""
    errors = [mean_relative_error(level, time) for level in (3, 4, 5, 6)]
    assert all(error <= bound for error, bound in zip(errors, bounds, strict=True)), errors


@needs_reference
@pytest.mark.parametrize("source", [[868], None])
def test_golden_values(source: list[int] | None) -> None:
    """Every value of an independent implementation, on the handout's mesh with the handout's defaults."""
    from geomhw.io import read_mesh

    mesh = read_mesh(reference("meshes/closed/moomoo.off"))
    result = HeatDistance(mesh).from_vertices(source or [default_source(mesh)])
    golden = np.genfromtxt(reference("golden/moomoo_geodesic.csv"), delimiter=",", names=True)
    for name in ("heat", "divergence", "distance"):
        expected = golden[name]
        np.testing.assert_allclose(result[name], expected, rtol=0, atol=1e-8 * np.abs(expected).max())
    assert result.report["farthest"]["vertex"] == 765
    assert result.report["farthest"]["distance"] == pytest.approx(66.9407437317, abs=1e-9)
    assert mesh.mean_edge_length == pytest.approx(2.06515566663802, rel=1e-14)
    assert result.report["mean_distance"] == pytest.approx(35.5256774654, abs=1e-9)


@needs_reference
@pytest.mark.parametrize("time", ["sqrt-h", "h2"])
@pytest.mark.parametrize(
    "name", ["moomoo.off", "spot.obj", "kitten.obj", "3holes.off", "eight.off", "fandisk.obj", "armadillo.obj"]
)
def test_real_meshes(name: str, time: str) -> None:
    """Finite, and zero only at the source."""
    from geomhw.io import read_mesh

    distance = heat_distance(read_mesh(reference(f"meshes/closed/{name}")), [0], time)
    assert np.isfinite(distance).all()
    assert np.flatnonzero(distance <= 0).tolist() == [0]


def test_heat_step_is_solved(mesh: TriangleMesh) -> None:
    """(M + tS) u is one at the source and zero elsewhere; u sums to one against the mass; directions are unit."""
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
    """Heat is level on the face across: its rounding points nowhere, and the other vertices are equally far."""
    distance = heat_distance(zoo_mesh("tetrahedron"), [0], "h2")
    np.testing.assert_allclose(distance[1:], distance[1], rtol=1e-12)


@pytest.mark.parametrize("factor", [1e-6, 1e6])
def test_scaling_and_moving(factor: float) -> None:
    """Distance scales with the mesh and does not care where it lies."""
    mesh = zoo_mesh("crumpled_torus")
    before = heat_distance(mesh, [3], "h2")
    scaled = heat_distance(TriangleMesh(mesh.vertices * factor, mesh.faces), [3], "h2")
    np.testing.assert_allclose(scaled, before * factor, rtol=1e-9)
    moved = heat_distance(TriangleMesh(mesh.vertices + np.array([1e3, -2e3, 500]), mesh.faces), [3], "h2")
    np.testing.assert_allclose(moved, before, rtol=0, atol=1e-9 * before.max())


def test_renumbering() -> None:
    """Distance does not care in which order vertices and faces come."""
    mesh = zoo_mesh("crumpled_torus")
    rng = np.random.default_rng(1)
    order = rng.permutation(mesh.n_vertices)
    name = np.argsort(order)
    faces = name[mesh.faces[rng.permutation(mesh.n_faces)]]
    shuffled = heat_distance(TriangleMesh(mesh.vertices[order], faces), [int(name[3])], "h2")
    np.testing.assert_allclose(shuffled, heat_distance(mesh, [3], "h2")[order], rtol=0, atol=1e-11)


def test_no_silent_underflow() -> None:
    """On a strip of 3000 cells heat fades 1000 orders below the smallest double; the far end is still right."""
    mesh = strip(3000)
    for time in ("auto", "0.3*h2", "h2", "20*h2"):
        result = HeatDistance(mesh, time).from_vertices([0])
        far = result["distance"][np.isclose(mesh.vertices[:, 0], 2999)]
        np.testing.assert_allclose(far, 2999, rtol=0.01)
        np.testing.assert_allclose(np.linalg.norm(result["direction"], axis=1), 1, atol=1e-12)


def test_beyond_reach_agrees_with_within() -> None:
    """Where plain doubles suffice, the scaled system gives the same heat."""
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
    travel = edge_path_distance(mesh, np.array([0])) / np.sqrt(t)
    forgetful = np.where(plain > 1e-20, plain, 0.0)  # as if doubles ended at 1e-20
    old, log_scaled.REACH = log_scaled.REACH, 40.0
    try:
        far = log_scaled.solve_decaying(A, rhs, forgetful, travel)
    finally:
        log_scaled.REACH = old
    np.testing.assert_allclose(far.log, np.log(plain), atol=1e-9)


def test_several_sources() -> None:
    """Zero at each source, nowhere negative, and close to the least of the single distances."""
    mesh = icosphere(4)
    sources = [0, 500, 1700]
    distance = heat_distance(mesh, sources)
    assert np.flatnonzero(distance <= 0).tolist() == sources
    least = np.min([great_circle(mesh, s) for s in sources], axis=0)
    assert np.abs(distance - least).mean() < 0.03 * least.mean()


def test_sources_in_a_row() -> None:
    """From one side of a square, distance is the height above it."""
    mesh = grid(20, 20, 1.0, 1.0)
    y = mesh.vertices[:, 1] - mesh.vertices[:, 1].min()
    side = np.flatnonzero(y == 0)
    distance = heat_distance(mesh, side)
    np.testing.assert_allclose(distance, y, atol=0.02)
    assert distance[side].tolist() == [0] * len(side)


def test_repeated_sources_count_once() -> None:
    """A source given twice is one source."""
    mesh = zoo_mesh("sphere")
    np.testing.assert_array_equal(heat_distance(mesh, [5, 5]), heat_distance(mesh, [5]))


def test_unreachable_is_infinite() -> None:
    """The other component, and the vertex that no face uses, are inf; the report counts what lies on the surface."""
    mesh = zoo_mesh("two_spheres")
    result = HeatDistance(mesh).from_vertices([0])
    assert np.isfinite(result["distance"][:162]).all()
    assert np.isinf(result["distance"][162:]).all()
    assert result.report["unreachable_vertices"] == 162
    both = heat_distance(mesh, [0, 200])
    assert np.flatnonzero(np.isinf(both)).tolist() == [162]
    np.testing.assert_allclose(both[:162], result["distance"][:162], rtol=1e-12)


def test_solver_answers_many() -> None:
    """One factorization serves many sources, with the same answers as one-offs."""
    mesh = zoo_mesh("torus")
    solver = HeatDistance(mesh)
    for source in (0, 17, 200):
        np.testing.assert_array_equal(solver.from_vertices([source])["distance"], heat_distance(mesh, [source]))


def test_time_auto_switches() -> None:
    """auto takes √h between 0.1 h² and 4 h², else h²."""
    assert time_step("auto", 2.0).t == pytest.approx(np.sqrt(2))
    assert time_step("auto", 0.01).t == pytest.approx(1e-4)
    assert time_step("auto", 5.0).t == pytest.approx(25)
    assert time_step("sqrt-h", 5.0).t == pytest.approx(np.sqrt(5))
    assert time_step("0.5*h2", 3.0).t == pytest.approx(4.5)
    assert time_step(0.25, 3.0).t == 0.25
    assert time_step("1e-3", 3.0).t == 1e-3


@pytest.mark.parametrize("bad", ["0", "-1", "nan", "inf", "soon", "2*h", "h2*2", "-1*h2", "", "x*h2"])
def test_time_refusals(bad: str) -> None:
    """What is no positive time is refused with what would be one."""
    with pytest.raises(FieldError, match=r"time step"):
        time_step(bad, 1.0)


@pytest.mark.parametrize(
    ("sources", "words"),
    [
        ([], "no source"),
        ([325], r"source 325 is not a vertex: .*0 to 324"),
        ([-1], "source -1"),
        ([1.5], "whole number"),
        ([162], "belongs to no face"),
    ],
)
def test_source_refusals(sources: list[int], words: str) -> None:
    """A source must be a vertex of the surface."""
    with pytest.raises(FieldError, match=words):
        HeatDistance(zoo_mesh("two_spheres")).from_vertices(sources)


def test_zero_area_is_refused() -> None:
    """A face without area is named before anything is computed."""
    flat = TriangleMesh([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0]], [[0, 1, 3], [0, 1, 2]])
    with pytest.raises(MeshError, match=r"face 1 .*zero area; collapse .* --robust"):
        HeatDistance(flat)
    assert np.isfinite(heat_distance(flat, [0], robust=True)).all()


def test_robust_on_a_delaunay_mesh() -> None:
    """Where there is nothing to flip nor to mend, --robust changes rounding only."""
    mesh = icosphere(4)
    plain, robust = HeatDistance(mesh, "h2"), HeatDistance(mesh, "h2", robust=True, refine=False)
    for sources in ([3], [3, 900]):
        one, other = plain.from_vertices(sources), robust.from_vertices(sources)
        for field in one.fields:
            size = np.abs(field.values).max()
            np.testing.assert_allclose(other[field.name], field.values, rtol=0, atol=1e-10 * size)


def flat_error(mesh: TriangleMesh, exact: np.ndarray, source: int, robust: bool) -> float:
    """Mean relative error in %, at t = h²."""
    distance = heat_distance(mesh, [source], "h2", robust=robust, refine=False)
    others = np.arange(mesh.n_vertices) != source
    return 100 * float(np.mean(np.abs(distance - exact)[others] / exact[others]))


def test_robust_on_slivers() -> None:
    """On a flat parallelogram sheared by 20 the plain method fails altogether; the robust one gives |x - y|."""
    mesh = sheared(24, 20.0)
    for source in (0, 312, 400):
        exact = np.linalg.norm(mesh.vertices - mesh.vertices[source], axis=1)
        assert flat_error(mesh, exact, source, robust=True) < 1.5
        assert flat_error(mesh, exact, source, robust=False) > 20


def test_robust_where_faces_have_no_area() -> None:
    """Faces without area do no harm: distances are as good as without them; face fields are zero there."""
    mesh, clean = split_diagonals(), grid(16, 16, diagonal="uniform")
    assert mesh.degenerate_faces.size == 256
    for source in (0, 150):
        exact, reference_exact = (np.linalg.norm(m.vertices - m.vertices[source], axis=1) for m in (mesh, clean))
        assert flat_error(mesh, exact, source, True) < 1.1 * flat_error(clean, reference_exact, source, False)
    result = HeatDistance(mesh, robust=True).from_vertices([0])
    for name in ("direction", "heat_gradient"):
        assert np.isfinite(result[name]).all()
        assert not result[name][mesh.degenerate_faces].any()
    good = np.setdiff1d(np.arange(mesh.n_faces), mesh.degenerate_faces)
    np.testing.assert_allclose(np.linalg.norm(result["direction"][good], axis=1), 1, rtol=1e-12)
    assert result.report["robust"]["mollification"] == pytest.approx(1e-5 * mesh.mean_edge_length, rel=1e-6)


def test_robust_where_three_pages_meet() -> None:
    """On a book of flat pages the way from page to page is straight once the two are laid flat."""
    mesh = book(3, 20)
    across = np.hypot(*mesh.vertices[:, :2].T)
    page = np.round(np.arctan2(mesh.vertices[:, 1], mesh.vertices[:, 0]) * 3 / (2 * np.pi)).astype(int) % 3
    source = int(np.flatnonzero((page == 1) & np.isclose(across, 0.5))[3])
    side = np.where(page == page[source], across, -across)
    exact = np.hypot(side - across[source], mesh.vertices[:, 2] - mesh.vertices[source, 2])
    assert flat_error(mesh, exact, source, robust=True) < 2.3  # two such pages as one flat grid: 2.24


def test_robust_scales() -> None:
    """Robust distances scale with the mesh, slivers, boundary and all."""
    mesh = sheared(12, 3.0)
    before = heat_distance(mesh, [3], "h2", robust=True, refine=False)
    scaled = heat_distance(TriangleMesh(mesh.vertices * 1e6, mesh.faces), [3], "h2", robust=True, refine=False)
    np.testing.assert_allclose(scaled, 1e6 * before, rtol=1e-6)


def test_robust_has_no_underflow() -> None:
    """Beyond the reach of doubles too, over both sides of a long strip of slivers."""
    mesh = strip(3000)
    slanted = TriangleMesh(mesh.vertices + 3 * mesh.vertices[:, [1, 2, 2]], mesh.faces)
    distance = heat_distance(slanted, [0], "h2", robust=True)
    exact = np.linalg.norm(slanted.vertices - slanted.vertices[0], axis=1)
    far = exact > 100
    np.testing.assert_allclose(distance[far], exact[far], rtol=0.01)


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
    """Heat is positive and distance finite wherever the source's piece goes, and zero only at the source."""
    from geomhw.io import read_mesh

    mesh = read_mesh(reference(f"meshes/hostile/{name}"))
    source = int(mesh.faces[mesh.degenerate_faces[0] if mesh.degenerate_faces.size else 0, 0])
    result = HeatDistance(mesh, "h2", robust=True).from_vertices([source])
    near = mesh.components == mesh.components[source]
    distance = result["distance"]
    assert np.flatnonzero(distance <= 0).tolist() == [source]
    np.testing.assert_array_equal(np.isfinite(distance), near)
    assert (result["heat"][near] > 0).all()
    # No shorter than the chord by more than the method errs, no longer than along edges.
    chord = np.linalg.norm(mesh.vertices - mesh.vertices[source], axis=1)
    path = edge_path_distance(mesh, np.array([source]))
    assert (distance[near] < 1.2 * path[near] + mesh.mean_edge_length).all()
    assert (distance[near] > 0.8 * chord[near] - mesh.mean_edge_length).all()


def test_default_source_is_highest(tmp_path: Path) -> None:
    """The largest y, the lowest index on a tie, and never a loose vertex."""
    mesh = TriangleMesh([[0, 0, 0], [1, 1, 0], [0, 1, 1], [5, 9, 5]], [[0, 1, 2]])
    assert default_source(mesh) == 1


# -- boundaries ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["grid", "annulus"])
def test_boundary_conditions(name: str) -> None:
    """Cold is zero on the boundary and solves the system inside; the average is half the sum."""
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


def test_average_is_best_next_to_the_boundary() -> None:
    """On a flat square the mean of both conditions halves the error of each there, from inside and from near a side."""
    mesh = grid(40, 40)
    for source in (20 * 41 + 20, 4 * 41 + 4):
        exact = np.linalg.norm(mesh.vertices - mesh.vertices[source], axis=1)[mesh.boundary_vertices]
        errors = {}
        for boundary in ("neumann", "dirichlet", "average"):
            solver = HeatDistance(mesh, "h2", boundary=boundary)  # type: ignore[arg-type]
            found = solver.from_vertices([source])["distance"][mesh.boundary_vertices]
            errors[boundary] = np.mean(np.abs(found - exact) / exact)
        assert errors["average"] < 0.75 * min(errors["neumann"], errors["dirichlet"])


def test_boundary_conditions_at_any_extent() -> None:
    """Three cells wide and 1,500 long: the average is right at the far end, where plain heat has underflown."""
    mesh = grid(1500, 3, width=1500.0, height=3.0)
    result = HeatDistance(mesh, "h2", boundary="average").from_vertices([1501 + 0])
    exact = np.linalg.norm(mesh.vertices - mesh.vertices[1501], axis=1)
    far = exact > 1000
    np.testing.assert_allclose(result["distance"][far], exact[far], rtol=5e-3)


def test_boundary_refusals() -> None:
    """A cold boundary swallows heat that starts on it; a closed mesh has no boundary to speak of."""
    mesh = zoo_mesh("grid")
    with pytest.raises(FieldError, match="kept cold"):
        HeatDistance(mesh, boundary="dirichlet").from_vertices([0])
    with pytest.raises(FieldError, match="neumann, dirichlet, average"):
        HeatDistance(mesh, boundary="robin")  # type: ignore[arg-type]
    sphere = zoo_mesh("sphere")
    assert HeatDistance(sphere, boundary="average").from_vertices([0]).report["boundary"] == "neumann"
