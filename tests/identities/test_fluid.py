"""Conservation laws and identities of the fluid schemes, and runs in parts equal to whole runs."""

from itertools import pairwise

import numpy as np
import pytest

from geomhw.flow.harmonic import closed_forms, harmonic_basis
from geomhw.flow.helmholtz import HelmholtzDecomposition
from geomhw.flow.initial_fields import blob, random_field, rigid_field, rotation_field
from geomhw.flow.tangent_fields import energy, tangential
from geomhw.fluid import initial
from geomhw.fluid.conservative import ConservativeScheme
from geomhw.fluid.initial import top_jet
from geomhw.fluid.rk4 import RK4Scheme
from geomhw.fluid.run import Plan, run, scheme_of
from geomhw.fluid.stable_fluids import StableFluidsScheme
from geomhw.fluid.state import Diagnostics
from geomhw.mesh.primitives import cylinder_band, icosphere, torus
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.directional_derivative import directional_derivative
from geomhw.operators.divergence import divergence
from geomhw.operators.gradient import gradient
from geomhw.operators.mass import consistent_mass, lumped_mass
from support.exact import Z, last
from support.meshes import crumpled, zoo_mesh
from support.reference import needs_reference, reference

SCHEMES = ("conservative", "rk4", "stable-fluids")


def test_projection() -> None:
    """The projection maps gradients to 0 and is the identity on divergence-free fields."""
    mesh = zoo_mesh("crumpled_torus")
    scheme = StableFluidsScheme(mesh)
    color = np.zeros(mesh.n_vertices)
    slope = (gradient(mesh) @ mesh.vertices[:, 0]).reshape(-1, 3)
    assert np.abs(scheme.velocity(scheme.start(slope, color))).max() < 1e-12
    free = HelmholtzDecomposition(mesh)(random_field(mesh, 1))["divergence_free"]
    np.testing.assert_allclose(scheme.velocity(scheme.start(free, color)), free, atol=1e-12)


def test_handout_step_is_its_three_steps() -> None:
    """A step is advection by I - tD + t²D²/2 between averages, the force, the projection, then the color."""
    from geomhw.operators.averaging import faces_to_vertices, vertices_to_faces

    mesh = zoo_mesh("sphere")
    scheme = StableFluidsScheme(mesh)
    state = scheme.start(rotation_field(mesh, Z), mesh.vertices[:, 0])
    dt, push = 0.001, tangential(mesh, np.tile([0.0, 1.0, 0.0], (mesh.n_faces, 1)))
    V = scheme.velocity(state)
    D = directional_derivative(mesh, V)
    W = faces_to_vertices(mesh) @ V
    W = W - dt * (D @ W) + dt**2 / 2 * (D @ (D @ W))
    expected = HelmholtzDecomposition(mesh).project(tangential(mesh, vertices_to_faces(mesh) @ W) + dt * push)
    after = scheme.step(state, dt, lambda time: push)
    np.testing.assert_allclose(scheme.velocity(after), expected, atol=1e-13)
    D, f = directional_derivative(mesh, expected), mesh.vertices[:, 0]
    np.testing.assert_allclose(after.color, f - dt * (D @ f) + dt**2 / 2 * (D @ (D @ f)), atol=1e-13)


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("name", ["sphere", "crumpled_torus", "annulus", "two_spheres", "genus_two"])
def test_always_free_of_divergence(scheme: str, name: str) -> None:
    """After every step the divergence vanishes to rounding, and no flow crosses the boundary."""
    mesh = zoo_mesh(name)
    stepper = scheme_of(mesh, scheme)  # type: ignore[arg-type]
    state = stepper.start(random_field(mesh, 2), blob(mesh, 0))
    diagnostics = Diagnostics(stepper)
    for snapshot in run(stepper, state, Plan(cfl=0.5, steps=5), None):
        assert diagnostics(snapshot.state, snapshot.dt)["divergence"] < 1e-12


@pytest.mark.parametrize("name", ["sphere", "crumpled_torus", "annulus", "two_spheres", "grid"])
def test_jacobian(name: str) -> None:
    """J is antisymmetric, equals M D_V, and annihilates ψ and constants."""
    mesh = zoo_mesh(name)
    model = ConservativeScheme(mesh).model
    q, circulations, c = model.from_velocity(random_field(mesh, 4))
    psi = model.stream_function(q, circulations)
    J = model.jacobian(psi, c)
    size = abs(J).max()
    assert abs(J + J.T).max() < 1e-13 * size
    V = model.velocity(psi, c)
    assert abs(lumped_mass(mesh) @ directional_derivative(mesh, V) - J).max() < 1e-12 * size
    assert np.abs(J @ np.ones(mesh.n_vertices)).max() < 1e-12 * size
    free = model.jacobian(psi, np.zeros_like(c))
    assert np.abs(free @ psi).max() < 1e-12 * size * np.abs(psi).max()


@pytest.mark.parametrize("name", ["sphere", "crumpled_torus", "genus_two", "annulus"])
def test_velocity_and_back(name: str) -> None:
    """ψ and c determine q and c again; on closed meshes the energy is -½ψᵀq + ½|c|²."""
    mesh = zoo_mesh(name)
    model = ConservativeScheme(mesh).model
    q, circulations, c = model.from_velocity(random_field(mesh, 7))
    psi = model.stream_function(q, circulations)
    c = c + np.arange(1, len(c) + 1)
    V = model.velocity(psi, c)
    q2, around2, c2 = model.from_velocity(V)
    np.testing.assert_allclose(model.stream_function(q2, around2), psi, atol=1e-10 * np.abs(psi).max())
    np.testing.assert_allclose(c2, c, atol=1e-10)
    if mesh.is_closed:
        np.testing.assert_allclose(q2, q, atol=1e-11 * np.abs(q).max() + 1e-12)
        assert energy(mesh, V) / 2 == pytest.approx(-psi @ q / 2 + c @ c / 2, rel=1e-10)


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("name", ["sphere", "crumpled_torus", "two_spheres"])
def test_from_vorticity(scheme: str, name: str) -> None:
    """The flow has the vorticity it starts from, less the mean on each component, and a color of zeros."""
    mesh = zoo_mesh(name)
    stepper = scheme_of(mesh, scheme)  # type: ignore[arg-type]
    w = np.sin(mesh.vertices @ [1.0, 0.5, -1.0]) + 3
    state = stepper.from_vorticity(w)
    np.testing.assert_array_equal(state.color, 0)
    M_c, M, one = consistent_mass(mesh), lumped_mass(mesh), np.ones(mesh.n_vertices)
    for label in np.unique(mesh.components[mesh.faces]):
        inside = mesh.components == label
        w = np.where(inside, w - (inside @ M_c @ w) / (inside @ M @ one), w)
    V = stepper.velocity(state)
    curl = gradient(mesh).T @ (np.repeat(mesh.face_areas, 3) * np.cross(mesh.face_normals, V).ravel())
    np.testing.assert_allclose(curl, M_c @ w, atol=1e-10 * np.abs(M_c @ w).max())


def test_from_vorticity_with_boundary_and_handles() -> None:
    """Circulations along loops and harmonic coefficients are those given; vorticity sums to them [Stokes]."""
    mesh = cylinder_band(24, 6)
    scheme = ConservativeScheme(mesh)
    for w in (mesh.vertices[:, 0], np.zeros(mesh.n_vertices)):
        state = scheme.from_vorticity(w, circulations=[2.0, -0.5])
        assert list(scheme.coefficients(state).values()) == [2.0, -0.5]
        assert mesh.vertex_areas @ scheme.vorticity(state) == pytest.approx(1.5, rel=1e-9)
    even = scheme.coefficients(scheme.start(scheme.velocity(state)))  # constant vorticity: exact at the boundary too
    np.testing.assert_allclose(list(even.values()), [2.0, -0.5], rtol=1e-9)
    donut = RK4Scheme(zoo_mesh("torus"))
    V = donut.velocity(donut.from_vorticity(np.zeros(donut.mesh.n_vertices), harmonic=[0.0, 3.0]))
    np.testing.assert_allclose(V, 3 * donut.model.harmonic[1], atol=1e-12)


@pytest.mark.parametrize(
    ("mesh", "genus"),
    [("sphere", 0), ("torus", 1), ("crumpled_torus", 1), ("genus_two", 2), ("annulus", 0), ("two_spheres", 0)],
)
def test_harmonic_basis(mesh: str, genus: int) -> None:
    """There are 2g harmonic fields: orthonormal, divergence-free and curl-free in the weak sense."""
    surface = zoo_mesh(mesh)
    h = harmonic_basis(surface)
    assert len(h) == 2 * genus
    gram = np.einsum("gfx,kfx,f->gk", h, h, surface.face_areas)
    np.testing.assert_allclose(gram, np.eye(2 * genus), atol=1e-12)
    forms = closed_forms(surface)
    upward = np.roll(surface.faces, -1, axis=1) < np.roll(surface.faces, -2, axis=1)
    np.testing.assert_array_equal((forms[:, surface.edge_table.of_faces] * np.where(upward, 1, -1)).sum(axis=2), 0)
    Div, curl = divergence(surface), gradient(surface).T * np.repeat(surface.face_areas, 3)
    for field in h:
        scale = (abs(Div) @ np.abs(field).ravel()).max()
        assert np.abs(Div @ field.ravel()).max() < 1e-11 * scale
        assert np.abs(curl @ np.cross(surface.face_normals, field).ravel()).max() < 1e-10 * scale


def test_harmonic_basis_spans_what_is_left() -> None:
    """A torus with holes has two harmonic fields, with no flux through the boundary."""
    whole = torus(24, 12)
    holed = TriangleMesh(whole.vertices, np.delete(whole.faces, [5, 6, 7, 300, 301], axis=0))
    h = harmonic_basis(holed)
    assert len(h) == 2
    for field in h:
        spread = divergence(holed) @ field.ravel()
        assert np.abs(spread).max() < 1e-11 * np.abs(field).max()


def test_random_vorticity_keeps_what_it_should() -> None:
    """300 steps at Courant number 1 keep energy to 1e-9 and circulation to rounding; enstrophy does not grow."""
    mesh = icosphere(3)
    scheme = ConservativeScheme(mesh)
    diagnostics = Diagnostics(scheme)
    snapshots = list(
        run(scheme, scheme.start(random_field(mesh, 1), blob(mesh, 5)), Plan(cfl=1.0, steps=300, every=50), None)
    )
    seen = [diagnostics(snapshot.state, snapshot.dt) for snapshot in snapshots]
    assert np.ptp([row["energy"] for row in seen]) < 1e-9 * seen[0]["energy"]
    assert np.abs([row["circulation"] for row in seen]).max() < 1e-12 * np.sqrt(2 * seen[0]["enstrophy"])
    assert all(later["enstrophy"] <= earlier["enstrophy"] for earlier, later in pairwise(seen))
    largest = [np.abs(scheme.vorticity(snapshot.state)).max() for snapshot in snapshots]
    assert max(largest) < 1.1 * largest[0]
    assert all(row["color_min"] >= -1e-12 and row["color_max"] <= 1 + 1e-12 for row in seen)


@pytest.mark.parametrize("name", ["crumpled_torus", "annulus", "two_spheres", "genus_two"])
def test_energy_everywhere(name: str) -> None:
    """With handles, boundaries and several components, energy and the circulation of each loop are constant."""
    mesh = zoo_mesh(name)
    scheme = ConservativeScheme(mesh)
    start = scheme.start(random_field(mesh, 3) + rigid_field(mesh, Z), blob(mesh, 0))
    end = last(scheme, start, Plan(cfl=1.0, steps=40, every=40))
    before, after = (energy(mesh, scheme.velocity(state)) for state in (start, end))
    assert after == pytest.approx(before, rel=1e-9)
    np.testing.assert_array_equal(end.variables["around"], start.variables["around"])
    for label in np.unique(mesh.components):
        inside = mesh.components == label
        drift = end.variables["q"][inside].sum() - start.variables["q"][inside].sum()
        assert abs(drift) < 1e-12 * np.abs(start.variables["q"]).sum()
    if len(end.variables["c"]):
        assert np.abs(end.variables["c"] - start.variables["c"]).max() > 1e-6 * np.abs(start.variables["c"]).max()


@needs_reference
@pytest.mark.parametrize(("name", "genus"), [("eight.off", 2), ("3holes.off", 3)])
def test_energy_on_handles(name: str, genus: int) -> None:
    """On real meshes of genus 2 and 3 energy is constant while harmonic coefficients change."""
    from geomhw.io import read_mesh

    mesh = read_mesh(reference(f"meshes/closed/{name}"))
    scheme = ConservativeScheme(mesh)
    start = scheme.start(random_field(mesh, 0) + 5 * rigid_field(mesh, Z) * mesh.mean_edge_length, blob(mesh, 0))
    assert len(start.variables["c"]) == 2 * genus
    end = last(scheme, start, Plan(cfl=1.0, steps=10, every=10))
    assert energy(mesh, scheme.velocity(end)) == pytest.approx(energy(mesh, scheme.velocity(start)), rel=1e-9)
    assert np.abs(end.variables["c"] - start.variables["c"]).max() > 1e-9 * np.abs(start.variables["c"]).max()


def test_time_reversal() -> None:
    """Without the filter, running back as many steps restores the start."""
    mesh = icosphere(3)
    scheme = ConservativeScheme(mesh, filter=False)
    start = scheme.start(random_field(mesh, 9), np.zeros(mesh.n_vertices))
    dt = 0.5 * mesh.mean_edge_length / np.linalg.norm(scheme.velocity(start), axis=1).max()
    there = last(scheme, start, Plan(dt=dt, steps=200, every=200))
    turned = scheme.start(-scheme.velocity(there), there.color)
    back = last(scheme, turned, Plan(dt=dt, steps=200, every=200))
    size = np.abs(start.variables["q"]).max()
    assert np.abs(there.variables["q"] - start.variables["q"]).max() > 0.1 * size
    np.testing.assert_allclose(-back.variables["q"], start.variables["q"], atol=1e-6 * size)


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("factor", [1e-3, 1e3])
def test_scale(scheme: str, factor: float) -> None:
    """The same flow on a scaled mesh is the scaled flow."""
    mesh = crumpled(icosphere(2))
    ends = []
    for size in (1.0, factor):
        scaled = TriangleMesh(mesh.vertices * size, mesh.faces)
        stepper = scheme_of(scaled, scheme)  # type: ignore[arg-type]
        state = last(stepper, stepper.start(random_field(scaled, 2), blob(scaled, 0)), Plan(dt=0.01, steps=5, every=5))
        ends.append((stepper.velocity(state) / size, stepper.vorticity(state), state.color))
    for one, other in zip(*ends, strict=True):
        np.testing.assert_allclose(other, one, atol=1e-8 * np.abs(one).max())


def test_initial_harmonic() -> None:
    """The harmonic field has no vorticity, and a largest speed of 10 h."""
    mesh = zoo_mesh("crumpled_torus")
    model = ConservativeScheme(mesh).model
    V = initial.harmonic(model, 1)
    q, _, c = model.from_velocity(V)
    assert np.abs(q).max() < 1e-10 * np.abs(c).max()
    assert np.linalg.norm(V, axis=1).max() == pytest.approx(10 * mesh.mean_edge_length)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_a_run_is_resumed_to_the_same_bits(scheme: str) -> None:
    """Ten steps equal four steps and six more from their state, to the last bit."""
    mesh = zoo_mesh("crumpled_torus")
    stepper = scheme_of(mesh, scheme)  # type: ignore[arg-type]
    start = stepper.start(random_field(mesh, 2), blob(mesh, 0))
    force = top_jet(mesh, 0.01)
    whole = [m.state for m in run(stepper, start, Plan(dt=0.01, steps=10, every=2), force)]
    half = [m.state for m in run(stepper, start, Plan(dt=0.01, steps=4, every=2), force)][-1]
    rest = [m.state for m in run(stepper, half, Plan(dt=0.01, steps=10, every=2), force)]
    assert [state.step for state in whole[3:]] == [state.step for state in rest]
    for name, values in whole[-1].variables.items():
        np.testing.assert_array_equal(rest[-1].variables[name], values)
    np.testing.assert_array_equal(rest[-1].color, whole[-1].color)


def test_a_run_ends_in_time() -> None:
    """A run ends at exactly the requested time; a shortened last step gives no regular frame."""
    mesh = zoo_mesh("sphere")
    scheme = RK4Scheme(mesh)
    start = scheme.start(rotation_field(mesh, Z), np.zeros(mesh.n_vertices))
    snapshots = list(run(scheme, start, Plan(dt=0.1, until=0.25, every=1), None))
    assert [m.state.time for m in snapshots] == pytest.approx([0, 0.1, 0.2, 0.25])
    assert snapshots[-1].state.time == 0.25
    assert [m.regular for m in snapshots] == [True, True, True, False]
    exact = list(run(scheme, start, Plan(dt=0.1, until=0.3, every=1), None))
    assert len(exact) == 4
    assert exact[-1].regular
