"""Sources in pictures: discs for few, crosses and curves for many."""

import numpy as np
import pytest

from geomhw.geodesic.heat_method import HeatDistance
from geomhw.mesh.named_points import boundary_points, face_point, vertex_points, vertex_range
from geomhw.mesh.primitives import grid, icosphere
from geomhw.mesh.surface_points import SurfacePoints, concatenate
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.options import PANEL_WIDTH
from geomhw.render.curve_pictures import log_picture
from geomhw.render.layers import Panel
from geomhw.render.look import Look
from geomhw.render.panels import draw
from geomhw.render.pictures import SOURCE_COLOR, geodesic_picture
from geomhw.render.source_marks import MOST_DISCS, source_marks
from geomhw.render.vector_pictures import LENGTH, transport_picture
from geomhw.render.vector_pictures import SOURCE_COLOR as ARROW_COLOR
from geomhw.render.view import choose_view
from geomhw.transport.log_map import LogarithmicMap
from geomhw.transport.source_vectors import source_frames, unit_vectors
from geomhw.transport.vector_heat import VectorHeat, transport_over_times
from support.pictures import ink, needs_opengl

SHEET, COARSE = grid(24, 24), grid(3, 3)


def marks(mesh: TriangleMesh, sources: SurfacePoints) -> tuple[list, list]:
    return source_marks(HeatDistance(mesh).from_sources(sources), SOURCE_COLOR, labels=True)


def test_a_few_are_discs_with_labels() -> None:
    """Few sources are discs at their positions, with labels up to four."""
    sources = concatenate([vertex_points(COARSE, [5]), face_point(COARSE, 7, [0.1, 0.2, 0.7])])
    discs, curves = marks(COARSE, sources)
    assert curves == []
    assert [disc.label for disc in discs] == ["source 5", "source in face 7"]
    places = [disc.position(COARSE.vertices) for disc in discs]
    np.testing.assert_allclose(places, sources.positions(COARSE), atol=1e-15)
    assert discs[1].vertex == COARSE.faces[7, 2]
    assert {disc.label for disc in marks(SHEET, vertex_range(SHEET, 0, 4))[0]} == {""}


def test_many_are_curves() -> None:
    """The boundary of a grid is drawn by its boundary edges, without diagonals."""
    sheet = grid(8, 8, diagonal="uniform")
    discs, (curve,) = marks(sheet, boundary_points(sheet))
    assert discs == []
    assert curve.segments.shape == (4 * 8, 2, 3)
    assert np.linalg.norm(curve.segments[:, 0] - curve.segments[:, 1], axis=1) == pytest.approx(1 / 8)


def test_lone_points_among_many_are_crosses() -> None:
    """Isolated sources among many are crosses, centered there, in the surface."""
    ball = icosphere(3)
    lone = vertex_range(ball, 0, MOST_DISCS)  # those of the icosahedron and of its first split: far apart
    sources = concatenate([lone, face_point(ball, 700)])
    _, (curve,) = marks(ball, sources)
    middles = curve.segments.mean(axis=1)
    assert len(middles) == 2 * (MOST_DISCS + 2)
    np.testing.assert_allclose(middles[::2], middles[1::2], atol=1e-15)
    np.testing.assert_allclose(middles[::2], sources.positions(ball), atol=1e-15)
    arms = curve.segments[:, 1] - curve.segments[:, 0]
    np.testing.assert_allclose(np.einsum("sx,sx->s", arms[::2], arms[1::2]), 0, atol=1e-15)
    np.testing.assert_allclose(arms[-2:] @ ball.face_normals[700], 0, atol=1e-15)


def drawn(mesh: TriangleMesh, sources: SurfacePoints) -> np.ndarray:
    """Return the pixels that source marks color in a picture of 300 × 300."""
    discs, curves = source_marks(HeatDistance(mesh).from_sources(sources), SOURCE_COLOR)
    return ink(draw(mesh, [Panel(markers=discs, curves=curves)], (300, 300)), SOURCE_COLOR)


@needs_opengl
def test_disc_within_a_face_is_seen_in_its_place() -> None:
    """A disc within a large face is at its point."""
    point = face_point(COARSE, 8)
    rows, columns = np.nonzero(drawn(COARSE, point))
    view = choose_view(COARSE)
    x, y = view.project(point.positions(COARSE))[0, :2] / view.extent * 0.94 * 150
    assert len(rows) > 30
    np.testing.assert_allclose([columns.mean(), rows.mean()], [150 + x, 150 - y], atol=1.5)


@needs_opengl
def test_boundary_is_drawn_as_a_line() -> None:
    """Boundary sources are a thin line on all four sides."""
    seen = drawn(SHEET, boundary_points(SHEET))
    rows, columns = np.nonzero(seen)
    extent = np.ptp(rows), np.ptp(columns)
    assert min(extent) > 270
    assert not seen[rows.min() + 6 : rows.max() - 5, columns.min() + 6 : columns.max() - 5].any()
    assert 2 * sum(extent) < seen.sum() < 8 * sum(extent)


@needs_opengl
def test_curves_behind_are_not_seen() -> None:
    """Sources on the far side are not visible."""
    ball = icosphere(2)
    toward = choose_view(ball).axes[2]
    front, behind = (np.flatnonzero(side * ball.vertices @ toward > 0.3) for side in (1, -1))
    assert min(len(front), len(behind)) > MOST_DISCS
    result = HeatDistance(ball).from_vertices(behind)
    _, curves = source_marks(result, SOURCE_COLOR)
    view = choose_view(ball)
    assert ink(draw(ball, [Panel(curves=curves)], (300, 300), view=view), SOURCE_COLOR).sum() == 0
    assert drawn(ball, vertex_points(ball, front)).sum() > 1000


@needs_opengl
def test_geodesic_picture_has_the_curves() -> None:
    """Source curves are in the heat and distance panels, not in the divergence panel."""
    image = geodesic_picture(HeatDistance(SHEET).from_sources(boundary_points(SHEET)), size=(900, 380))
    left, middle, right = (ink(image[:, k : k + 300], SOURCE_COLOR) for k in (0, 300, 600))
    assert left.sum() > 1000
    assert middle.sum() < 100  # its own colors, here and there
    assert right.sum() > 1000


@needs_opengl
def test_vector_within_a_face_stands_there() -> None:
    """The arrow of a point within a face starts at that point."""
    point = face_point(COARSE, 8, [0.8, 0.1, 0.1])
    vector = unit_vectors(source_frames(COARSE, point), [45.0])
    rows, columns = np.nonzero(ink(transport_picture(transport_over_times(COARSE, point, vector, ["h2"])), ARROW_COLOR))
    near = rows > 40  # below the title, without the label
    places = np.stack([columns, rows])[:, near]
    middle = np.median(places, axis=1)
    arrow = (np.abs(places - middle[:, None]) < LENGTH * PANEL_WIDTH).all(axis=0)
    assert arrow.sum() > 150


@needs_opengl
def test_arrows_of_many_sources_keep_their_distance() -> None:
    """Arrows of many sources keep their distance."""
    one = transport_picture(transport_over_times(SHEET, [12], [[0, 1, 0]], ["h2"]))
    count = len(boundary_points(SHEET))
    many = transport_picture(transport_over_times(SHEET, boundary_points(SHEET), [[0, 1, 0]] * count, ["h2"]))
    assert count == 96
    assert 5 < ink(many, ARROW_COLOR).sum() / ink(one, ARROW_COLOR).sum() < 30


def test_results_carry_their_sources() -> None:
    """Sources and vectors of a result are those given, vertices first, without duplicates."""
    sources = concatenate([face_point(SHEET, 30, [0.2, 0.3, 0.5]), vertex_points(SHEET, [9])])
    result = VectorHeat(SHEET).from_sources(sources, [[0, 1, 0], [1, 0, 0]])
    assert result.sources is not None
    np.testing.assert_array_equal(result.sources.faces, [-1, 30])
    np.testing.assert_allclose(result.source_vectors, [[1, 0, 0], [0, 1, 0]], atol=1e-15)


@needs_opengl
def test_the_checkerboard_of_a_logarithmic_map_turns_to_its_source() -> None:
    """A source that the default view hides is a disc in sight, not a ring with a note."""
    ball = icosphere(3)
    lean = np.maximum(ball.vertices[:, 1], 0.0)[:, None] * [0.0, 0.0, 0.8]
    mesh = TriangleMesh(ball.vertices * [1.0, 1.3, 0.6] + lean, ball.faces)
    toward = choose_view(mesh).axes[2]
    source = int((mesh.vertices @ toward).argmin())
    result = LogarithmicMap(mesh).from_source(vertex_points(mesh, [source]))
    facing = Look(view="front" if toward[2] < 0 else "back")
    automatic, faced = (ink(log_picture(result, look), SOURCE_COLOR).sum() for look in (Look(), facing))
    assert 0.9 < automatic / faced < 1.1
