"""Identities of tracers: kept stream functions, steps that add up, invariances, even seeds, memory."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import cKDTree

from geomhw.errors import FieldError
from geomhw.flow.harmonic import harmonic_basis
from geomhw.flow.initial_fields import random_field, rigid_field, rotation_field
from geomhw.flow.pathlines import POSITIONS, Pathlines, PathlineTracer
from geomhw.flow.streamlines import FacePoints, StreamlineTracer
from geomhw.flow.tangent_fields import tangential
from geomhw.fluid.conservative import ConservativeScheme
from geomhw.fluid.initial import rossby_haurwitz
from geomhw.fluid.traced_scheme import TracedScheme, tracers_of
from geomhw.io import read_mesh
from geomhw.mesh.hilbert_curve import hilbert_keys
from geomhw.mesh.primitives import icosphere, moebius_band
from geomhw.mesh.sampling import area_samples, points_on, spread_samples
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.boundary_loops import loop_representatives
from geomhw.operators.gradient import gradient
from support.exact import Z
from support.meshes import CLOSED, ZOO, crumpled, zoo_mesh
from support.reference import needs_reference, reference

DATA = Path(__file__).parents[2] / "data"

MESHES = pytest.mark.parametrize("name", ZOO)


def stream_flow(mesh: TriangleMesh, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Return a random ψ, constant on boundary loops, and n × ∇ψ."""
    psi = np.random.default_rng(seed).normal(size=mesh.n_vertices)[loop_representatives(mesh)]
    return psi, np.cross(mesh.face_normals, (gradient(mesh) @ psi).reshape(-1, 3))


def at(mesh: TriangleMesh, values: np.ndarray, particles: FacePoints) -> np.ndarray:
    """Interpolate a function of vertices at the particles."""
    return np.einsum("pk,pk->p", particles.weights, values[mesh.faces[particles.faces]])


def crossing_time(mesh: TriangleMesh, V: np.ndarray) -> float:
    """Return h over the largest speed."""
    return mesh.mean_edge_length / max(float(np.linalg.norm(V, axis=1).max()), 1e-300)


def sound(particles: FacePoints, count: int) -> bool:
    """Return whether no particle is lost and all weights are valid."""
    weights = particles.weights
    return bool(weights.shape == (count, 3) and weights.min() >= 0 and np.abs(weights.sum(axis=1) - 1).max() < 1e-14)


# -- flows -------------------------------------------------------------------------------------------------------


@MESHES
@pytest.mark.parametrize("courant", [0.3, 7.0, 1e3, 1e6])
def test_stream_function_is_kept(name: str, courant: float) -> None:
    """Along n × ∇ψ each particle keeps ψ to rounding, at any step; -V brings it back."""
    mesh = zoo_mesh(name)
    psi, V = stream_flow(mesh)
    dt = courant * crossing_time(mesh, V) if V.any() else 1.0
    tracer = StreamlineTracer(mesh)
    start = tracer.seeds(300)
    end = tracer.advance(start, V, dt)
    assert sound(end, 300)
    np.testing.assert_allclose(at(mesh, psi, end), at(mesh, psi, start), rtol=0, atol=1e-13 * np.abs(psi).max())
    back = tracer.positions(tracer.advance(end, -V, dt))
    gap = np.linalg.norm(back - tracer.positions(start), axis=1).max() / mesh.mean_edge_length
    assert gap < 1e-13 * (10 + 100 * courant)


@pytest.mark.parametrize("name", ["torus", "crumpled_torus", "genus_two"])
def test_harmonic_flow(name: str) -> None:
    """Through handles, a path in a harmonic flow and back ends at its start."""
    mesh = zoo_mesh(name)
    tracer = StreamlineTracer(mesh)
    for V in harmonic_basis(mesh):
        dt = 50 * crossing_time(mesh, V)
        start = tracer.seeds(100)
        there = tracer.advance(start, V, dt)
        assert np.linalg.norm(tracer.positions(there) - tracer.positions(start), axis=1).mean() > mesh.mean_edge_length
        back = tracer.positions(tracer.advance(there, -V, dt))
        np.testing.assert_allclose(back, tracer.positions(start), atol=1e-11)


@pytest.mark.parametrize("name", ["sphere", "crumpled_sphere", "genus_two"])
def test_a_step_in_parts(name: str) -> None:
    """Seven short steps equal one long step, to rounding."""
    mesh = zoo_mesh(name)
    V = random_field(mesh, 3)
    tracer = StreamlineTracer(mesh)
    dt = 3 * crossing_time(mesh, V)
    start = parts = tracer.seeds(200)
    for _ in range(7):
        parts = tracer.advance(parts, V, dt / 7)
    whole = tracer.advance(start, V, dt)
    np.testing.assert_allclose(tracer.positions(parts), tracer.positions(whole), atol=1e-12)


# -- other fields --------------------------------------------------------------------------------------------------


@MESHES
@pytest.mark.parametrize("courant", [1.0, 300.0])
def test_any_field(name: str, courant: float) -> None:
    """In a random field on each face every particle stays on the surface."""
    mesh = zoo_mesh(name)
    V = tangential(mesh, np.random.default_rng(4).normal(size=(mesh.n_faces, 3)))
    tracer = StreamlineTracer(mesh)
    assert sound(tracer.advance(tracer.seeds(200), V, courant * crossing_time(mesh, V)), 200)


@pytest.mark.parametrize("shape", ["creature.obj", "torus.off"])
def test_rotation_fields_of_the_handout(shape: str) -> None:
    """In the handout's field, with sources, sinks and spirals, no particle is lost."""
    mesh = read_mesh(DATA / shape)
    V = rotation_field(mesh, np.array([1.0, 0.0, 0.0]))
    tracer = StreamlineTracer(mesh)
    particles = tracer.seeds(200)
    for _ in range(3):
        particles = tracer.advance(particles, V, 20 * crossing_time(mesh, V))
        assert sound(particles, 200)


def test_at_rest() -> None:
    """Without flow or time, particles stay, to the last bit."""
    mesh = zoo_mesh("crumpled_sphere")
    tracer = StreamlineTracer(mesh)
    start = tracer.seeds(50)
    for V, dt in ((np.zeros((mesh.n_faces, 3)), 5.0), (random_field(mesh, 1), 0.0)):
        end = tracer.advance(start, V, dt)
        np.testing.assert_array_equal(end.faces, start.faces)
        np.testing.assert_allclose(end.weights, start.weights, rtol=0, atol=2e-16)


def test_one_sided_surface() -> None:
    """On a Möbius band every particle stays on the surface."""
    mesh = moebius_band(40, 6)
    V = rotation_field(mesh, Z)
    tracer = StreamlineTracer(mesh)
    assert sound(tracer.advance(tracer.seeds(100), V, 100 * crossing_time(mesh, V)), 100)


@needs_reference
@pytest.mark.parametrize("path", ["meshes/hostile/camelhead.off", "meshes/hostile/stanford-bunny.obj"])
def test_slivers(path: str) -> None:
    """On meshes with slivers and holes, particles keep ψ to rounding."""
    mesh = read_mesh(reference(path))
    psi, V = stream_flow(mesh)
    tracer = StreamlineTracer(mesh)
    start = tracer.seeds(300)
    end = tracer.advance(start, V, 1e4 * crossing_time(mesh, V))
    assert sound(end, 300)
    np.testing.assert_allclose(at(mesh, psi, end), at(mesh, psi, start), atol=1e-12)


# -- invariances -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("scale", "shift"), [(1e-6, 0.0), (1e7, 0.0), (1.0, 300.0)])
def test_scale_and_place(scale: float, shift: float) -> None:
    """Seeds and paths are invariant under scaling and translation."""
    mesh = crumpled(icosphere(2))
    moved = TriangleMesh(scale * mesh.vertices + shift, mesh.faces)
    V = random_field(mesh, 2)
    ends = []
    for each, field in ((mesh, V), (moved, scale * V)):
        tracer = StreamlineTracer(each)
        ends.append(tracer.positions(tracer.advance(tracer.seeds(100), field, 0.3)))
    np.testing.assert_allclose((ends[1] - shift) / scale, ends[0], atol=1e-9)


def test_renumbering() -> None:
    """Paths are invariant under renumbering of vertices and faces."""
    mesh = crumpled(icosphere(2))
    rng = np.random.default_rng(0)
    new, order = rng.permutation(mesh.n_vertices), rng.permutation(mesh.n_faces)
    vertices = np.empty_like(mesh.vertices)
    vertices[new] = mesh.vertices
    other = TriangleMesh(vertices, np.roll(new[mesh.faces[order]], 1, axis=1))
    V = random_field(mesh, 2)
    one = StreamlineTracer(mesh).seeds(100)
    same = FacePoints(np.argsort(order)[one.faces], np.roll(one.weights, 1, axis=1))
    ends = [
        StreamlineTracer(m).positions(StreamlineTracer(m).advance(p, v, 0.3))
        for m, p, v in ((mesh, one, V), (other, same, V[order]))
    ]
    np.testing.assert_allclose(ends[1], ends[0], atol=1e-13)


# -- seeds -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", CLOSED)
def test_seeds_are_even(name: str) -> None:
    """Seeds are spread in proportion to area, farther apart than at random, and deterministic."""
    mesh = zoo_mesh(name)
    faces, weights = spread_samples(mesh, 800)
    x = points_on(mesh, faces, weights)
    share = mesh.face_areas / mesh.face_areas.sum()
    for axis in range(3):
        for cut in np.quantile(mesh.face_centers[:, axis], (0.2, 0.5, 0.7)):
            region = mesh.face_centers[:, axis] < cut
            assert abs(np.count_nonzero(region[faces]) - 800 * share[region].sum()) < 0.03 * 800
    spacing = np.sqrt(mesh.face_areas.sum() / 800)
    assert cKDTree(x).query(x, k=2)[0][:, 1].mean() > 0.65 * spacing  # by chance 0.5
    again = spread_samples(TriangleMesh(mesh.vertices, mesh.faces), 800)
    np.testing.assert_array_equal(again[0], faces)
    np.testing.assert_array_equal(again[1], weights)


@pytest.mark.parametrize("count", [1, 7, 3000])
def test_seeds_by_area(count: int) -> None:
    """In their order, each seed stands for the same area, to one per face."""
    mesh = zoo_mesh("crumpled_torus")
    faces, weights = area_samples(mesh, count)
    found = np.cumsum(np.bincount(faces, minlength=mesh.n_faces))
    expected = count * np.cumsum(mesh.face_areas) / mesh.face_areas.sum()
    assert np.abs(found - expected).max() <= 0.5 + 1e-9
    assert weights.shape == (count, 3)
    assert weights.min() >= 0
    np.testing.assert_allclose(weights.sum(axis=1), 1)


def test_flow_keeps_seeds_even() -> None:
    """A divergence-free flow keeps seeds evenly spread."""
    mesh = icosphere(3)
    _, V = stream_flow(mesh)
    tracer = StreamlineTracer(mesh)
    end = tracer.positions(tracer.advance(tracer.seeds(20_000), V, 30 * crossing_time(mesh, V)))
    for axis in range(3):
        assert abs(np.mean(end[:, axis] < 0.3) - 0.65) < 0.006


def test_hilbert_curve() -> None:
    """The Hilbert curve visits each cell once, and neighbors on it are neighbors in space."""
    cells = np.stack(np.indices((8, 8, 8)), axis=-1).reshape(-1, 3) + 0.5
    keys = hilbert_keys(cells, bits=3)
    np.testing.assert_array_equal(np.sort(keys), np.arange(512))
    np.testing.assert_array_equal(np.abs(np.diff(cells[np.argsort(keys)], axis=0)).sum(axis=1), 1)


# -- memory, and tracers in a fluid ------------------------------------------------------------------------------


def cross_section(mesh: TriangleMesh, tracers: Pathlines, time: float) -> np.ndarray:
    """Return where the tracers remember that they were at a time."""
    (k,) = np.flatnonzero(np.isclose(tracers.times, time, rtol=1e-9))
    return np.asarray(tracers.past[k])


@pytest.mark.parametrize("steps", [1, 9, 400])
def test_memory(steps: int) -> None:
    """The remembered positions lie on the path, evenly in time, for any number of steps."""
    mesh = icosphere(3)
    V = rigid_field(mesh, Z)
    follow, tracer = PathlineTracer(mesh), StreamlineTracer(mesh)
    tracers = follow.start(50)
    start = tracers.points
    np.testing.assert_array_equal(tracers.past, np.repeat(tracer.positions(start)[None], POSITIONS, axis=0))
    for k in range(steps):
        tracers = follow.step(tracers, V, 4.0 * (k + 1) / steps)
    assert tracers.past.shape == (POSITIONS, 50, 3)
    gaps = np.diff(tracers.times)
    assert gaps.min() > 0
    assert gaps.max() < 2.01 * gaps.min()
    assert 0.4 < tracers.time - tracers.times[0] < 2.0  # of √(4π)/√(2/3) · 0.15 = 0.65, at most twice
    for k in (0, 11, POSITIONS - 1):
        expected = tracer.positions(tracer.advance(start, V, tracers.times[k]))
        np.testing.assert_allclose(tracers.past[k], expected, atol=1e-12)


def test_cloud() -> None:
    """A cloud has the face's velocity, the interpolated color, and past positions relative to the present."""
    mesh = icosphere(2)
    V = rigid_field(mesh, Z)
    follow = PathlineTracer(mesh)
    tracers = follow.step(follow.start(40), V, 2.0)
    cloud = follow.cloud(tracers, V, mesh.vertices)
    np.testing.assert_allclose(cloud["color"], cloud.points, atol=1e-15)  # coordinates are a color that is linear
    np.testing.assert_array_equal(cloud["velocity"], V[cloud["face"]])
    np.testing.assert_array_equal(cloud["id"], np.arange(40))
    past = cloud["past"].reshape(40, POSITIONS, 3).transpose(1, 0, 2) + cloud.points
    np.testing.assert_allclose(past, tracers.past, atol=1e-7)
    assert follow.cloud(tracers, V, mesh.vertices[:, 0])["color"].shape == (40,)


def test_traced_scheme() -> None:
    """The flow is bit-identical to that without tracers; tracers follow the color."""
    mesh = icosphere(3)
    plain, traced = ConservativeScheme(mesh), TracedScheme(ConservativeScheme(mesh), 200)
    V = rossby_haurwitz(plain.model, 4)
    one, two = plain.start(V, mesh.vertices), traced.start(V, mesh.vertices)
    for _ in range(5):
        one, two = plain.step(one, 0.02, None), traced.step(two, 0.02, None)
    for name, values in one.variables.items():
        np.testing.assert_array_equal(two.variables[name], values)
    np.testing.assert_array_equal(one.color, two.color)
    np.testing.assert_array_equal(traced.velocity(two), plain.velocity(one))
    assert tracers_of(two).time == one.time
    assert (np.diff(tracers_of(two).times) >= 0).all()
    assert 0 == tracers_of(two).times[0] < tracers_of(two).times[-1] <= one.time
    # The color is the initial position of the fluid, and of the tracers, up to the resolution of the mesh.
    cloud = traced.cloud(two)
    was = StreamlineTracer(mesh).positions(StreamlineTracer(mesh).seeds(200))
    assert np.linalg.norm(cloud["color"] - was, axis=1).max() < 0.01
    assert np.linalg.norm(cloud.points - was, axis=1).max() > 0.1
    with pytest.raises(FieldError, match="no tracers"):
        traced.cloud(one)
