"""Incompressible flow: what each scheme keeps or loses, exact waves, boundaries, handles, restarts, refusals."""

import re
from itertools import pairwise

import numpy as np
import pytest
from conftest import crumpled, needs_reference, reference, zoo_mesh

from geomhw.errors import ConvergenceError, FieldError, MeshError
from geomhw.flow.harmonic import closed_forms, harmonic_basis
from geomhw.flow.helmholtz import HelmholtzDecomposition
from geomhw.flow.initial_fields import blob, random_field, rigid_field, rotation_field
from geomhw.flow.tangent_fields import energy, tangential
from geomhw.fluid import initial
from geomhw.fluid.conservative import ConservativeScheme
from geomhw.fluid.forces import top_jet
from geomhw.fluid.passive_scalar import PassiveScalar
from geomhw.fluid.rk4 import RK4Scheme
from geomhw.fluid.run import Plan, run
from geomhw.fluid.schemes import scheme_of
from geomhw.fluid.stable_fluids import Advection, StableFluidsScheme
from geomhw.fluid.state import Diagnostics, FlowState, Scheme
from geomhw.fluid.vorticity import VorticityModel
from geomhw.fluid.vorticity_scheme import VorticityScheme
from geomhw.mesh.primitives import cylinder_band, icosphere, moebius_band, torus
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.directional_derivative import DirectionalDerivative, directional_derivative
from geomhw.operators.divergence import divergence
from geomhw.operators.gradient import gradient
from geomhw.operators.mass import lumped_mass

Z = np.array([0.0, 0.0, 1.0])
SCHEMES = ("conservative", "rk4", "stable-fluids")
#: Rate at which a Rossby-Haurwitz wave of degree 4 turns on a unit sphere under Ω = 1.
WAVE_RATE = 1 - 2 / (4 * 5)


def rossby_haurwitz(mesh: TriangleMesh, time: float = 0.0) -> np.ndarray:
    """Exact total vorticity 2Ωz + 2 Re(x+iy)⁴, the wave turned by Ω(1 - 2/(l(l+1))) t."""
    x, y, z = mesh.vertices.T
    turned = (x + 1j * y) * np.exp(-1j * WAVE_RATE * time)
    return 2 * z + 2 * (turned**4).real


def start_of(scheme: VorticityScheme, w: np.ndarray) -> FlowState:
    """The flow of that vorticity, with a color of zeros."""
    model = scheme.model
    around = np.zeros(model.n_unknowns)
    return scheme.from_vorticity(model.from_vorticity(w), around, np.zeros(len(model.harmonic)), np.zeros(len(w)))


def last(scheme: Scheme, state: FlowState, plan: Plan) -> FlowState:
    """The state at the end of a free run."""
    return [moment.state for moment in run(scheme, state, plan, None)][-1]


def wave_velocity(mesh: TriangleMesh) -> np.ndarray:
    """Velocity of the wave at time 0."""
    scheme = ConservativeScheme(mesh)
    return scheme.velocity(start_of(scheme, rossby_haurwitz(mesh)))


# -- the handout's scheme ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(("advection", "kept"), [("full", (0.16, 0.37)), ("increment", (0.65, 0.80))])
def test_handout_dissipates_as_known(advection: Advection, kept: tuple[float, float]) -> None:
    """Energy left of a wave after one revolution at Courant number ½, on 642 and 2,562 vertices, within a tenth."""
    for level, expected in zip((3, 4), kept, strict=True):
        mesh = icosphere(level)
        scheme, V = StableFluidsScheme(mesh, advection), wave_velocity(mesh)
        state = scheme.start(V, np.zeros(mesh.n_vertices))
        speed = np.linalg.norm(V, axis=1).max()
        steps = int(np.ceil(2 * np.pi / WAVE_RATE / (0.5 * mesh.mean_edge_length / speed)))
        end = last(scheme, state, Plan(dt=2 * np.pi / WAVE_RATE / steps, steps=steps, every=steps))
        assert energy(mesh, scheme.velocity(end)) / energy(mesh, V) == pytest.approx(expected, rel=0.1)


def test_projection() -> None:
    """The projection takes a gradient to 0 and leaves a divergence-free field as it is."""
    mesh = zoo_mesh("crumpled_torus")
    scheme = StableFluidsScheme(mesh)
    color = np.zeros(mesh.n_vertices)
    slope = (gradient(mesh) @ mesh.vertices[:, 0]).reshape(-1, 3)
    assert np.abs(scheme.velocity(scheme.start(slope, color))).max() < 1e-12
    free = HelmholtzDecomposition(mesh)(random_field(mesh, 1))["divergence_free"]
    np.testing.assert_allclose(scheme.velocity(scheme.start(free, color)), free, atol=1e-12)


def test_handout_step_is_its_three_steps() -> None:
    """Advection by I - tD + t²D²/2 between averages, then the force, then the projection; then the color."""
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
    """After every step |Div V| is rounding, and on a boundary nothing flows through."""
    mesh = zoo_mesh(name)
    stepper = scheme_of(mesh, scheme)  # type: ignore[arg-type]
    state = stepper.start(random_field(mesh, 2), blob(mesh, 0))
    gauges = Diagnostics(stepper)
    for moment in run(stepper, state, Plan(cfl=0.5, steps=5), None):
        assert gauges(moment.state, moment.dt)["divergence"] < 1e-12


# -- vorticity: identities ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["sphere", "crumpled_torus", "annulus", "two_spheres", "grid"])
def test_jacobian(name: str) -> None:
    """J is antisymmetric, is M D_V of the operator approach, and keeps ψ, constants, and so energy."""
    mesh = zoo_mesh(name)
    model = ConservativeScheme(mesh).model
    q, around, c = model.from_velocity(random_field(mesh, 4))
    psi = model.stream_function(q, around)
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
    """A divergence-free flow made of ψ and c has that q and c again; its energy is -½ψᵀq + ½|c|² where closed."""
    mesh = zoo_mesh(name)
    model = ConservativeScheme(mesh).model
    q, around, c = model.from_velocity(random_field(mesh, 7))
    psi = model.stream_function(q, around)
    c = c + np.arange(1, len(c) + 1)
    V = model.velocity(psi, c)
    q2, around2, c2 = model.from_velocity(V)
    np.testing.assert_allclose(model.stream_function(q2, around2), psi, atol=1e-10 * np.abs(psi).max())
    np.testing.assert_allclose(c2, c, atol=1e-10)
    if mesh.is_closed:
        np.testing.assert_allclose(q2, q, atol=1e-11 * np.abs(q).max() + 1e-12)
        assert energy(mesh, V) / 2 == pytest.approx(-psi @ q / 2 + c @ c / 2, rel=1e-10)


@pytest.mark.parametrize(
    ("mesh", "genus"),
    [("sphere", 0), ("torus", 1), ("crumpled_torus", 1), ("genus_two", 2), ("annulus", 0), ("two_spheres", 0)],
)
def test_harmonic_basis(mesh: str, genus: int) -> None:
    """Two fields a handle: orthonormal, free of divergence, and of curl in the weak sense; the forms are closed."""
    surface = zoo_mesh(mesh)
    h = harmonic_basis(surface)
    assert len(h) == 2 * genus
    gram = np.einsum("gfx,kfx,f->gk", h, h, surface.face_areas)
    np.testing.assert_allclose(gram, np.eye(2 * genus), atol=1e-12)
    forms = closed_forms(surface).toarray()
    upward = np.roll(surface.faces, -1, axis=1) < np.roll(surface.faces, -2, axis=1)
    np.testing.assert_array_equal((forms[:, surface.edge_table.of_faces] * np.where(upward, 1, -1)).sum(axis=2), 0)
    Div, curl = divergence(surface), gradient(surface).T * np.repeat(surface.face_areas, 3)
    for field in h:
        scale = (abs(Div) @ np.abs(field).ravel()).max()
        assert np.abs(Div @ field.ravel()).max() < 1e-11 * scale
        assert np.abs(curl @ np.cross(surface.face_normals, field).ravel()).max() < 1e-10 * scale


def test_harmonic_basis_spans_what_is_left() -> None:
    """A torus with holes in it still has two, and they vanish on no flow along the boundary."""
    whole = torus(24, 12)
    holed = TriangleMesh(whole.vertices, np.delete(whole.faces, [5, 6, 7, 300, 301], axis=0))
    h = harmonic_basis(holed)
    assert len(h) == 2
    for field in h:
        spread = divergence(holed) @ field.ravel()
        assert np.abs(spread).max() < 1e-11 * np.abs(field).max()


# -- the conservative and the fast scheme -------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("scheme", "level", "bound"), [("conservative", 4, 0.025), ("conservative", 5, 0.01), ("rk4", 5, 0.003)]
)
def test_rossby_haurwitz(scheme: str, level: int, bound: float) -> None:
    """Relative L2 error of the total vorticity at Courant number 1 after 0.8 and 1 revolutions of the pattern."""
    mesh = icosphere(level)
    stepper = scheme_of(mesh, scheme)  # type: ignore[arg-type]
    assert isinstance(stepper, VorticityScheme)
    state = start_of(stepper, rossby_haurwitz(mesh))
    for share in (0.8, 1.0):
        T = share * 2 * np.pi / WAVE_RATE
        state = last(stepper, state, Plan(cfl=1.0, until=T, every=1000))
        assert state.time == T
        exact, found = rossby_haurwitz(mesh, T), stepper.vorticity(state)
        error = np.sqrt(mesh.vertex_areas @ (found - exact) ** 2 / (mesh.vertex_areas @ exact**2))
        assert error < bound


def test_random_vorticity_keeps_what_it_should() -> None:
    """300 steps at Courant number 1: energy to 1e-9, circulation to rounding, largest vorticity no larger."""
    mesh = icosphere(3)
    scheme = ConservativeScheme(mesh)
    gauges = Diagnostics(scheme)
    moments = list(
        run(scheme, scheme.start(random_field(mesh, 1), blob(mesh, 5)), Plan(cfl=1.0, steps=300, every=50), None)
    )
    seen = [gauges(moment.state, moment.dt) for moment in moments]
    assert np.ptp([row["energy"] for row in seen]) < 1e-9 * seen[0]["energy"]
    assert np.abs([row["circulation"] for row in seen]).max() < 1e-12 * np.sqrt(2 * seen[0]["enstrophy"])
    assert all(later["enstrophy"] <= earlier["enstrophy"] for earlier, later in pairwise(seen))
    largest = [np.abs(scheme.vorticity(moment.state)).max() for moment in moments]
    assert max(largest) < 1.1 * largest[0]
    assert all(row["color_min"] >= -1e-12 and row["color_max"] <= 1 + 1e-12 for row in seen)


@pytest.mark.parametrize("name", ["crumpled_torus", "annulus", "two_spheres", "genus_two"])
def test_energy_everywhere(name: str) -> None:
    """Handles, boundaries and several components keep their energy, and the circulation round each loop."""
    mesh = zoo_mesh(name)
    scheme = ConservativeScheme(mesh)
    start = scheme.start(random_field(mesh, 3) + rigid_field(mesh, Z), blob(mesh, 0))
    end = last(scheme, start, Plan(cfl=1.0, steps=40, every=40))
    before, after = (energy(mesh, scheme.velocity(state)) for state in (start, end))
    assert after == pytest.approx(before, rel=1e-9)
    np.testing.assert_array_equal(end.memory["around"], start.memory["around"])
    for label in np.unique(mesh.components):
        inside = mesh.components == label
        drift = end.memory["q"][inside].sum() - start.memory["q"][inside].sum()
        assert abs(drift) < 1e-12 * np.abs(start.memory["q"]).sum()
    if len(end.memory["c"]):
        assert np.abs(end.memory["c"] - start.memory["c"]).max() > 1e-6 * np.abs(start.memory["c"]).max()


def test_coefficients_are_named() -> None:
    """Rigid rotation of a cylinder: circulation round its ends 2πr², one against the other; a handle has two fields."""
    band = cylinder_band(64, 8)
    scheme = ConservativeScheme(band)
    start = scheme.start(rigid_field(band, Z), np.zeros(band.n_vertices))
    row = Diagnostics(scheme)(last(scheme, start, Plan(cfl=1.0, steps=3, every=3)), 1.0)
    radius = np.linalg.norm(band.vertices[0, :2])
    assert sorted(name for name in row if "_" in name and "color" not in name) == ["loop_0", "loop_1"]
    np.testing.assert_allclose(sorted([row["loop_0"], row["loop_1"]]), np.array([-2, 2]) * np.pi * radius**2, rtol=0.01)
    donut = RK4Scheme(zoo_mesh("torus"))
    flow = donut.velocity(donut.start(random_field(donut.mesh, 1), np.zeros(donut.mesh.n_vertices)))
    state = donut.start(flow + 2 * donut.model.harmonic[1], np.zeros(donut.mesh.n_vertices))
    plain = Diagnostics(donut)(donut.start(flow, np.zeros(donut.mesh.n_vertices)), 1.0)
    full = Diagnostics(donut)(state, 1.0)
    assert full["harmonic_1"] - plain["harmonic_1"] == pytest.approx(2)
    assert full["harmonic_0"] == pytest.approx(plain["harmonic_0"])


@needs_reference
@pytest.mark.parametrize(("name", "genus"), [("eight.off", 2), ("3holes.off", 3)])
def test_energy_on_handles(name: str, genus: int) -> None:
    """Real meshes of genus 2 and 3: energy kept while the harmonic coefficients move."""
    from geomhw.io import read_mesh

    mesh = read_mesh(reference(f"meshes/closed/{name}"))
    scheme = ConservativeScheme(mesh)
    start = scheme.start(random_field(mesh, 0) + 5 * rigid_field(mesh, Z) * mesh.mean_edge_length, blob(mesh, 0))
    assert len(start.memory["c"]) == 2 * genus
    end = last(scheme, start, Plan(cfl=1.0, steps=10, every=10))
    assert energy(mesh, scheme.velocity(end)) == pytest.approx(energy(mesh, scheme.velocity(start)), rel=1e-9)
    assert np.abs(end.memory["c"] - start.memory["c"]).max() > 1e-9 * np.abs(start.memory["c"]).max()


def test_harmonic_flow_is_steady() -> None:
    """On a symmetric torus a flow round the hole without vorticity stays as it is."""
    mesh = torus(32, 16)
    scheme = ConservativeScheme(mesh)
    V = scheme.model.harmonic[0]
    start = scheme.start(V, mesh.vertices[:, 0])
    end = last(scheme, start, Plan(cfl=1.0, steps=100, every=100))
    assert np.abs(scheme.velocity(end) - V).max() < 1e-10 * np.abs(V).max()


def test_time_reversal() -> None:
    """Unfiltered, a flow run back for as many steps returns to where it began."""
    mesh = icosphere(3)
    scheme = ConservativeScheme(mesh, filter=False)
    start = scheme.start(random_field(mesh, 9), np.zeros(mesh.n_vertices))
    dt = 0.5 * mesh.mean_edge_length / np.linalg.norm(scheme.velocity(start), axis=1).max()
    there = last(scheme, start, Plan(dt=dt, steps=200, every=200))
    turned = scheme.start(-scheme.velocity(there), there.color)
    back = last(scheme, turned, Plan(dt=dt, steps=200, every=200))
    size = np.abs(start.memory["q"]).max()
    assert np.abs(there.memory["q"] - start.memory["q"]).max() > 0.1 * size
    np.testing.assert_allclose(-back.memory["q"], start.memory["q"], atol=1e-6 * size)


def test_viscosity_damps_a_mode_as_it_must() -> None:
    """The vorticity of a rigid rotation, an eigenfunction to -2, decays by backward Euler's 1/(1 + 2ν dt) a step."""
    mesh = icosphere(4)
    scheme = ConservativeScheme(mesh, filter=False, viscosity=0.1)
    start = scheme.start(rigid_field(mesh, Z), np.zeros(mesh.n_vertices))
    end = last(scheme, start, Plan(dt=0.01, steps=20, every=20))
    kept = energy(mesh, scheme.velocity(end)) / energy(mesh, scheme.velocity(start))
    assert kept == pytest.approx((1 + 2 * 0.1 * 0.01) ** -40, rel=1e-3)


def test_color_keeps_its_bounds() -> None:
    """After a whole turn a disc with a sharp edge has not left [0, 1] and still stands out."""
    mesh = icosphere(4)
    scheme = ConservativeScheme(mesh)
    disc = (mesh.vertices @ [1, 0, 0] > 0.7).astype(float)
    end = last(scheme, scheme.start(rigid_field(mesh, Z), disc), Plan(cfl=1.0, until=2 * np.pi, every=1000))
    assert end.color.min() >= 0
    assert end.color.max() <= 1
    assert end.color[int((mesh.vertices @ [1, 0, 0]).argmax())] > 0.9
    assert end.color[int((mesh.vertices @ [-1, 0, 0]).argmax())] < 0.1


@pytest.mark.parametrize("courant", [0.5, 1.0, 2.0])
def test_color_comes_back_from_a_turn(courant: float) -> None:
    """A bump carried once round the sphere is where it was, and as high, whatever the Courant number."""
    mesh = icosphere(4)
    dye, V = PassiveScalar(VorticityModel(mesh)), rigid_field(mesh, np.array([0.3, 0.5, 0.8]))
    D = DirectionalDerivative(mesh)(V)
    color = start = blob(mesh, 0)
    steps = int(np.ceil(2 * np.pi / (courant * mesh.mean_edge_length / np.linalg.norm(V, axis=1).max())))
    for _ in range(steps):
        color = dye.carry(D, color, 2 * np.pi / steps)
    assert np.linalg.norm(color - start) < 0.05 * np.linalg.norm(start)
    assert 0.92 < color.max() <= 1
    assert color.min() >= 0


@pytest.mark.parametrize("scheme", SCHEMES)
def test_color_goes_downstream(scheme: str) -> None:
    """The dye moves as the flow map moves it, whatever the scheme."""
    mesh = icosphere(3)
    stepper = scheme_of(mesh, scheme, advection="increment")  # type: ignore[arg-type]
    start = int((mesh.vertices @ [1, 0, 0]).argmax())
    end = last(stepper, stepper.start(rigid_field(mesh, Z), blob(mesh, start)), Plan(dt=0.05, steps=20, every=20))
    x, y, _ = (mesh.vertex_areas * np.maximum(end.color, 0)) @ mesh.vertices
    assert np.arctan2(y, x) == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("factor", [1e-3, 1e3])
def test_scale(scheme: str, factor: float) -> None:
    """The same flow on a mesh of another size is the same flow, in its units."""
    mesh = crumpled(icosphere(2))
    ends = []
    for size in (1.0, factor):
        scaled = TriangleMesh(mesh.vertices * size, mesh.faces)
        stepper = scheme_of(scaled, scheme)  # type: ignore[arg-type]
        state = last(stepper, stepper.start(random_field(scaled, 2), blob(scaled, 0)), Plan(dt=0.01, steps=5, every=5))
        ends.append((stepper.velocity(state) / size, stepper.vorticity(state), state.color))
    for one, other in zip(*ends, strict=True):
        np.testing.assert_allclose(other, one, atol=1e-8 * np.abs(one).max())


# -- initial flows ------------------------------------------------------------------------------------------------


def test_rossby_haurwitz_starts_as_given() -> None:
    """The command's wave is the exact one at time 0, wherever the sphere lies and whatever its size."""
    mesh = icosphere(4)
    far = TriangleMesh(3 * mesh.vertices + np.array([5.0, -7.0, 2.0]), mesh.faces)
    for sphere in (mesh, far):
        scheme = ConservativeScheme(sphere)
        w = scheme.vorticity(scheme.start(initial.rossby_haurwitz(scheme.model, 4), np.zeros(mesh.n_vertices)))
        np.testing.assert_allclose(w, rossby_haurwitz(mesh), atol=0.01 * np.abs(w).max())
    odd = ConservativeScheme(mesh)
    w = odd.vorticity(odd.start(initial.rossby_haurwitz(odd.model, 5), np.zeros(mesh.n_vertices)))
    x, y, z = mesh.vertices.T
    np.testing.assert_allclose(w, 2 * z + 2 * z * ((x + 1j * y) ** 4).real / 0.2862, atol=0.02 * np.abs(w).max())


def test_vortices_have_their_circulation() -> None:
    """A pair of opposite vortices: the vorticity round each sums to its circulation."""
    mesh = icosphere(4)
    model = ConservativeScheme(mesh).model
    a, b = 0, int((mesh.vertices @ mesh.vertices[0]).argmin())
    q, _, _ = model.from_velocity(initial.vortices(model, {a: 2.0, b: -2.0}))
    near = mesh.vertices @ mesh.vertices[a] > 0
    assert q[near].sum() == pytest.approx(2, rel=1e-3)
    assert q[~near].sum() == pytest.approx(-2, rel=1e-3)


def test_initial_harmonic() -> None:
    """The harmonic field has no vorticity and the handout's speed; what is no such flow is refused."""
    mesh = zoo_mesh("crumpled_torus")
    model = ConservativeScheme(mesh).model
    V = initial.harmonic(model, 1)
    q, _, c = model.from_velocity(V)
    assert np.abs(q).max() < 1e-10 * np.abs(c).max()
    assert np.linalg.norm(V, axis=1).max() == pytest.approx(10 * mesh.mean_edge_length)
    with pytest.raises(FieldError, match="there are 0 to 1"):
        initial.harmonic(model, 2)
    with pytest.raises(FieldError, match="no handles"):
        initial.harmonic(ConservativeScheme(zoo_mesh("sphere")).model, 0)
    with pytest.raises(FieldError, match="sphere"):
        initial.rossby_haurwitz(model, 4)
    with pytest.raises(FieldError, match="radii"):
        initial.rossby_haurwitz(ConservativeScheme(zoo_mesh("crumpled_sphere")).model, 4)
    with pytest.raises(FieldError, match="degree"):
        initial.rossby_haurwitz(ConservativeScheme(zoo_mesh("sphere")).model, 1)
    with pytest.raises(FieldError, match="vertex 240"):
        initial.vortices(model, {240: 1.0})
    with pytest.raises(FieldError, match="not finite"):
        initial.vortices(model, {3: np.inf})


# -- forces, runs, refusals --------------------------------------------------------------------------------------


def test_handouts_jet() -> None:
    """(0.2 h/dt)(cos 0.2πt, sin 0.2πt, 0), its tangential part, on faces within a twentieth of the top."""
    mesh = icosphere(4)
    dt = 0.0005
    push = top_jet(mesh, dt)(2.5)
    near = mesh.face_centers[:, 2] >= 1 - 0.05 * 2
    assert not push[~near].any()
    np.testing.assert_allclose(np.einsum("fx,fx->f", push, mesh.face_normals), 0, atol=1e-9)
    top = int(mesh.face_centers[:, 2].argmax())
    assert push[top] @ [0, 1, 0] == pytest.approx(0.2 * mesh.mean_edge_length / dt, rel=0.01)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_force_drives_the_flow(scheme: str) -> None:
    """From rest, one step of a solenoidal force gives dt times it, to a step's order."""
    mesh = zoo_mesh("sphere")
    stepper = scheme_of(mesh, scheme)  # type: ignore[arg-type]
    push = HelmholtzDecomposition(mesh)(np.cross([1.0, 0, 0], mesh.face_centers))["coexact"]
    state = stepper.step(stepper.start(np.zeros((mesh.n_faces, 3)), mesh.vertices[:, 0]), 1e-3, lambda time: push)
    V = stepper.velocity(state)
    assert energy(mesh, V - 1e-3 * push) < 0.02 * energy(mesh, 1e-3 * push)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_a_run_is_resumed_to_the_same_bits(scheme: str) -> None:
    """Ten steps at once, or four and, from their state, six more."""
    mesh = zoo_mesh("crumpled_torus")
    stepper = scheme_of(mesh, scheme)  # type: ignore[arg-type]
    start = stepper.start(random_field(mesh, 2), blob(mesh, 0))
    force = top_jet(mesh, 0.01)
    whole = [m.state for m in run(stepper, start, Plan(dt=0.01, steps=10, every=2), force)]
    half = [m.state for m in run(stepper, start, Plan(dt=0.01, steps=4, every=2), force)][-1]
    rest = [m.state for m in run(stepper, half, Plan(dt=0.01, steps=10, every=2), force)]
    assert [state.step for state in whole[3:]] == [state.step for state in rest]
    for name, values in whole[-1].memory.items():
        np.testing.assert_array_equal(rest[-1].memory[name], values)
    np.testing.assert_array_equal(rest[-1].color, whole[-1].color)


def test_a_run_ends_in_time() -> None:
    """The last moment is at the time asked for, exactly, and is no regular frame if its step was cut."""
    mesh = zoo_mesh("sphere")
    scheme = RK4Scheme(mesh)
    start = scheme.start(rotation_field(mesh, Z), np.zeros(mesh.n_vertices))
    moments = list(run(scheme, start, Plan(dt=0.1, until=0.25, every=1), None))
    assert [m.state.time for m in moments] == pytest.approx([0, 0.1, 0.2, 0.25])
    assert moments[-1].state.time == 0.25
    assert [m.regular for m in moments] == [True, True, True, False]
    exact = list(run(scheme, start, Plan(dt=0.1, until=0.3, every=1), None))
    assert len(exact) == 4
    assert exact[-1].regular


@pytest.mark.parametrize(
    ("plan", "words"),
    [
        ({"dt": -1.0, "steps": 1}, "dt must be"),
        ({"dt": float("nan"), "steps": 1}, "dt must be"),
        ({"cfl": 0.0, "steps": 1}, "cfl must be"),
        ({"dt": 1.0, "until": float("inf")}, "until must be"),
        ({"dt": 1.0}, "ends either"),
        ({"steps": 1}, "of dt or of"),
        ({"dt": 1.0, "steps": 0}, "at least one step"),
        ({"dt": 1.0, "steps": 1, "every": 0}, "at least one"),
    ],
)
def test_plans_refused(plan: dict[str, float], words: str) -> None:
    """Each plan that is none has its sentence."""
    with pytest.raises(FieldError, match=words):
        Plan(**plan)  # type: ignore[arg-type]


def test_refusals() -> None:
    """One-sided meshes, unknown schemes, negative viscosity, a flow at rest with a Courant number."""
    band = moebius_band(24, 3)
    for scheme in SCHEMES:
        with pytest.raises(MeshError, match="oriented manifold"):
            scheme_of(band, scheme)  # type: ignore[arg-type]
    mesh = zoo_mesh("sphere")
    with pytest.raises(FieldError, match="conservative, rk4, stable-fluids"):
        scheme_of(mesh, "best")  # type: ignore[arg-type]
    with pytest.raises(FieldError, match="full, increment"):
        StableFluidsScheme(mesh, "none")  # type: ignore[arg-type]
    with pytest.raises(FieldError, match="viscosity"):
        ConservativeScheme(mesh, viscosity=-1.0)
    with pytest.raises(FieldError, match="viscosity"):
        scheme_of(mesh, "stable-fluids", viscosity=1.0)
    scheme_at_rest = ConservativeScheme(mesh)
    rest = scheme_at_rest.start(np.zeros((mesh.n_faces, 3)), np.zeros(mesh.n_vertices))
    with pytest.raises(FieldError, match="at rest"):
        list(run(scheme_at_rest, rest, Plan(cfl=1.0, steps=1), None))


@pytest.mark.parametrize("scheme", SCHEMES)
def test_steps_too_large_are_refused_not_nan(scheme: str) -> None:
    """A step of many thousand cells ends in a sentence; no state with NaN comes out."""
    mesh = zoo_mesh("sphere")
    stepper = scheme_of(mesh, scheme)  # type: ignore[arg-type]
    state = stepper.start(random_field(mesh, 1), mesh.vertices[:, 0])
    with pytest.raises(ConvergenceError, match="shorter"):
        stepper.step(state, 1e6, None)


@pytest.mark.parametrize("name", ["sphere", "crumpled_torus"])
@pytest.mark.parametrize("scheme", ["conservative", "rk4"])
def test_the_largest_courant_number_is_named(scheme: str, name: str) -> None:
    """The refusal of a long step names a Courant number that runs, and whose double does not."""
    mesh = zoo_mesh(name)
    stepper = scheme_of(mesh, scheme)  # type: ignore[arg-type]
    start = stepper.start(random_field(mesh, 1), np.zeros(mesh.n_vertices))
    with pytest.raises(ConvergenceError, match="step 1 is too long") as refusal:
        list(run(stepper, start, Plan(cfl=40.0, steps=1), None))
    found = re.search(r"on this mesh is (\S+) \(dt (\S+)\)", str(refusal.value))
    assert found
    assert 0.2 < float(found[1]) < 20
    for plan in (Plan(cfl=float(found[1]), steps=1), Plan(dt=float(found[2]), steps=1)):
        assert len(list(run(stepper, start, plan, None))) == 2
    with pytest.raises(ConvergenceError):
        stepper.step(start, 2 * float(found[2]), None)
