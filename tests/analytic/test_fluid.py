"""Fluid schemes against known answers: dissipation, viscosity, circulation, color after a full turn."""

import numpy as np
import pytest

from geomhw.flow.helmholtz import HelmholtzDecomposition
from geomhw.flow.initial_fields import blob, random_field, rigid_field
from geomhw.flow.passive_scalar import PassiveScalar
from geomhw.flow.tangent_fields import energy
from geomhw.fluid import initial
from geomhw.fluid.conservative import ConservativeScheme
from geomhw.fluid.initial import top_jet
from geomhw.fluid.rk4 import RK4Scheme
from geomhw.fluid.run import Plan, scheme_of
from geomhw.fluid.stable_fluids import StableFluidsScheme
from geomhw.fluid.state import Diagnostics
from geomhw.fluid.vorticity import VorticityModel
from geomhw.mesh.primitives import cylinder_band, icosphere, torus
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.directional_derivative import DirectionalDerivative
from geomhw.options import Advection
from support.exact import WAVE_RATE, Z, last, rossby_haurwitz, wave_velocity
from support.meshes import zoo_mesh

SCHEMES = ("conservative", "rk4", "stable-fluids")


@pytest.mark.parametrize(("advection", "kept"), [("full", (0.16, 0.37)), ("increment", (0.65, 0.80))])
def test_handout_dissipates_as_known(advection: Advection, kept: tuple[float, float]) -> None:
    """The handout's scheme keeps known shares of a wave's energy after one revolution, within 10 %."""
    for level, expected in zip((3, 4), kept, strict=True):
        mesh = icosphere(level)
        scheme, V = StableFluidsScheme(mesh, advection), wave_velocity(mesh)
        state = scheme.start(V, np.zeros(mesh.n_vertices))
        speed = np.linalg.norm(V, axis=1).max()
        steps = int(np.ceil(2 * np.pi / WAVE_RATE / (0.5 * mesh.mean_edge_length / speed)))
        end = last(scheme, state, Plan(dt=2 * np.pi / WAVE_RATE / steps, steps=steps, every=steps))
        assert energy(mesh, scheme.velocity(end)) / energy(mesh, V) == pytest.approx(expected, rel=0.1)


def test_coefficients_are_named() -> None:
    """A rotating cylinder has circulations ±2πr² at its ends; a torus has two harmonic coefficients."""
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


def test_harmonic_flow_is_steady() -> None:
    """On a symmetric torus the harmonic flow round the hole is steady."""
    mesh = torus(32, 16)
    scheme = ConservativeScheme(mesh)
    V = scheme.model.harmonic[0]
    start = scheme.start(V, mesh.vertices[:, 0])
    end = last(scheme, start, Plan(cfl=1.0, steps=100, every=100))
    assert np.abs(scheme.velocity(end) - V).max() < 1e-10 * np.abs(V).max()


def test_viscosity_damps_a_mode_as_it_must() -> None:
    """Viscosity damps a rigid rotation by the factor 1/(1 + 2ν dt) per step of backward Euler."""
    mesh = icosphere(4)
    scheme = ConservativeScheme(mesh, filter=False, viscosity=0.1)
    start = scheme.start(rigid_field(mesh, Z), np.zeros(mesh.n_vertices))
    end = last(scheme, start, Plan(dt=0.01, steps=20, every=20))
    kept = energy(mesh, scheme.velocity(end)) / energy(mesh, scheme.velocity(start))
    assert kept == pytest.approx((1 + 2 * 0.1 * 0.01) ** -40, rel=1e-3)


def test_color_keeps_its_bounds() -> None:
    """The color of a disc with a sharp edge stays within [0, 1] after one turn, and its contrast stays."""
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
    """A bump carried once round the sphere returns to its place and height, at each Courant number."""
    mesh = icosphere(4)
    scalar, V = PassiveScalar(VorticityModel(mesh)), rigid_field(mesh, np.array([0.3, 0.5, 0.8]))
    D = DirectionalDerivative(mesh)(V)
    color = start = blob(mesh, 0)
    steps = int(np.ceil(2 * np.pi / (courant * mesh.mean_edge_length / np.linalg.norm(V, axis=1).max())))
    for _ in range(steps):
        color = scalar.advect(D, color, 2 * np.pi / steps)
    assert np.linalg.norm(color - start) < 0.05 * np.linalg.norm(start)
    assert 0.92 < color.max() <= 1
    assert color.min() >= 0


@pytest.mark.parametrize("scheme", SCHEMES)
def test_color_goes_downstream(scheme: str) -> None:
    """Every scheme carries the color downstream: after time 1 its center stands at an angle of 1 radian."""
    mesh = icosphere(3)
    stepper = scheme_of(mesh, scheme, advection="increment")  # type: ignore[arg-type]
    start = int((mesh.vertices @ [1, 0, 0]).argmax())
    end = last(stepper, stepper.start(rigid_field(mesh, Z), blob(mesh, start)), Plan(dt=0.05, steps=20, every=20))
    x, y, _ = (mesh.vertex_areas * np.maximum(end.color, 0)) @ mesh.vertices
    assert np.arctan2(y, x) == pytest.approx(1.0, abs=0.1)


def test_rossby_haurwitz_starts_as_given() -> None:
    """The initial Rossby-Haurwitz wave has the exact vorticity on a sphere of any position and size."""
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
    """The vorticity round each of two opposite vortices sums to the vortex's circulation."""
    mesh = icosphere(4)
    model = ConservativeScheme(mesh).model
    a, b = 0, int((mesh.vertices @ mesh.vertices[0]).argmin())
    q, _, _ = model.from_velocity(initial.vortices(model, {a: 2.0, b: -2.0}))
    near = mesh.vertices @ mesh.vertices[a] > 0
    assert q[near].sum() == pytest.approx(2, rel=1e-3)
    assert q[~near].sum() == pytest.approx(-2, rel=1e-3)


def test_handouts_jet() -> None:
    """The jet is the tangential part of (0.2 h/dt)(cos 0.2πt, sin 0.2πt, 0), on faces near the top only."""
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
    """From rest, one step under a solenoidal force F gives the velocity dt F to first order."""
    mesh = zoo_mesh("sphere")
    stepper = scheme_of(mesh, scheme)  # type: ignore[arg-type]
    push = HelmholtzDecomposition(mesh)(np.cross([1.0, 0, 0], mesh.face_centers))["coexact"]
    state = stepper.step(stepper.start(np.zeros((mesh.n_faces, 3)), mesh.vertices[:, 0]), 1e-3, lambda time: push)
    V = stepper.velocity(state)
    assert energy(mesh, V - 1e-3 * push) < 0.02 * energy(mesh, 1e-3 * push)
