"""Advection by rotations and through open boundaries, its range, and the built-in fields and colors in closed form."""

import numpy as np
import pytest

from geomhw.errors import ConvergenceError
from geomhw.flow.advection import ColorRange, flow_of, frames, integrator_of
from geomhw.flow.bounded_flow import BoundedFlow, inflow_vertices
from geomhw.flow.flow_map import FlowMap
from geomhw.flow.initial_fields import blob, hue_stripes, random_field, rigid_field, rotation_field
from geomhw.io import read_mesh
from geomhw.mesh.primitives import grid, icosphere
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.gradient import gradient_of
from geomhw.options import Integrator
from support.exact import Z, turned_error
from support.hostile import hostile, triangles
from support.meshes import zoo_mesh
from support.reference import needs_reference, reference

INTEGRATORS: tuple[Integrator, ...] = ("bounded", "taylor3", "expm")


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


def wind(mesh: TriangleMesh, x: float, y: float) -> np.ndarray:
    return np.tile([x, y, 0.0], (mesh.n_faces, 1))


def test_boundary_values_are_carried_in() -> None:
    """On the unit square with wind (1, ½) the color at (x, y) is that upstream, or where its path enters."""
    errors = []
    for n in (16, 32, 64):
        mesh = grid(n, n)
        points = mesh.vertices / np.ptp(mesh.vertices, axis=0).max()
        mesh = TriangleMesh(points - points.min(axis=0), mesh.faces)
        x, y, _ = mesh.vertices.T
        back = np.minimum(0.4, np.minimum(x, 2 * y))
        exact = np.sin(3 * (x - back)) + np.cos(2 * (y - back / 2))
        color = np.sin(3 * x) + np.cos(2 * y)
        errors.append(np.abs(BoundedFlow(mesh, wind(mesh, 1.0, 0.5)).advect(color, 0.4) - exact).mean())
    assert errors[-1] < 0.003
    assert errors[0] > 2 * errors[1] > 4 * errors[2]


def test_inflow_is_found_where_the_field_enters() -> None:
    """Wind enters a square through its left side only; a rotation of a disc does not enter."""
    mesh = grid(6, 5)
    left = np.flatnonzero(mesh.vertices[:, 0] == mesh.vertices[:, 0].min())
    corners = np.intersect1d(left, [0, 6, 35, 41])
    found = inflow_vertices(mesh, wind(mesh, 1.0, 0.0))
    np.testing.assert_array_equal(np.setdiff1d(found, corners), np.setdiff1d(left, corners))
    vertices, faces = triangles(24)
    disc = TriangleMesh(vertices, faces)
    assert len(inflow_vertices(disc, rigid_field(disc, Z))) == 0
    assert len(inflow_vertices(icosphere(2), rigid_field(icosphere(2), Z))) == 0


RANGE_MESHES = [
    "needle_6",
    "sheared",
    "fan_1000",
    "bow_tie",
    "hourglass",
    "book_3",
    "moebius",
    "klein",
    "doubled",
    "tube",
]


@pytest.mark.parametrize("kind", ["rotation", "random", "gradient", "noise"])
def test_colors_keep_their_range(kind: str) -> None:
    """Fields with sources, sinks and inflow keep colors within their range on any mesh, constants included."""
    meshes = {name: hostile(name) for name in RANGE_MESHES}
    meshes |= {name: zoo_mesh(name) for name in ("torus", "crumpled_sphere", "annulus")}
    for name, mesh in meshes.items():
        rng = np.random.default_rng(2)
        V = {
            "rotation": lambda mesh=mesh: rotation_field(mesh, np.array([1.0, 0, 0])),
            "random": lambda mesh=mesh: random_field(mesh, 1),
            "gradient": lambda mesh=mesh: gradient_of(mesh, np.sin(5 * mesh.vertices[:, 0] / np.ptp(mesh.vertices))),
            "noise": lambda mesh=mesh, rng=rng: rng.normal(size=(mesh.n_faces, 3)),
        }[kind]()
        flow = flow_of(mesh, V)
        assert isinstance(flow, BoundedFlow)
        colors = np.stack([np.ones(mesh.n_vertices), rng.random(mesh.n_vertices)], axis=1)
        dt = 0.4 / (flow._norm or 1.0)
        *_, last = frames(flow, colors, dt, 60, 60)
        assert last["color"].min() >= colors.min() - 1e-12, name
        assert last["color"].max() <= 1 + 1e-12, name
        np.testing.assert_allclose(last["color"][:, 0], 1, atol=1e-12)


def test_growth_is_reported_and_stops() -> None:
    """The exponential of a field through the boundary leaves the range from some step on, and does not run away."""
    mesh = grid(20, 20)
    V, color = rigid_field(mesh, Z), mesh.vertices[:, 0]
    limits = ColorRange(color)
    with pytest.raises(ConvergenceError, match="step"):
        list(frames(flow_of(mesh, V, "taylor3"), color, 0.1, 400, 10, limits))
    assert limits.since is not None
    assert 0.01 < limits.excess <= 10
    *_, last = frames(flow_of(mesh, V), color, 0.1, 400, 10)
    assert color.min() <= last["color"].min() <= last["color"].max() <= color.max()


def test_handouts_sphere() -> None:
    """Only on the handout's own sphere the default is the handout's exponential."""
    assert integrator_of(icosphere(3), "auto") == "bounded"


@needs_reference
def test_default_on_the_handouts_sphere() -> None:
    """On the handout's own sphere the default is the handout's exponential."""
    mesh = read_mesh(reference("meshes/closed/spherers.off"))
    assert integrator_of(mesh, "auto") == "taylor3"
