"""Tracers along exact paths: straight lines, turns, edges, boundaries, sources and sinks."""

import numpy as np
import pytest

from geomhw.flow import streamlines
from geomhw.flow.streamlines import FacePoints, StreamlineTracer
from geomhw.flow.tangent_fields import tangential
from geomhw.mesh.primitives import cylinder_band, grid, icosphere
from geomhw.mesh.triangle_mesh import TriangleMesh
from support.exact import Z


@pytest.mark.parametrize("direction", [(1.0, 0.0), (0.0, -1.0), (1.0, 1.0), (0.83, 0.31)])
def test_straight_lines(direction: tuple[float, float]) -> None:
    """In a uniform flow on a flat grid, a particle moves to x + tV, to rounding."""
    mesh = grid(16, 12, 4.0, 3.0)
    V = np.tile([*direction, 0.0], (mesh.n_faces, 1))
    tracer = StreamlineTracer(mesh)
    start = tracer.seeds(400)
    x = tracer.positions(start)
    end = x + 0.9 * V[0]
    inside = ((end[:, :2] > 0.01) & (end[:, :2] < [3.99, 2.99])).all(axis=1)
    assert inside.sum() > 100
    np.testing.assert_allclose(tracer.positions(tracer.advance(start, V, 0.9))[inside], end[inside], atol=1e-14)


def test_along_the_edges_of_a_grid() -> None:
    """Particles on vertices and edge midpoints move along grid edges exactly, also through vertices."""
    mesh = grid(10, 10, 10.0, 10.0, diagonal="uniform")
    V = np.tile([1.0, 0.0, 0.0], (mesh.n_faces, 1))
    inner = np.flatnonzero((mesh.face_centers[:, 0] < 3) & (np.abs(mesh.face_centers[:, 1] - 5) < 3))
    faces, corner = np.repeat(inner, 3), np.tile([0, 1, 2], len(inner))
    for weights in (np.eye(3)[corner], (1 - np.eye(3)[corner]) / 2):  # vertices; midpoints of edges
        start = FacePoints(faces, weights)
        tracer = StreamlineTracer(mesh)
        end = tracer.positions(tracer.advance(start, V, 5.25))
        np.testing.assert_allclose(end, tracer.positions(start) + V[0] * 5.25, atol=1e-13)


def test_round_a_cylinder() -> None:
    """Round a prism of 24 sides, particles advance by one side per unit of time, to rounding."""
    mesh = cylinder_band(24, 6)
    V = tangential(mesh, np.cross(Z, mesh.face_centers))
    V *= (2 * np.sin(np.pi / 24) / np.linalg.norm(V, axis=1))[:, None]
    tracer = StreamlineTracer(mesh)
    start = tracer.seeds(200)
    x = tracer.positions(start)
    c, s = np.cos(np.pi / 12), np.sin(np.pi / 12)
    side = x @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    np.testing.assert_allclose(tracer.positions(tracer.advance(start, V, 1.0)), side, atol=1e-13)
    np.testing.assert_allclose(tracer.positions(tracer.advance(start, V, 24.0)), x, atol=1e-12)
    np.testing.assert_allclose(tracer.positions(tracer.advance(start, V, 24e6 + 1)), side, atol=1e-7)


def two_faces(left: list[float], right: list[float]) -> tuple[TriangleMesh, np.ndarray]:
    """Return two faces on either side of an edge from (0, 0) to (0, 10), and a vector on each."""
    mesh = TriangleMesh([[0, 0, 0], [0, 10, 0], [-8, 5, 0], [8, 5, 0]], [[0, 1, 2], [1, 0, 3]])
    return mesh, np.array([[*left, 0.0], [*right, 0.0]])


def test_against_each_other() -> None:
    """Where fields on both sides push into an edge, particles slide along it by Filippov's mean of both."""
    mesh, V = two_faces([3.0, 1.0], [-1.0, 2.0])  # a quarter of the first and three of the second
    tracer = StreamlineTracer(mesh)
    start = FacePoints(np.array([0, 1]), np.array([[0.5, 0.4, 0.1], [0.4, 0.5, 0.1]]))  # at (-0.8, 4.5), (0.8, 4.5)
    arrival = np.array([0.8 / 3, 0.8])
    y = tracer.positions(start)[:, 1] + arrival * [1.0, 2.0] + (1.5 - arrival) * 1.75
    np.testing.assert_allclose(
        tracer.positions(tracer.advance(start, V, 1.5)), np.stack([0 * y, y, 0 * y], axis=1), atol=1e-14
    )


def test_along_the_boundary() -> None:
    """At the boundary, particles slide along it by the tangential component, and stop in the corner."""
    mesh = grid(6, 4, 6.0, 4.0)
    V = np.tile([1.0, 0.5, 0.0], (mesh.n_faces, 1))
    tracer = StreamlineTracer(mesh)
    start = tracer.seeds(150)
    x = tracer.positions(start)
    dt = 3.3
    for time in (dt, 40.0):
        end = tracer.positions(tracer.advance(start, V, time))
        np.testing.assert_allclose(end, np.minimum(x + time * V[0], [6.0, 4.0, 0.0]), atol=1e-12)


def test_sources_and_sinks() -> None:
    """Particles end in a sink on time; a particle on a source leaves it."""
    mesh = icosphere(3)
    V = tangential(mesh, np.broadcast_to(-Z, (mesh.n_faces, 3)))
    tracer = StreamlineTracer(mesh)
    end = tracer.positions(tracer.advance(tracer.seeds(200), V, 100.0))
    np.testing.assert_allclose(end, np.tile(end[:1], (200, 1)), atol=1e-12)
    assert end[0, 2] == mesh.vertices[:, 2].min()
    off = tracer.advance(tracer.advance(tracer.seeds(5), V, 100.0), -V, 4.0)
    assert (tracer.positions(off)[:, 2] > -0.9).all()


def wheel(turn: float, inward: float) -> tuple[TriangleMesh, np.ndarray]:
    """Return six faces round the origin, and a field that turns about it and approaches it."""
    rim = np.exp(2j * np.pi * np.arange(6) / 6)
    vertices = np.concatenate([np.zeros((1, 3)), np.stack([rim.real, rim.imag, 0 * rim.real], axis=1)])
    mesh = TriangleMesh(vertices, [[0, 1 + k, 1 + (k + 1) % 6] for k in range(6)])
    return mesh, turn * np.cross(Z, mesh.face_centers) - inward * mesh.face_centers


def test_closed_turns() -> None:
    """Round a vertex, a closed path has a period, and 10⁶ periods change nothing."""
    mesh, V = wheel(1.0, 0.0)
    tracer = StreamlineTracer(mesh)
    start = FacePoints(np.array([2]), np.array([[0.9, 0.06, 0.04]]))
    # The sides of the hexagon through the particle are as long as its distance from the center.
    period = 6 * 0.1 / np.linalg.norm(V[0])
    for turns in (1, 3, 10**6):
        end = tracer.positions(tracer.advance(start, V, turns * period))
        np.testing.assert_allclose(end, tracer.positions(start), atol=1e-13 * turns)


def test_spirals() -> None:
    """On a slow spiral one long step equals 100 short ones: it is not taken for a closed path."""
    mesh, V = wheel(1.0, 1e-4)
    tracer = StreamlineTracer(mesh)
    start = parts = FacePoints(np.array([2]), np.array([[0.9, 0.06, 0.04]]))
    for _ in range(100):
        parts = tracer.advance(parts, V, 0.2)
    whole = tracer.advance(start, V, 20.0)
    np.testing.assert_allclose(tracer.positions(whole), tracer.positions(parts), atol=1e-12)
    assert 1 - whole.weights[0, 0] < 0.99 * (1 - start.weights[0, 0])


def test_spirals_end(monkeypatch: pytest.MonkeyPatch) -> None:
    """Spirals into a vertex are cut off near the center."""
    monkeypatch.setattr(streamlines, "MOST_CROSSINGS", 100)
    mesh, V = wheel(1.0, 1e-4)
    near = FacePoints(np.array([2]), np.array([[1 - 8e-4, 4e-4, 4e-4]]))
    end = StreamlineTracer(mesh).positions(StreamlineTracer(mesh).advance(near, V, 20.0))
    assert np.linalg.norm(end) < streamlines.CORE


def test_the_fastest_way_off() -> None:
    """From a vertex that all faces lead away from, a particle follows the fastest face."""
    mesh, V = wheel(0.0, -1.0)
    for fastest in range(6):
        W = V * np.where(np.arange(6) == fastest, 3.0, 2.0)[:, None]
        for face in range(6):
            at_vertex = FacePoints(np.array([face]), np.array([[1.0, 0.0, 0.0]]))
            end = StreamlineTracer(mesh).positions(StreamlineTracer(mesh).advance(at_vertex, W, 0.1))
            np.testing.assert_allclose(end[0], 0.1 * W[fastest], atol=1e-15)
