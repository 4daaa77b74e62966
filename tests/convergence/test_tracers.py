"""Convergence of tracers: rotation of the sphere in space, unsteady flow in time."""

import numpy as np

from geomhw.flow.initial_fields import random_field
from geomhw.flow.pathlines import PathlineTracer
from geomhw.flow.streamlines import StreamlineTracer
from geomhw.fluid.conservative import ConservativeScheme
from geomhw.fluid.traced_scheme import TracedScheme
from geomhw.mesh.primitives import icosphere, torus
from geomhw.mesh.sampling import points_on
from geomhw.operators.gradient import gradient
from support.rates import fitted_rate


def test_rotation_converges() -> None:
    """In the flow -n × ∇z on the sphere, particles keep their latitude exactly; their longitude converges with h^1.5.

    The velocity on a face has an error of order h; errors of the faces along the path cancel in part.
    """
    errors, sizes = [], []
    for level in (2, 3, 4):
        mesh = icosphere(level)
        V = -np.cross(mesh.face_normals, (gradient(mesh) @ mesh.vertices[:, 2]).reshape(-1, 3))
        tracer = StreamlineTracer(mesh)
        start = tracer.seeds(400)
        x, y = tracer.positions(start), tracer.positions(tracer.advance(start, V, 1.0))
        turn = np.angle((y[:, 0] + 1j * y[:, 1]) / (x[:, 0] + 1j * x[:, 1]))
        errors.append(np.sqrt(np.mean((np.hypot(x[:, 0], x[:, 1]) * (turn - 1.0)) ** 2)))
        np.testing.assert_allclose(y[:, 2], x[:, 2], atol=1e-14)
        sizes.append(mesh.mean_edge_length)
    assert errors[-1] < 3e-3
    assert fitted_rate(sizes, errors) > 1.4


def test_unsteady_flow_is_second_order() -> None:
    """Tracers in an unsteady flow have an error of order dt², with the velocity of the middle of each step."""
    mesh = torus(24, 12)
    A, B = random_field(mesh, 1), random_field(mesh, 2)
    tracing_ = PathlineTracer(mesh)

    def end(steps: int) -> np.ndarray:
        tracers, dt = tracing_.start(100), 0.2 / steps
        for k in range(steps):
            before, after = (np.cos(9 * t) * A + np.sin(9 * t) * B for t in (k * dt, (k + 1) * dt))
            tracers = tracing_.step(tracers, (before + after) / 2, (k + 1) * dt)
        return points_on(mesh, tracers.points.faces, tracers.points.weights)

    exact, counts = end(512), (8, 16, 32)
    errors = [np.median(np.linalg.norm(end(steps) - exact, axis=1)) for steps in counts]
    assert fitted_rate([0.2 / steps for steps in counts], errors) > 1.8


def test_traced_scheme_is_second_order() -> None:
    """Tracers in a fluid have an error of order dt²."""
    mesh = icosphere(2)

    def end(steps: int) -> np.ndarray:
        scheme = TracedScheme(ConservativeScheme(mesh, filter=False), 100)
        state = scheme.start(3 * random_field(mesh, 1), mesh.vertices[:, 0])
        for _ in range(steps):
            state = scheme.step(state, 0.2 / steps, None)
        return scheme.cloud(state).points

    exact, counts = end(256), (8, 16, 32)
    errors = [np.median(np.linalg.norm(end(steps) - exact, axis=1)) for steps in counts]
    assert fitted_rate([0.2 / steps for steps in counts], errors) > 1.8
