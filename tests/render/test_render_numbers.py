"""Views, color limits, ticks, arrow positions, isolines and creases."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from geomhw.mesh import genus_two, primitives
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.render import colors, glyphs, window
from geomhw.render.arrow_places import arrow_places
from geomhw.render.curve_pictures import _subdivided
from geomhw.render.layers import Arrows, Surface
from geomhw.render.scene import Stage
from geomhw.render.view import View, choose_view, surface_samples
from support.pictures import needs_opengl

BALL = primitives.icosphere(3)


# -- views -------------------------------------------------------------------------------------------------------


def rotated(mesh, *order):
    """Rename the axes, and keep the orientation."""
    return TriangleMesh(mesh.vertices[:, order], mesh.faces)


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 0, 1), (1, 2, 0)], ids=["xy", "yz", "zx"])
def test_flat_mesh_is_seen_from_its_normal(order):
    """A flat mesh is seen along its normal."""
    mesh = rotated(primitives.grid(12, 8, 3.0, 2.0), *order)
    view = choose_view(mesh)
    np.testing.assert_allclose(view.axes[2], mesh.face_normals[0], atol=1e-9)


def test_upright_plane_keeps_y_up():
    """A plane in x and y keeps y upward."""
    view = choose_view(primitives.grid(12, 8, 3.0, 2.0))
    np.testing.assert_allclose(view.axes, np.eye(3), atol=1e-9)
    np.testing.assert_allclose(view.extent, [1.5, 1.0])


def test_tall_strip_is_laid_across():
    """A tall strip is laid across."""
    strip = primitives.strip(100)
    tall = TriangleMesh(strip.vertices[:, [1, 0, 2]] * [-1, 1, 1], strip.faces)
    assert choose_view(tall).aspect == pytest.approx(100)


def test_solid_is_upright_and_seen_from_a_little_above():
    """A solid is upright, and seen from slightly above."""
    mesh = TriangleMesh(BALL.vertices * [1.0, 1.5, 0.7], BALL.faces)
    right, up, toward = choose_view(mesh).axes
    assert right[1] == pytest.approx(0, abs=1e-12)
    assert up[1] > 0.7
    assert 0.2 < toward[1] < 0.7
    np.testing.assert_allclose(choose_view(mesh).axes @ choose_view(mesh).axes.T, np.eye(3), atol=1e-12)


def test_samples_do_not_depend_on_the_order_of_faces():
    """Where faces are the children of coarser ones, one kind after the other, samples leave no gap."""
    fine, _ = _subdivided(BALL, np.zeros(BALL.n_vertices))
    assert fine.n_faces > 80_000
    places = surface_samples(fine, 10_000)
    gap = cKDTree(places).query(fine.face_centers)[0].max()
    assert gap < 2.5 * np.sqrt(fine.face_areas.sum() / len(places))


def test_broad_side_is_shown():
    """A slab is seen nearly face on."""
    for thin in (0, 2):
        shape = np.ones(3)
        shape[thin] = 0.1
        toward = choose_view(TriangleMesh(BALL.vertices * shape, BALL.faces)).axes[2]
        assert abs(toward[thin]) > 0.75


def test_head_looks_our_way():
    """Of a body with a head at one end, the head is nearer to the viewer."""
    body = BALL.vertices * [2.0, 0.7, 0.7]
    head = BALL.vertices * 0.6 + [1.8, 1.2, 0.0]
    for flip in (1.0, -1.0):
        points = np.concatenate([body, head]) * [flip, 1.0, 1.0]
        faces = np.concatenate([BALL.faces, BALL.faces + BALL.n_vertices])
        toward = choose_view(TriangleMesh(points, faces[:, ::-1] if flip < 0 else faces)).axes[2]
        assert toward[0] * flip > 0.3


@pytest.mark.parametrize(("scale", "shift"), [(1e-6, 0), (1e6, 0), (1, 1e6)])
def test_view_is_independent_of_scale_and_place(scale, shift):
    """The view does not depend on scale and position."""
    mesh = primitives.torus(40, 20)
    moved = TriangleMesh(mesh.vertices * scale + shift, mesh.faces)
    view, other = choose_view(mesh, [3]), choose_view(moved, [3])
    np.testing.assert_allclose(view.axes, other.axes, atol=1e-6)
    np.testing.assert_allclose(view.extent * scale, other.extent, rtol=1e-6)


def test_stray_vertices_do_not_count():
    """Vertices without faces do not change the view."""
    stray = TriangleMesh([*BALL.vertices, [100.0, 0, 0]], BALL.faces)
    np.testing.assert_allclose(choose_view(stray).extent, choose_view(BALL).extent)


def test_projection_fits_the_extent():
    """The projected mesh fills the extent."""
    mesh = genus_two(24)
    view = choose_view(mesh)
    seen = view.project(mesh.vertices)[:, :2]
    np.testing.assert_allclose(seen.max(axis=0), view.extent)
    np.testing.assert_allclose(seen.min(axis=0), -view.extent)


@needs_opengl
def test_visible():
    """On a sphere, points that face the viewer are visible, others are not."""
    view = View(np.eye(3), np.zeros(3), np.ones(2))
    clear = BALL.vertices[np.abs(BALL.vertices[:, 2]) > 0.4]
    with Stage(BALL, (200, 200), view) as stage:
        np.testing.assert_array_equal(stage.visible(clear), clear[:, 2] > 0)
        centers = BALL.face_centers[np.abs(BALL.face_centers[:, 2]) > 0.4]
        np.testing.assert_array_equal(stage.visible(centers), centers[:, 2] > 0)


@needs_opengl
def test_visible_points_within_faces():
    """Visibility is tested at a point, not at the corners of its face."""
    low = np.array([[-1.0, -1, 0], [1, -1, 0], [0, 2, 0]])
    mesh = TriangleMesh(np.concatenate([low, 0.2 * low + np.array([0, 0, 0.5])]), [[0, 1, 2], [3, 4, 5]])
    with Stage(mesh, (200, 200), View(np.eye(3), np.array([0, 0.5, 0]), np.array([1.0, 1.5]))) as stage:
        assert stage.visible(mesh.vertices[[0, 3]]).tolist() == [True, True]
        assert stage.visible(mesh.face_centers).tolist() == [False, True]


def test_samples_are_even():
    """Samples are spread by area, and lie on faces."""
    samples = surface_samples(BALL, 8000)
    octant = (samples > 0) @ [1, 2, 4]
    np.testing.assert_allclose(np.bincount(octant), 1000, rtol=0.05)
    assert np.linalg.norm(samples, axis=1).min() > 0.98


# -- colors ------------------------------------------------------------------------------------------------------


def shaded(values, mesh=BALL, **look):
    result = colors.shade(Surface(values, **look), mesh)
    assert result is not None
    return result


def test_symmetric_limits_are_robust():
    """Symmetric limits have zero in the middle, and ignore a single outlier."""
    values = np.linspace(-1, 0.5, 642)
    values[7] = 1000
    shades = shaded(values, symmetric=True, outliers=0.02)
    low, high = shades.limits
    assert low == -high
    assert 0.9 < high <= 1.0
    assert shades.clipped == (True, True)
    assert shaded(np.zeros(642), symmetric=True).values[0] == pytest.approx(0.5)


def test_spike_alone_keeps_its_limits():
    """A single nonzero value keeps its limits."""
    values = np.zeros(642)
    values[7] = 3
    assert shaded(values, symmetric=True, outliers=0.02).limits == (-3, 3)


def test_logarithm():
    """exp(-r) is linear in r on a logarithmic scale; zero and negative values are clipped."""
    r = np.linspace(0, 200, 642)
    np.testing.assert_allclose(shaded(np.exp(-r), log=True).values, 1 - r / 200, atol=1e-12)
    assert shaded(np.exp(-r), log=True).clipped == (False, False)
    noisy = np.exp(-r)
    noisy[-1], noisy[-2] = 0.0, -1e-20
    shades = shaded(noisy, log=True)
    assert shades.values[-2:].tolist() == [0, 0]
    assert shades.clipped == (True, False)
    cut = shaded(np.exp(-r), log=True, decades=10)
    assert np.diff(cut.limits) == pytest.approx(10)
    assert shaded(np.zeros(642), log=True).known.all()


def test_unknown_values():
    """Infinite values and NaN are unknown, and do not change the limits."""
    values = np.arange(642.0)
    values[:3] = np.inf, np.nan, -np.inf
    shades = shaded(values)
    assert (~shades.known).nonzero()[0].tolist() == [0, 1, 2]
    assert shades.limits == (3, 641)
    assert not shaded(np.full(642, np.inf)).known.any()


@pytest.mark.parametrize(
    ("low", "high", "expected"),
    [
        (0, 66.94, [0, 20, 40, 60]),
        (-3.1, 3.1, [-2, 0, 2]),
        (0, 1, [0, 0.25, 0.5, 0.75, 1]),
        (2e-7, 9e-7, [2e-7, 4e-7, 6e-7, 8e-7]),
        (1000, 1001, [1000, 1000.25, 1000.5, 1000.75, 1001]),
    ],
)
def test_ticks(low, high, expected):
    """Ticks are round numbers within the limits."""
    np.testing.assert_allclose(colors.ticks(low, high), expected, atol=1e-12)


def test_ticks_of_a_logarithm_are_whole():
    """Ticks of a logarithmic scale are integers."""
    for low, high in ((-20.3, 0.2), (-2.2, 0.1), (-290.0, 1.0)):
        values = colors.ticks(low, high, whole=True)
        np.testing.assert_array_equal(values, np.round(values))
        assert 2 <= len(values) <= 5


def test_ticks_within_one_power_of_ten():
    """A short logarithmic interval has one tick or none."""
    assert colors.ticks(0.2, 0.7, whole=True).tolist() == []
    assert colors.ticks(0.9, 1.3, whole=True).tolist() == [1]


def test_rounding_is_no_range():
    """Values that differ by rounding have one color."""
    shades = colors.shade(Surface(2.0 + 1e-15 * np.arange(BALL.n_vertices)), BALL)
    assert shades is not None
    np.testing.assert_allclose(shades.values, 0.5, atol=1e-9)


def test_tick_labels():
    """Tick labels are short, with a common power of ten."""
    assert colors.tick_labels(np.array([-0.0, 20, 40])) == (["0", "20", "40"], "")
    assert colors.tick_labels(np.array([-2e-7, 0, 2e-7])) == (["−2", "0", "2"], "×10⁻⁷")
    assert colors.tick_labels(np.array([0, 0.25, 0.5])) == (["0", "0.25", "0.5"], "")


# -- arrows and lines --------------------------------------------------------------------------------------------


def test_spread_is_a_poisson_disk_sample():
    """Chosen points are at least the distance apart, and all others near a chosen one."""
    points = surface_samples(BALL, 20_000)
    chosen = points[glyphs.spread(points, 0.2)]
    gaps = np.linalg.norm(chosen[:, None] - chosen, axis=2) + 10 * np.eye(len(chosen))
    assert gaps.min() >= 0.2
    assert np.linalg.norm(points[::20, None] - chosen, axis=2).min(axis=1).max() < 0.2 * 4 / 3 + 1e-9


def test_spread_keeps_all_that_are_far_apart():
    """Points far apart are all chosen."""
    np.testing.assert_array_equal(glyphs.spread(BALL.vertices, 1e-3), np.arange(642))


def test_ribbons_have_their_width_and_length():
    """A segment becomes a strip of the width, longer by a quarter of it at each end, at its depth."""
    points, triangles = glyphs.ribbons(np.array([[[0.0, 0, 1], [0, 3, 2]]]), 0.4)
    np.testing.assert_allclose(points[:, 0], [0.2, 0.2, -0.2, -0.2])
    np.testing.assert_allclose(points[:, 1], [-0.1, 3.1, 3.1, -0.1])
    np.testing.assert_allclose(points[:, 2], [1, 2, 2, 1])
    corners = points[triangles]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2:], axis=1) / 2
    assert areas.sum() == pytest.approx(0.4 * 3.2)


@pytest.mark.parametrize("location", ["vertex", "face"])
def test_arrows_cover_large_faces(location):
    """Large faces have arrows all over, in their planes and as long as those at their corners."""
    mesh = TriangleMesh([[0, 0, 0], [8, 0, 0], [8, 8, 0], [0, 0, -9]], [[0, 1, 2], [0, 3, 1]])  # folded along x
    given = np.tile([1.0, 0.0, 0.0], (mesh.n_vertices if location == "vertex" else mesh.n_faces, 1))
    points, vectors, normals = arrow_places(mesh, Arrows(given, location), 1.0)
    kept = glyphs.spread(points, 1.0)
    for k, area in enumerate(mesh.face_areas):
        there = kept[(np.abs(normals[kept] - mesh.face_normals[k]) < 1e-9).all(axis=1)]
        assert 0.4 * area < len(there) < 1.2 * area
        assert np.abs((points[there] - mesh.face_centers[k]) @ mesh.face_normals[k]).max() < 1e-12
    np.testing.assert_allclose(vectors, np.tile([1.0, 0.0, 0.0], (len(points), 1)), atol=1e-12)


def test_arrows_at_the_corners_of_large_faces_turn_into_the_face():
    """Vectors at vertices leave the plane of a face at a crease; within the face they are in it, of full length."""
    mesh = TriangleMesh([[0, 0, 0], [8, 0, 0], [0, 8, 0]], [[0, 1, 2]])
    given = np.array([[3.0, 0, 4], [3.0, 0, -4], [3.0, 0, 4]])
    points, vectors, _ = arrow_places(mesh, Arrows(given, "vertex"), 1.0)
    np.testing.assert_allclose(vectors[3:], np.tile([5.0, 0.0, 0.0], (len(points) - 3, 1)))


def test_small_faces_keep_their_arrows():
    """On a mesh finer than the spacing, arrows stand at vertices and in the middles of faces."""
    for location, places in (("vertex", BALL.vertices), ("face", BALL.face_centers)):
        points, _, _ = arrow_places(BALL, Arrows(np.ones_like(places), location), 0.3)
        np.testing.assert_array_equal(points, places)


def test_arrows_point_along_their_vectors():
    """An arrow points along its vector, in the surface."""
    centers, vectors = np.array([[1.0, 2, 3]]), np.array([[0, 0, 4.0]])
    points, triangles = glyphs.arrow_triangles(centers, vectors, np.array([[0, 1.0, 0]]))
    assert points[:, 2].max() == 5
    assert points[:, 2].min() == 1
    assert np.ptp(points[:, 1]) == 0
    # Narrow at the tail, one point at the tip.
    assert np.count_nonzero(points[:, 2] == 5) == 1
    assert triangles.max() == len(points) - 1


def test_isolines_of_a_linear_function():
    """Isolines of x on a grid are straight, at their levels, and as long as the grid is high."""
    mesh = primitives.grid(10, 6, 2.0, 1.0)
    levels = np.array([0.33, 1.21])
    surface = window.smooth_surface(mesh.vertices, mesh.faces)
    segments = window.isolines(surface, mesh.vertices[:, 0], levels)
    np.testing.assert_allclose(np.abs(segments[..., 0, None] - levels).min(axis=-1), 0, atol=1e-6)
    assert np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1).sum() == pytest.approx(2.0)
    assert window.isolines(surface, mesh.vertices[:, 0], [7.0]).shape == (0, 2, 3)


# -- creases -----------------------------------------------------------------------------------------------------


def hinge(angle, turned=False):
    """Return two triangles hinged at an angle, the second flipped on request."""
    bend = np.radians(angle)
    points = [[0, 0, 0], [0, 1, 0], [1, 0, 0], [-np.cos(bend), 0, np.sin(bend)]]
    return TriangleMesh(points, [[0, 2, 1], [1, 0, 3] if turned else [0, 1, 3]])


def test_smooth_mesh_has_one_point_a_vertex():
    """A smooth mesh has one point per vertex."""
    shell = window.smooth_surface(BALL.vertices, BALL.faces)
    assert shell.n_points == BALL.n_vertices
    np.testing.assert_array_equal(shell.point_data["origin"][shell.regular_faces], BALL.faces)
    np.testing.assert_allclose(shell.point_data["Normals"], BALL.vertex_normals[shell.point_data["origin"]], atol=1e-2)


@pytest.mark.parametrize(("angle", "points"), [(50, 4), (60, 6)])
def test_sharp_edges_are_split(angle, points):
    """Edges sharper than the threshold are split."""
    mesh = hinge(angle)
    shell = window.smooth_surface(mesh.vertices, mesh.faces)
    assert shell.n_points == points
    np.testing.assert_array_equal(shell.point_data["origin"][shell.regular_faces], mesh.faces)


def test_faces_turned_over_are_split():
    """Flipped faces are split, since their normals are opposite."""
    mesh = hinge(0, turned=True)
    shell = window.smooth_surface(mesh.vertices, mesh.faces)
    assert shell.n_points == 6
    np.testing.assert_allclose(np.abs(shell.point_data["Normals"][:, 2]), 1)


def test_icosahedron_by_threshold():
    """The faces of an icosahedron, at 41.8°, are split below that threshold only."""
    ico = primitives.icosphere(0)
    assert window.smooth_surface(ico.vertices, ico.faces, 41).n_points == 60
    assert window.smooth_surface(ico.vertices, ico.faces, 42).n_points == 12


def test_stray_vertices_have_no_point():
    """Vertices without faces have no point, and change no normal of others."""
    stray = TriangleMesh([[9.0, 9, 9], *BALL.vertices], BALL.faces + 1)
    shell, plain = (window.smooth_surface(mesh.vertices, mesh.faces) for mesh in (stray, BALL))
    assert 0 not in shell.point_data["origin"]
    np.testing.assert_array_equal(shell.point_data["origin"][shell.regular_faces], stray.faces)
    normals = [each.point_data["Normals"][each.regular_faces] for each in (shell, plain)]
    np.testing.assert_array_equal(*normals)


@pytest.mark.parametrize(
    ("value", "digits", "text"),
    [(4264.87, 4, "4265"), (1000.0, 3, "1000"), (123456.7, 3, "123000"), (0.33712, 3, "0.337"), (-2.5, 2, "−2.5"),
     (2.04e-5, 3, "2.04×10⁻⁵"), (3e7, 4, "3×10⁷"), (0.0, 3, "0"), (999999.9, 3, "1×10⁶")],
)  # fmt: skip
def test_plain_numbers(value, digits, text):
    """Numbers are printed without a power of ten where possible."""
    assert colors.plain_number(value, digits) == text
