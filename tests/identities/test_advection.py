"""Identities of the flow map: the exponential, group property, invariances, frames of a run."""

import numpy as np
import pytest
from scipy.sparse.linalg import expm_multiply

from geomhw.errors import ConvergenceError
from geomhw.flow.advection import frames
from geomhw.flow.flow_map import FlowMap
from geomhw.flow.initial_fields import random_field, rigid_field, rotation_field
from geomhw.mesh.primitives import icosphere
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.options import FlowSeries
from geomhw.solvers.expm import expm
from support.exact import Z
from support.meshes import zoo_mesh

INTEGRATORS: tuple[FlowSeries, ...] = ("taylor3", "expm")


def test_flow_map_is_the_exponential(mesh: TriangleMesh) -> None:
    """Both integrators equal scipy's exponential, for several columns."""
    V = np.cross([0.2, -0.5, 1.0], mesh.face_centers)
    f = np.stack([np.sin(mesh.vertices @ [1.0, 2.0, -1.0]), mesh.vertices[:, 0]], axis=1)
    flow = FlowMap(mesh, V, "expm")
    t = 0.3 / abs(flow.operator).max()
    expected = expm_multiply(t * flow.operator.tocsc(), f)
    np.testing.assert_allclose(flow.pull_back(f, t), expected, atol=1e-12 * np.abs(f).max())
    # Each of the two substeps of I + sD + s²D²/2 leaves out s³D³/6.
    np.testing.assert_allclose(FlowMap(mesh, V).pull_back(f, t), expected, atol=2e-2 * np.abs(f).max())


def test_taylor3_is_the_handouts() -> None:
    """A short step is exactly I + tD + t²D²/2."""
    mesh = zoo_mesh("torus")
    flow = FlowMap(mesh, rotation_field(mesh, Z))
    f, t = mesh.vertices[:, 0], 0.0005
    D = flow.operator
    np.testing.assert_array_equal(flow.pull_back(f, t), f + t * (D @ f) + (t * t / 2) * (D @ (D @ f)))


def test_group_property() -> None:
    """exp(-tD) exp(tD) = 1 and exp(sD) exp(tD) = exp((s + t)D)."""
    mesh = zoo_mesh("torus")
    flow = FlowMap(mesh, rigid_field(mesh, Z), "expm")
    f = mesh.vertices[:, 0]
    np.testing.assert_allclose(flow.pull_back(flow.advect(f, 0.7), 0.7), f, atol=1e-11)
    np.testing.assert_allclose(flow.advect(flow.advect(f, 0.3), 0.4), flow.advect(f, 0.7), atol=1e-11)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_large_steps_are_split(integrator: FlowSeries) -> None:
    """A step of 200 cells stays bounded and keeps constants; a step of 10¹² raises."""
    mesh = icosphere(3)
    flow = FlowMap(mesh, rigid_field(mesh, Z), integrator)
    f = mesh.vertices[:, 0]
    assert np.abs(flow.advect(f, 30.0)).max() < 2
    np.testing.assert_allclose(flow.advect(np.ones_like(f), 30.0), 1, atol=1e-10)
    with pytest.raises(ConvergenceError, match="shorter step"):
        flow.advect(f, 1e12)


@pytest.mark.parametrize("factor", [1e-6, 1e6])
def test_scale(factor: float) -> None:
    """Rotation fields turn by the same angle on a mesh of any scale."""
    mesh = zoo_mesh("torus")
    large = TriangleMesh(mesh.vertices * factor, mesh.faces)
    f = mesh.vertices[:, 0]
    for make in (rigid_field, rotation_field, lambda m, _: random_field(m, 3)):
        small = FlowMap(mesh, make(mesh, Z)).advect(f, 0.5)
        np.testing.assert_allclose(FlowMap(large, make(large, Z)).advect(f, 0.5), small, atol=1e-9)


def test_random_field_is_renumbered_with_the_mesh() -> None:
    """The random field is a function of position and seed, not of indices; its largest speed is 10 h."""
    mesh = zoo_mesh("torus")
    order = np.random.default_rng(0).permutation(mesh.n_faces)
    V = random_field(mesh, 5)
    np.testing.assert_allclose(random_field(TriangleMesh(mesh.vertices, mesh.faces[order]), 5), V[order], atol=1e-12)
    assert np.linalg.norm(V, axis=1).max() == pytest.approx(10 * mesh.mean_edge_length)
    assert np.abs(random_field(mesh, 6) - V).max() > 0.1


def test_frames() -> None:
    """Frames come at the start, every k steps and at the end, with the steps composed one by one."""
    mesh = zoo_mesh("sphere")
    flow = FlowMap(mesh, rigid_field(mesh, Z))
    seen = list(frames(flow, mesh.vertices[:, 0], 0.01, 7, 3))
    assert [frame.report["step"] for frame in seen] == [0, 3, 6, 7]
    assert [frame.report["time"] for frame in seen] == pytest.approx([0, 0.03, 0.06, 0.07])
    assert seen[-1].report["color_mean"] == pytest.approx(0, abs=1e-12)
    np.testing.assert_array_equal(
        seen[1]["color"], flow.advect(flow.advect(flow.advect(mesh.vertices[:, 0], 0.01), 0.01), 0.01)
    )


def test_series_of_a_nilpotent_matrix() -> None:
    """The exponential of a nilpotent shift is the row 1/k!."""
    import scipy.sparse as sp

    shift = sp.diags_array([np.ones(4)], offsets=[-1], shape=(5, 5)).tocsr()
    np.testing.assert_allclose(expm(shift, 1.0, np.eye(5)[0]), [1, 1, 1 / 2, 1 / 6, 1 / 24], rtol=1e-14)
