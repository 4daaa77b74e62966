"""Tracers: paths that keep their stream function, exact lines and turns, edges and vertices, even seeds, memory."""

from pathlib import Path

import numpy as np
import pytest
from conftest import CLOSED, ZOO, crumpled, needs_reference, reference, zoo_mesh
from scipy.spatial import cKDTree

from geomhw.errors import ConvergenceError, FieldError, MeshError
from geomhw.flow import tracer as tracer_module
from geomhw.flow.harmonic import harmonic_basis
from geomhw.flow.initial_fields import random_field, rigid_field, rotation_field
from geomhw.flow.tangent_fields import tangential
from geomhw.flow.tracer import Particles, Tracer
from geomhw.flow.tracer_cloud import PLACES, Tracers, Tracing
from geomhw.fluid.conservative import ConservativeScheme
from geomhw.fluid.initial import rossby_haurwitz
from geomhw.fluid.traced import TracedScheme, tracers_of
from geomhw.io import read_mesh
from geomhw.mesh.hilbert_curve import hilbert_keys
from geomhw.mesh.primitives import cylinder_band, grid, icosphere, moebius_band, torus
from geomhw.mesh.sampling import area_samples, points_on, spread_samples
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.boundary_loops import loop_groups
from geomhw.operators.gradient import gradient

DATA = Path(__file__).parents[2] / "data"
Z = np.array([0.0, 0.0, 1.0])
MESHES = pytest.mark.parametrize("name", ZOO)


def stream_flow(mesh: TriangleMesh, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """A rough ψ, (n,), constant on boundary loops, and n x ∇ψ, (m, 3)."""
    psi = np.random.default_rng(seed).normal(size=mesh.n_vertices)[loop_groups(mesh)]
    return psi, np.cross(mesh.face_normals, (gradient(mesh) @ psi).reshape(-1, 3))


def at(mesh: TriangleMesh, values: np.ndarray, particles: Particles) -> np.ndarray:
    """A function of vertices where the particles are."""
    return np.einsum("pk,pk->p", particles.weights, values[mesh.faces[particles.faces]])


def crossing_time(mesh: TriangleMesh, V: np.ndarray) -> float:
    """h over the largest speed."""
    return mesh.mean_edge_length / max(float(np.linalg.norm(V, axis=1).max()), 1e-300)


def sound(particles: Particles, count: int) -> bool:
    """Whether none is lost and all are in their faces."""
    weights = particles.weights
    return bool(weights.shape == (count, 3) and weights.min() >= 0 and np.abs(weights.sum(axis=1) - 1).max() < 1e-14)


# -- exact paths -------------------------------------------------------------------------------------------------


@MESHES
@pytest.mark.parametrize("courant", [0.3, 7.0, 1e3, 1e6])
def test_stream_function_is_kept(name: str, courant: float) -> None:
    """Along n x ∇ψ, however rough, ψ of a particle stays to rounding; and -V brings it back. Whatever the step."""
    mesh = zoo_mesh(name)
    psi, V = stream_flow(mesh)
    dt = courant * crossing_time(mesh, V) if V.any() else 1.0
    tracer = Tracer(mesh)
    start = tracer.seed(300)
    end = tracer.advance(start, V, dt)
    assert sound(end, 300)
    np.testing.assert_allclose(at(mesh, psi, end), at(mesh, psi, start), rtol=0, atol=1e-13 * np.abs(psi).max())
    back = tracer.positions(tracer.advance(end, -V, dt))
    gap = np.linalg.norm(back - tracer.positions(start), axis=1).max() / mesh.mean_edge_length
    assert gap < 1e-13 * (10 + 100 * courant)


@pytest.mark.parametrize("name", ["torus", "crumpled_torus", "genus_two"])
def test_harmonic_flow(name: str) -> None:
    """Through handles too: fluxes agree across edges, so that a path there and back ends where it began."""
    mesh = zoo_mesh(name)
    tracer = Tracer(mesh)
    for V in harmonic_basis(mesh):
        dt = 50 * crossing_time(mesh, V)
        start = tracer.seed(100)
        there = tracer.advance(start, V, dt)
        assert np.linalg.norm(tracer.positions(there) - tracer.positions(start), axis=1).mean() > mesh.mean_edge_length
        back = tracer.positions(tracer.advance(there, -V, dt))
        np.testing.assert_allclose(back, tracer.positions(start), atol=1e-11)


@pytest.mark.parametrize("name", ["sphere", "crumpled_sphere", "genus_two"])
def test_a_step_in_parts(name: str) -> None:
    """Steps add up: seven small ones are the large one, to rounding."""
    mesh = zoo_mesh(name)
    V = random_field(mesh, 3)
    tracer = Tracer(mesh)
    dt = 3 * crossing_time(mesh, V)
    start = parts = tracer.seed(200)
    for _ in range(7):
        parts = tracer.advance(parts, V, dt / 7)
    whole = tracer.advance(start, V, dt)
    np.testing.assert_allclose(tracer.positions(parts), tracer.positions(whole), atol=1e-12)


@pytest.mark.parametrize("direction", [(1.0, 0.0), (0.0, -1.0), (1.0, 1.0), (0.83, 0.31)])
def test_straight_lines(direction: tuple[float, float]) -> None:
    """A uniform flow on a flat grid, along its edges too: x + tV to rounding, for as long as that is on the grid."""
    mesh = grid(16, 12, 4.0, 3.0)
    V = np.tile([*direction, 0.0], (mesh.n_faces, 1))
    tracer = Tracer(mesh)
    start = tracer.seed(400)
    x = tracer.positions(start)
    end = x + 0.9 * V[0]
    inside = ((end[:, :2] > 0.01) & (end[:, :2] < [3.99, 2.99])).all(axis=1)
    assert inside.sum() > 100
    np.testing.assert_allclose(tracer.positions(tracer.advance(start, V, 0.9))[inside], end[inside], atol=1e-14)


def test_along_the_edges_of_a_grid() -> None:
    """Particles that start on edges and vertices, and go along edges, through vertices, do so exactly."""
    mesh = grid(10, 10, 10.0, 10.0, diagonal="uniform")
    V = np.tile([1.0, 0.0, 0.0], (mesh.n_faces, 1))
    inner = np.flatnonzero((mesh.face_centers[:, 0] < 3) & (np.abs(mesh.face_centers[:, 1] - 5) < 3))
    faces, corner = np.repeat(inner, 3), np.tile([0, 1, 2], len(inner))
    for weights in (np.eye(3)[corner], (1 - np.eye(3)[corner]) / 2):  # vertices; midpoints of edges
        start = Particles(faces, weights)
        tracer = Tracer(mesh)
        end = tracer.positions(tracer.advance(start, V, 5.25))
        np.testing.assert_allclose(end, tracer.positions(start) + V[0] * 5.25, atol=1e-13)


def test_round_a_cylinder() -> None:
    """Flow round a prism of 24 sides at 15° a unit of time: after 24 everything is where it was, after 1 a side on."""
    mesh = cylinder_band(24, 6)
    V = tangential(mesh, np.cross(Z, mesh.face_centers))
    V *= (2 * np.sin(np.pi / 24) / np.linalg.norm(V, axis=1))[:, None]
    tracer = Tracer(mesh)
    start = tracer.seed(200)
    x = tracer.positions(start)
    c, s = np.cos(np.pi / 12), np.sin(np.pi / 12)
    side = x @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    np.testing.assert_allclose(tracer.positions(tracer.advance(start, V, 1.0)), side, atol=1e-13)
    np.testing.assert_allclose(tracer.positions(tracer.advance(start, V, 24.0)), x, atol=1e-12)
    np.testing.assert_allclose(tracer.positions(tracer.advance(start, V, 24e6 + 1)), side, atol=1e-7)


def test_rotation_converges() -> None:
    """-n x ∇z on spheres turns a particle about z: exact latitude, and on the circle off by h^1.5.

    The velocity of a face is off by O(h), and errors of the faces on the way partly cancel.
    """
    errors = []
    for level in (2, 3, 4):
        mesh = icosphere(level)
        V = -np.cross(mesh.face_normals, (gradient(mesh) @ mesh.vertices[:, 2]).reshape(-1, 3))
        tracer = Tracer(mesh)
        start = tracer.seed(400)
        x, y = tracer.positions(start), tracer.positions(tracer.advance(start, V, 1.0))
        turn = np.angle((y[:, 0] + 1j * y[:, 1]) / (x[:, 0] + 1j * x[:, 1]))
        errors.append(np.sqrt(np.mean((np.hypot(x[:, 0], x[:, 1]) * (turn - 1.0)) ** 2)))
        np.testing.assert_allclose(y[:, 2], x[:, 2], atol=1e-14)
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    assert errors[-1] < 3e-3
    assert rates.min() > 1.3


def test_unsteady_flow_is_second_order() -> None:
    """Through a flow that changes, halved steps quarter the error: the velocity is that of the middle of the step."""
    mesh = torus(24, 12)
    A, B = random_field(mesh, 1), random_field(mesh, 2)
    tracing_ = Tracing(mesh)

    def end(steps: int) -> np.ndarray:
        tracers, dt = tracing_.start(100), 0.2 / steps
        for k in range(steps):
            before, after = (np.cos(9 * t) * A + np.sin(9 * t) * B for t in (k * dt, (k + 1) * dt))
            tracers = tracing_.step(tracers, (before + after) / 2, (k + 1) * dt)
        return points_on(mesh, tracers.particles.faces, tracers.particles.weights)

    exact = end(512)
    errors = [np.median(np.linalg.norm(end(steps) - exact, axis=1)) for steps in (8, 16, 32)]
    assert np.log2(errors[0] / errors[1]) > 1.7
    assert np.log2(errors[1] / errors[2]) > 1.7


# -- fields that are no flows --------------------------------------------------------------------------------------


@MESHES
@pytest.mark.parametrize("courant", [1.0, 300.0])
def test_any_field(name: str, courant: float) -> None:
    """Noise, a new vector on each face: it ends, and all particles are still on the surface."""
    mesh = zoo_mesh(name)
    V = tangential(mesh, np.random.default_rng(4).normal(size=(mesh.n_faces, 3)))
    tracer = Tracer(mesh)
    assert sound(tracer.advance(tracer.seed(200), V, courant * crossing_time(mesh, V)), 200)


@pytest.mark.parametrize("shape", ["creature.obj", "torus.off"])
def test_rotation_fields_of_the_handout(shape: str) -> None:
    """The handout's field has sources, sinks and spirals; particles come to rest in sinks, none is lost."""
    mesh = read_mesh(DATA / shape)
    V = rotation_field(mesh, np.array([1.0, 0.0, 0.0]))
    tracer = Tracer(mesh)
    particles = tracer.seed(200)
    for _ in range(3):
        particles = tracer.advance(particles, V, 20 * crossing_time(mesh, V))
        assert sound(particles, 200)


def two_faces(left: list[float], right: list[float]) -> tuple[TriangleMesh, np.ndarray]:
    """A long edge from (0, 0) to (0, 10) with a face on either side, and a vector on each."""
    mesh = TriangleMesh([[0, 0, 0], [0, 10, 0], [-8, 5, 0], [8, 5, 0]], [[0, 1, 2], [1, 0, 3]])
    return mesh, np.array([[*left, 0.0], [*right, 0.0]])


def test_against_each_other() -> None:
    """Fields that push into an edge from both sides: along it by their mean that crosses neither way [Filippov]."""
    mesh, V = two_faces([3.0, 1.0], [-1.0, 2.0])  # a quarter of the first and three of the second
    tracer = Tracer(mesh)
    start = Particles(np.array([0, 1]), np.array([[0.5, 0.4, 0.1], [0.4, 0.5, 0.1]]))  # at (-0.8, 4.5), (0.8, 4.5)
    arrival = np.array([0.8 / 3, 0.8])
    y = tracer.positions(start)[:, 1] + arrival * [1.0, 2.0] + (1.5 - arrival) * 1.75
    np.testing.assert_allclose(
        tracer.positions(tracer.advance(start, V, 1.5)), np.stack([0 * y, y, 0 * y], axis=1), atol=1e-14
    )


def test_along_the_boundary() -> None:
    """What flows out slides along the boundary by its part along it, and ends at the corner where nothing leads on."""
    mesh = grid(6, 4, 6.0, 4.0)
    V = np.tile([1.0, 0.5, 0.0], (mesh.n_faces, 1))
    tracer = Tracer(mesh)
    start = tracer.seed(150)
    x = tracer.positions(start)
    dt = 3.3
    for time in (dt, 40.0):
        end = tracer.positions(tracer.advance(start, V, time))
        np.testing.assert_allclose(end, np.minimum(x + time * V[0], [6.0, 4.0, 0.0]), atol=1e-12)


def test_sources_and_sinks() -> None:
    """Towards a vertex everything ends in it, on time; from it a particle on it does not know where to go but goes."""
    mesh = icosphere(3)
    V = tangential(mesh, np.broadcast_to(-Z, (mesh.n_faces, 3)))
    tracer = Tracer(mesh)
    end = tracer.positions(tracer.advance(tracer.seed(200), V, 100.0))
    np.testing.assert_allclose(end, np.tile(end[:1], (200, 1)), atol=1e-12)
    assert end[0, 2] == mesh.vertices[:, 2].min()
    off = tracer.advance(tracer.advance(tracer.seed(5), V, 100.0), -V, 4.0)
    assert (tracer.positions(off)[:, 2] > -0.9).all()


def wheel(turn: float, inward: float) -> tuple[TriangleMesh, np.ndarray]:
    """Six faces round a vertex at 0, and a field that turns about it and draws near to it."""
    rim = np.exp(2j * np.pi * np.arange(6) / 6)
    vertices = np.concatenate([np.zeros((1, 3)), np.stack([rim.real, rim.imag, 0 * rim.real], axis=1)])
    mesh = TriangleMesh(vertices, [[0, 1 + k, 1 + (k + 1) % 6] for k in range(6)])
    return mesh, turn * np.cross(Z, mesh.face_centers) - inward * mesh.face_centers


def test_closed_turns() -> None:
    """Round a vertex, on a hexagon: each turn takes what its way takes, and a million of them change nothing."""
    mesh, V = wheel(1.0, 0.0)
    tracer = Tracer(mesh)
    start = Particles(np.array([2]), np.array([[0.9, 0.06, 0.04]]))
    # The hexagon through the particle has sides as long as it is far from the center, along its side.
    period = 6 * 0.1 / np.linalg.norm(V[0])
    for turns in (1, 3, 10**6):
        end = tracer.positions(tracer.advance(start, V, turns * period))
        np.testing.assert_allclose(end, tracer.positions(start), atol=1e-13 * turns)


def test_spirals() -> None:
    """What comes back a little nearer to the center is on no circle: one long step is as many short ones."""
    mesh, V = wheel(1.0, 1e-4)
    tracer = Tracer(mesh)
    start = parts = Particles(np.array([2]), np.array([[0.9, 0.06, 0.04]]))
    for _ in range(100):
        parts = tracer.advance(parts, V, 0.2)
    whole = tracer.advance(start, V, 20.0)
    np.testing.assert_allclose(tracer.positions(whole), tracer.positions(parts), atol=1e-12)
    assert 1 - whole.weights[0, 0] < 0.99 * (1 - start.weights[0, 0])


def test_spirals_end(monkeypatch: pytest.MonkeyPatch) -> None:
    """Endless turns about a vertex, in ever shorter time, are not followed to the end."""
    monkeypatch.setattr(tracer_module, "MOST_CROSSINGS", 100)
    mesh, V = wheel(1.0, 1e-4)
    near = Particles(np.array([2]), np.array([[1 - 8e-4, 4e-4, 4e-4]]))
    end = Tracer(mesh).positions(Tracer(mesh).advance(near, V, 20.0))
    assert np.linalg.norm(end) < tracer_module.CORE


def test_the_fastest_way_off() -> None:
    """From a vertex that all faces lead away from, a particle goes where the field is fastest."""
    mesh, V = wheel(0.0, -1.0)
    for fastest in range(6):
        W = V * np.where(np.arange(6) == fastest, 3.0, 2.0)[:, None]
        for face in range(6):
            at_vertex = Particles(np.array([face]), np.array([[1.0, 0.0, 0.0]]))
            end = Tracer(mesh).positions(Tracer(mesh).advance(at_vertex, W, 0.1))
            np.testing.assert_allclose(end[0], 0.1 * W[fastest], atol=1e-15)


def test_at_rest() -> None:
    """Without a flow, or without time, nothing moves, to the last bit."""
    mesh = zoo_mesh("crumpled_sphere")
    tracer = Tracer(mesh)
    start = tracer.seed(50)
    for V, dt in ((np.zeros((mesh.n_faces, 3)), 5.0), (random_field(mesh, 1), 0.0)):
        end = tracer.advance(start, V, dt)
        np.testing.assert_array_equal(end.faces, start.faces)
        np.testing.assert_allclose(end.weights, start.weights, rtol=0, atol=2e-16)


def test_one_sided_surface() -> None:
    """A Möbius band has no orientation, but paths, and edges where faces run the same way."""
    mesh = moebius_band(40, 6)
    V = rotation_field(mesh, Z)
    tracer = Tracer(mesh)
    assert sound(tracer.advance(tracer.seed(100), V, 100 * crossing_time(mesh, V)), 100)


@needs_reference
@pytest.mark.parametrize("path", ["meshes/hostile/camelhead.off", "meshes/hostile/stanford-bunny.obj"])
def test_slivers(path: str) -> None:
    """Meshes with slivers and holes: ψ to rounding, on any of their faces."""
    mesh = read_mesh(reference(path))
    psi, V = stream_flow(mesh)
    tracer = Tracer(mesh)
    start = tracer.seed(300)
    end = tracer.advance(start, V, 1e4 * crossing_time(mesh, V))
    assert sound(end, 300)
    np.testing.assert_allclose(at(mesh, psi, end), at(mesh, psi, start), atol=1e-12)


# -- scale, order, refusals --------------------------------------------------------------------------------------


@pytest.mark.parametrize(("scale", "shift"), [(1e-6, 0.0), (1e7, 0.0), (1.0, 300.0)])
def test_scale_and_place(scale: float, shift: float) -> None:
    """Neither the size of the mesh nor where it lies changes seeds or paths."""
    mesh = crumpled(icosphere(2))
    moved = TriangleMesh(scale * mesh.vertices + shift, mesh.faces)
    V = random_field(mesh, 2)
    ends = []
    for each, field in ((mesh, V), (moved, scale * V)):
        tracer = Tracer(each)
        ends.append(tracer.positions(tracer.advance(tracer.seed(100), field, 0.3)))
    np.testing.assert_allclose((ends[1] - shift) / scale, ends[0], atol=1e-9)


def test_renumbering() -> None:
    """The same paths whatever the order of vertices and faces, from the same places."""
    mesh = crumpled(icosphere(2))
    rng = np.random.default_rng(0)
    new, order = rng.permutation(mesh.n_vertices), rng.permutation(mesh.n_faces)
    vertices = np.empty_like(mesh.vertices)
    vertices[new] = mesh.vertices
    other = TriangleMesh(vertices, np.roll(new[mesh.faces[order]], 1, axis=1))
    V = random_field(mesh, 2)
    one = Tracer(mesh).seed(100)
    same = Particles(np.argsort(order)[one.faces], np.roll(one.weights, 1, axis=1))
    ends = [Tracer(m).positions(Tracer(m).advance(p, v, 0.3)) for m, p, v in ((mesh, one, V), (other, same, V[order]))]
    np.testing.assert_allclose(ends[1], ends[0], atol=1e-13)


def test_refusals() -> None:
    """No manifold, a face without area, no tracers, a field or time that is none."""
    fan = TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0, -1, 0]], [[0, 1, 2], [0, 1, 3], [0, 1, 4]])
    with pytest.raises(MeshError, match="manifold"):
        Tracer(fan)
    with pytest.raises(MeshError, match="zero area"):
        Tracer(TriangleMesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]]))
    mesh = icosphere(1)
    tracer = Tracer(mesh)
    with pytest.raises(FieldError, match="not 0"):
        tracer.seed(0)
    V = np.full((mesh.n_faces, 3), np.nan)
    with pytest.raises(FieldError, match="not finite on face 0"):
        tracer.advance(tracer.seed(3), V, 1.0)
    for dt in (np.inf, np.nan, -1.0):
        with pytest.raises(FieldError, match="tracers go"):
            tracer.advance(tracer.seed(3), 0 * np.ones((mesh.n_faces, 3)), dt)


def test_a_path_without_end(monkeypatch: pytest.MonkeyPatch) -> None:
    """What would take too many edges is refused, with what to do."""
    mesh = zoo_mesh("crumpled_torus")
    monkeypatch.setattr(tracer_module, "MOST_CROSSINGS", 50)
    tracer = Tracer(mesh)
    with pytest.raises(ConvergenceError, match="shorter time step"):
        tracer.advance(tracer.seed(9), harmonic_basis(mesh)[0], 1e4)


# -- seeds -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", CLOSED)
def test_seeds_are_even(name: str) -> None:
    """As many in a region as its area has it, to a few; closest pairs further apart than by chance; the same twice."""
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
    """Along the order given, each point stands for the same area: no face is off by more than one."""
    mesh = zoo_mesh("crumpled_torus")
    faces, weights = area_samples(mesh, count)
    found = np.cumsum(np.bincount(faces, minlength=mesh.n_faces))
    expected = count * np.cumsum(mesh.face_areas) / mesh.face_areas.sum()
    assert np.abs(found - expected).max() <= 0.5 + 1e-9
    assert weights.shape == (count, 3)
    assert weights.min() >= 0
    np.testing.assert_allclose(weights.sum(axis=1), 1)


def test_flow_keeps_seeds_even() -> None:
    """A flow without divergence keeps areas: particles stay as evenly spread as they were."""
    mesh = icosphere(3)
    _, V = stream_flow(mesh)
    tracer = Tracer(mesh)
    end = tracer.positions(tracer.advance(tracer.seed(20_000), V, 30 * crossing_time(mesh, V)))
    for axis in range(3):
        assert abs(np.mean(end[:, axis] < 0.3) - 0.65) < 0.006


def test_hilbert_curve() -> None:
    """Each cell of the lattice once, and neighbors on the curve are neighbors in space."""
    cells = np.stack(np.indices((8, 8, 8)), axis=-1).reshape(-1, 3) + 0.5
    keys = hilbert_keys(cells, bits=3)
    np.testing.assert_array_equal(np.sort(keys), np.arange(512))
    np.testing.assert_array_equal(np.abs(np.diff(cells[np.argsort(keys)], axis=0)).sum(axis=1), 1)


# -- memory, and tracers in a fluid ------------------------------------------------------------------------------


def cross_section(mesh: TriangleMesh, tracers: Tracers, time: float) -> np.ndarray:
    """Where the tracers remember that they were."""
    (k,) = np.flatnonzero(np.isclose(tracers.times, time, rtol=1e-9))
    return np.asarray(tracers.past[k])


@pytest.mark.parametrize("steps", [1, 9, 400])
def test_memory(steps: int) -> None:
    """Whatever the steps: the last of the way in places that lie on it, evenly in time, ascending."""
    mesh = icosphere(3)
    V = rigid_field(mesh, Z)
    follow, tracer = Tracing(mesh), Tracer(mesh)
    tracers = follow.start(50)
    start = tracers.particles
    np.testing.assert_array_equal(tracers.past, np.repeat(tracer.positions(start)[None], PLACES, axis=0))
    for k in range(steps):
        tracers = follow.step(tracers, V, 4.0 * (k + 1) / steps)
    assert tracers.past.shape == (PLACES, 50, 3)
    gaps = np.diff(tracers.times)
    assert gaps.min() > 0
    assert gaps.max() < 2.01 * gaps.min()
    assert 0.4 < tracers.time - tracers.times[0] < 2.0  # of √(4π)/√(2/3) · 0.15 = 0.65, at most twice
    for k in (0, 11, PLACES - 1):
        expected = tracer.positions(tracer.advance(start, V, tracers.times[k]))
        np.testing.assert_allclose(tracers.past[k], expected, atol=1e-12)


def test_time_runs_onward() -> None:
    """Not back, and not to infinity."""
    follow = Tracing(icosphere(1))
    tracers = follow.step(follow.start(3), np.zeros((80, 3)), 1.0)
    for time in (0.5, np.inf, np.nan):
        with pytest.raises(FieldError, match="onward"):
            follow.step(tracers, np.zeros((80, 3)), time)


def test_cloud() -> None:
    """Velocity of the face, color between the corners, and the past relative to the present."""
    mesh = icosphere(2)
    V = rigid_field(mesh, Z)
    follow = Tracing(mesh)
    tracers = follow.step(follow.start(40), V, 2.0)
    cloud = follow.cloud(tracers, V, mesh.vertices)
    np.testing.assert_allclose(cloud["color"], cloud.points, atol=1e-15)  # coordinates are a color that is linear
    np.testing.assert_array_equal(cloud["velocity"], V[cloud["face"]])
    np.testing.assert_array_equal(cloud["id"], np.arange(40))
    past = cloud["past"].reshape(40, PLACES, 3).transpose(1, 0, 2) + cloud.points
    np.testing.assert_allclose(past, tracers.past, atol=1e-7)
    assert follow.cloud(tracers, V, mesh.vertices[:, 0])["color"].shape == (40,)


def test_traced_scheme_is_second_order() -> None:
    """Tracers in a flow that changes: halved steps quarter their error."""
    mesh = icosphere(2)

    def end(steps: int) -> np.ndarray:
        scheme = TracedScheme(ConservativeScheme(mesh, filter=False), 100)
        state = scheme.start(3 * random_field(mesh, 1), mesh.vertices[:, 0])
        for _ in range(steps):
            state = scheme.step(state, 0.2 / steps, None)
        return scheme.cloud(state).points

    exact = end(256)
    errors = [np.median(np.linalg.norm(end(steps) - exact, axis=1)) for steps in (8, 16, 32)]
    assert np.log2(errors[0] / errors[1]) > 1.7
    assert np.log2(errors[1] / errors[2]) > 1.7


def test_traced_scheme() -> None:
    """The flow is, to the last bit, that without tracers; they keep up with it, and turn with a solid rotation."""
    mesh = icosphere(3)
    plain, traced = ConservativeScheme(mesh), TracedScheme(ConservativeScheme(mesh), 200)
    V = rossby_haurwitz(plain.model, 4)
    one, two = plain.start(V, mesh.vertices), traced.start(V, mesh.vertices)
    for _ in range(5):
        one, two = plain.step(one, 0.02, None), traced.step(two, 0.02, None)
    for name, values in one.memory.items():
        np.testing.assert_array_equal(two.memory[name], values)
    np.testing.assert_array_equal(one.color, two.color)
    np.testing.assert_array_equal(traced.velocity(two), plain.velocity(one))
    assert tracers_of(two).time == one.time
    assert (np.diff(tracers_of(two).times) >= 0).all()
    assert 0 == tracers_of(two).times[0] < tracers_of(two).times[-1] <= one.time
    # The color is where the fluid was at the start: so are the tracers, but for what the mesh cannot resolve.
    cloud = traced.cloud(two)
    was = Tracer(mesh).positions(Tracer(mesh).seed(200))
    assert np.linalg.norm(cloud["color"] - was, axis=1).max() < 0.01
    assert np.linalg.norm(cloud.points - was, axis=1).max() > 0.1
    with pytest.raises(FieldError, match="no tracers"):
        traced.cloud(one)
