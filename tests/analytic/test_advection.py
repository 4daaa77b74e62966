"""The operator approach: exact rotation of the sphere, downstream, bounds of a step, and refusals."""

import numpy as np
import pytest
from conftest import zoo_mesh
from scipy.sparse.linalg import expm_multiply

from geomhw.errors import ConvergenceError, FieldError
from geomhw.flow.flow_map import FlowMap, frames
from geomhw.flow.initial_fields import blob, hue_stripes, random_field, rigid_field, rotation_field
from geomhw.mesh.primitives import grid, icosphere
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.options import Integrator
from geomhw.solvers.expm import expm

INTEGRATORS: tuple[Integrator, ...] = ("taylor3", "expm")
Z = np.array([0.0, 0.0, 1.0])


def smooth(points: np.ndarray) -> np.ndarray:
    """A function with no symmetry about the axis."""
    x, y, z = points.T
    return np.exp(2 * x) + x * y - z


def turned_error(level: int, integrator: Integrator, angle: float) -> tuple[float, float]:
    """Relative L2 error of a function carried round by that angle, and h."""
    mesh = icosphere(level)
    carried = FlowMap(mesh, rigid_field(mesh, Z), integrator).carry(smooth(mesh.vertices), angle)
    c, s = np.cos(-angle), np.sin(-angle)
    back = mesh.vertices @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]).T
    exact = smooth(back)
    norm = np.sqrt(mesh.vertex_areas @ exact**2)
    return float(np.sqrt(mesh.vertex_areas @ (carried - exact) ** 2) / norm), mesh.mean_edge_length


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_rigid_rotation_converges(integrator: Integrator) -> None:
    """After one turn the function is back, up to h²: 9.5, 2.5, 0.7 % on 642, 2,562, 10,242 vertices."""
    errors, sizes = zip(*(turned_error(level, integrator, 2 * np.pi) for level in (3, 4, 5)), strict=True)
    assert all(error <= bound for error, bound in zip(errors, (0.1, 0.026, 0.0068), strict=True)), errors
    assert np.polyfit(np.log(sizes), np.log(errors), 1)[0] > 1.9


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_quarter_turn_is_downstream(integrator: Integrator) -> None:
    """A quarter of a turn, where going upstream would be wrong by as much as the function varies."""
    assert turned_error(4, integrator, np.pi / 2)[0] < 0.01


def test_blob_is_found_downstream() -> None:
    """The middle of a blob on the equator moves with the flow, counterclockwise."""
    mesh = icosphere(4)
    start = int((mesh.vertices @ [1, 0, 0]).argmax())
    carried = FlowMap(mesh, rigid_field(mesh, Z)).carry(blob(mesh, start), 1.0)
    weight = mesh.vertex_areas * np.maximum(carried, 0)
    x, y, _ = weight @ mesh.vertices
    assert np.arctan2(y, x) == pytest.approx(1.0, abs=0.02)


def test_flow_map_is_the_exponential(mesh: TriangleMesh) -> None:
    """Both integrators agree with scipy's expm, in several columns at once."""
    V = np.cross([0.2, -0.5, 1.0], mesh.face_centers)
    f = np.stack([np.sin(mesh.vertices @ [1.0, 2.0, -1.0]), mesh.vertices[:, 0]], axis=1)
    flow = FlowMap(mesh, V, "expm")
    t = 0.3 / abs(flow.operator).max()
    expected = expm_multiply(t * flow.operator.tocsc(), f)
    np.testing.assert_allclose(flow.pull_back(f, t), expected, atol=1e-12 * np.abs(f).max())
    # Each of the two substeps of I + sD + s²D²/2 leaves out s³D³/6.
    np.testing.assert_allclose(FlowMap(mesh, V).pull_back(f, t), expected, atol=2e-2 * np.abs(f).max())


def test_taylor3_is_the_handouts() -> None:
    """A small step is exactly I + tD + t²D²/2, not split."""
    mesh = zoo_mesh("torus")
    flow = FlowMap(mesh, rotation_field(mesh, Z))
    f, t = mesh.vertices[:, 0], 0.0005
    D = flow.operator
    np.testing.assert_array_equal(flow.pull_back(f, t), f + t * (D @ f) + (t * t / 2) * (D @ (D @ f)))


def test_group_property() -> None:
    """Forth and back is where it began; two halves make a whole."""
    mesh = zoo_mesh("torus")
    flow = FlowMap(mesh, rigid_field(mesh, Z), "expm")
    f = mesh.vertices[:, 0]
    np.testing.assert_allclose(flow.pull_back(flow.carry(f, 0.7), 0.7), f, atol=1e-11)
    np.testing.assert_allclose(flow.carry(flow.carry(f, 0.3), 0.4), flow.carry(f, 0.7), atol=1e-11)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_large_steps_are_split(integrator: Integrator) -> None:
    """A step of two hundred cells stays bounded, and constants stay what they are."""
    mesh = icosphere(3)
    flow = FlowMap(mesh, rigid_field(mesh, Z), integrator)
    f = mesh.vertices[:, 0]
    assert np.abs(flow.carry(f, 30.0)).max() < 2
    np.testing.assert_allclose(flow.carry(np.ones_like(f), 30.0), 1, atol=1e-10)
    with pytest.raises(ConvergenceError, match="shorter step"):
        flow.carry(f, 1e12)


@pytest.mark.parametrize("factor", [1e-6, 1e6])
def test_scale(factor: float) -> None:
    """Rotation fields turn the same angle on a mesh of any size."""
    mesh = zoo_mesh("torus")
    large = TriangleMesh(mesh.vertices * factor, mesh.faces)
    f = mesh.vertices[:, 0]
    for make in (rigid_field, rotation_field, lambda m, _: random_field(m, 3)):
        small = FlowMap(mesh, make(mesh, Z)).carry(f, 0.5)
        np.testing.assert_allclose(FlowMap(large, make(large, Z)).carry(f, 0.5), small, atol=1e-9)


def test_random_field_is_renumbered_with_the_mesh() -> None:
    """The random flow is a function of place and seed, not of indices; its largest speed is 10 h."""
    mesh = zoo_mesh("torus")
    order = np.random.default_rng(0).permutation(mesh.n_faces)
    V = random_field(mesh, 5)
    np.testing.assert_allclose(random_field(TriangleMesh(mesh.vertices, mesh.faces[order]), 5), V[order], atol=1e-12)
    assert np.linalg.norm(V, axis=1).max() == pytest.approx(10 * mesh.mean_edge_length)
    assert np.abs(random_field(mesh, 6) - V).max() > 0.1


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
    """From -1 to 1 over the mesh they are those of z, and they stay so at any size, place and way it is turned."""
    mesh = icosphere(2)
    given = hue_stripes(mesh)
    np.testing.assert_allclose(hue_stripes(mesh, np.array([0, 0, 5.0])), given, atol=1e-12)
    moved = TriangleMesh(300 * mesh.vertices[:, [1, 2, 0]] + [7, 80, -9], mesh.faces)
    np.testing.assert_allclose(hue_stripes(moved, np.array([0, 1.0, 0])), given, atol=1e-9)
    flat = hue_stripes(grid(3, 3), np.array([0, 0, 1.0]))
    np.testing.assert_allclose(flat, np.broadcast_to([1.0, 0, 0], flat.shape), atol=1e-12)


def test_frames() -> None:
    """A frame at the start, each so many steps, and at the last; their report is of the color."""
    mesh = zoo_mesh("sphere")
    flow = FlowMap(mesh, rigid_field(mesh, Z))
    seen = list(frames(flow, mesh.vertices[:, 0], 0.01, 7, 3))
    assert [frame.report["step"] for frame in seen] == [0, 3, 6, 7]
    assert [frame.report["time"] for frame in seen] == pytest.approx([0, 0.03, 0.06, 0.07])
    assert seen[-1].report["color_mean"] == pytest.approx(0, abs=1e-12)
    np.testing.assert_array_equal(
        seen[1]["color"], flow.carry(flow.carry(flow.carry(mesh.vertices[:, 0], 0.01), 0.01), 0.01)
    )


def test_refusals() -> None:
    """Bad fields, functions, times and integrators each have their sentence."""
    mesh = zoo_mesh("sphere")
    V = rigid_field(mesh, Z)
    with pytest.raises(FieldError, match=r"\(1280, 3\)"):
        FlowMap(mesh, V[:5])
    bad = V.copy()
    bad[4] = np.nan
    with pytest.raises(FieldError, match="face 4"):
        FlowMap(mesh, bad)
    with pytest.raises(FieldError, match="taylor3, expm"):
        FlowMap(mesh, V, "euler")  # type: ignore[arg-type]
    flow = FlowMap(mesh, V)
    with pytest.raises(FieldError, match="642 values"):
        flow.carry(np.zeros(7), 1.0)
    with pytest.raises(FieldError, match="vertex 9"):
        flow.carry(np.where(np.arange(642) == 9, np.nan, 0.0), 1.0)
    for dt, steps, every, words in ((0.0, 1, 1, "positive"), (np.nan, 1, 1, "positive"), (1.0, 0, 1, "one step")):
        with pytest.raises(FieldError, match=words):
            list(frames(flow, mesh.vertices[:, 0], dt, steps, every))
    with pytest.raises(FieldError, match="axis"):
        rigid_field(mesh, np.zeros(3))
    with pytest.raises(FieldError, match="vertex 642"):
        blob(mesh, 642)


def test_series_of_a_nilpotent_matrix() -> None:
    """exp of a shift is the binomial row, exactly."""
    import scipy.sparse as sp

    shift = sp.diags_array([np.ones(4)], offsets=[-1], shape=(5, 5)).tocsr()
    np.testing.assert_allclose(expm(shift, 1.0, np.eye(5)[0]), [1, 1, 1 / 2, 1 / 6, 1 / 24], rtol=1e-14)
