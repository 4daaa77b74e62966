"""Advection by a rigid rotation of the sphere, and the built-in fields and colors in closed form."""

import numpy as np
import pytest

from geomhw.flow.flow_map import FlowMap
from geomhw.flow.initial_fields import blob, hue_stripes, rigid_field, rotation_field
from geomhw.mesh.primitives import grid, icosphere
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.options import Integrator
from support.exact import Z, turned_error

INTEGRATORS: tuple[Integrator, ...] = ("taylor3", "expm")


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_quarter_turn_is_downstream(integrator: Integrator) -> None:
    """A function turned by 90° matches the exact one to 1 %; carried upstream it would be wrong everywhere."""
    assert turned_error(4, integrator, np.pi / 2)[0] < 0.01


def test_blob_is_found_downstream() -> None:
    """A blob on the equator moves with the flow: after time 1 its center stands at an angle of 1 radian."""
    mesh = icosphere(4)
    start = int((mesh.vertices @ [1, 0, 0]).argmax())
    carried = FlowMap(mesh, rigid_field(mesh, Z)).advect(blob(mesh, start), 1.0)
    weight = mesh.vertex_areas * np.maximum(carried, 0)
    x, y, _ = weight @ mesh.vertices
    assert np.arctan2(y, x) == pytest.approx(1.0, abs=0.02)


def test_handouts_defaults() -> None:
    """The rotation field is (0, -z, y), tangential, of length 10 h; hues are pure colors."""
    mesh = icosphere(3)
    V = rotation_field(mesh, np.array([1.0, 0, 0]))
    np.testing.assert_allclose(np.linalg.norm(V, axis=1), 10 * mesh.mean_edge_length)
    x, y, z = mesh.face_centers.T
    along = np.stack([0 * x, -z, y], axis=1)
    assert (np.einsum("fx,fx->f", V, along) > 0).all()
    colors = hue_stripes(mesh)
    np.testing.assert_allclose(colors.max(axis=1), 1)
    np.testing.assert_allclose(colors.min(axis=1), 0)
    red = np.cos(3 * mesh.vertices[:, 2]) ** 2 > 1 - 1e-12
    np.testing.assert_allclose(colors[red], np.broadcast_to([1.0, 0, 0], colors[red].shape), atol=1e-9)


def test_hues_along_an_axis() -> None:
    """Hue stripes along an axis depend on the relative height only: not on scale, position or orientation."""
    mesh = icosphere(2)
    given = hue_stripes(mesh)
    np.testing.assert_allclose(hue_stripes(mesh, np.array([0, 0, 5.0])), given, atol=1e-12)
    moved = TriangleMesh(300 * mesh.vertices[:, [1, 2, 0]] + [7, 80, -9], mesh.faces)
    np.testing.assert_allclose(hue_stripes(moved, np.array([0, 1.0, 0])), given, atol=1e-9)
    flat = hue_stripes(grid(3, 3), np.array([0, 0, 1.0]))
    np.testing.assert_allclose(flat, np.broadcast_to([1.0, 0, 0], flat.shape), atol=1e-12)
