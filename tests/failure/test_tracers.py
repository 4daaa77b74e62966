"""Tracers refuse non-manifold meshes, fields and times that are not finite, and endless paths."""

import numpy as np
import pytest

from geomhw.errors import ConvergenceError, FieldError, MeshError
from geomhw.flow import streamlines
from geomhw.flow.harmonic import harmonic_basis
from geomhw.flow.pathlines import PathlineTracer
from geomhw.flow.streamlines import StreamlineTracer
from geomhw.mesh.primitives import icosphere
from geomhw.mesh.triangle_mesh import TriangleMesh
from support.meshes import zoo_mesh


def test_refusals() -> None:
    """Non-manifold meshes, faces of zero area, no tracers, and fields or times that are not finite raise."""
    fan = TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0, -1, 0]], [[0, 1, 2], [0, 1, 3], [0, 1, 4]])
    with pytest.raises(MeshError, match="manifold"):
        StreamlineTracer(fan)
    with pytest.raises(MeshError, match="zero area"):
        StreamlineTracer(TriangleMesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]]))
    mesh = icosphere(1)
    tracer = StreamlineTracer(mesh)
    with pytest.raises(FieldError, match="not 0"):
        tracer.seeds(0)
    V = np.full((mesh.n_faces, 3), np.nan)
    with pytest.raises(FieldError, match="not finite on face 0"):
        tracer.advance(tracer.seeds(3), V, 1.0)
    for dt in (np.inf, np.nan, -1.0):
        with pytest.raises(FieldError, match="tracers move"):
            tracer.advance(tracer.seeds(3), 0 * np.ones((mesh.n_faces, 3)), dt)


def test_a_path_without_end(monkeypatch: pytest.MonkeyPatch) -> None:
    """A path with too many edges raises, and suggests a shorter step."""
    mesh = zoo_mesh("crumpled_torus")
    monkeypatch.setattr(streamlines, "MOST_CROSSINGS", 50)
    tracer = StreamlineTracer(mesh)
    with pytest.raises(ConvergenceError, match="shorter time step"):
        tracer.advance(tracer.seeds(9), harmonic_basis(mesh)[0], 1e4)


def test_time_runs_onward() -> None:
    """Times before the present, or not finite, raise."""
    follow = PathlineTracer(icosphere(1))
    tracers = follow.step(follow.start(3), np.zeros((80, 3)), 1.0)
    for time in (0.5, np.inf, np.nan):
        with pytest.raises(FieldError, match="onward"):
            follow.step(tracers, np.zeros((80, 3)), time)
