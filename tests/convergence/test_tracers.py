"""Convergence of tracers: rotation of the sphere in space, unsteady flow in time."""

import numpy as np

from geomhw.flow.initial_fields import random_field
from geomhw.flow.tracer import Tracer
from geomhw.flow.tracer_cloud import Tracing
from geomhw.fluid.conservative import ConservativeScheme
from geomhw.fluid.traced import TracedScheme
from geomhw.mesh.primitives import icosphere, torus
from geomhw.mesh.sampling import points_on
from geomhw.operators.gradient import gradient


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
