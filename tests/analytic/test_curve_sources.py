"""Distances from curves that cross faces, in the plane, on a sphere and on a cylinder."""

from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from geomhw.arrays import Floats
from geomhw.curves import isolines, levels_between, trace_polyline
from geomhw.errors import FieldError
from geomhw.geodesic import ExactDistance, HeatDistance, voronoi_cells
from geomhw.mesh import (
    SurfacePoints,
    TriangleMesh,
    curve_points,
    edge_points,
    even_samples,
    grid,
    icosphere,
    vertex_points,
)
from geomhw.mesh.named_points import region_points
from geomhw.mesh.surface_points import concatenate
from geomhw.transport import VectorHeat
from support.meshes import split_diagonals, two_spheres

SQUARE = grid(14, 14)


def curve(mesh: TriangleMesh, points: Any) -> SurfacePoints:
    """Return a polyline in space as sources."""
    path = trace_polyline(mesh, points).path
    return curve_points(mesh, path.faces, path.weights)


def to_polyline(places: Floats, points: Any) -> Floats:
    """Return the distance in the plane from places to the nearest segment."""
    corners = np.array(points)[:, :2]
    nearest = np.full(len(places), np.inf)
    for a, b in pairwise(corners):
        share = np.clip((places[:, :2] - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
        nearest = np.minimum(nearest, np.linalg.norm(a + share[:, None] * (b - a) - places[:, :2], axis=1))
    return nearest


LINES = {
    "segment": [[0.213, 0.31, 0], [0.72, 0.55, 0]],
    "in one face": [[0.51, 0.52, 0], [0.53, 0.525, 0]],
    "along edges": [[0, 0.5, 0], [1, 0.5, 0]],
    "bent": [[0.1, 0.9, 0], [0.4, 0.2, 0], [0.9, 0.8, 0]],
    "closed": [[0.2, 0.2, 0], [0.8, 0.3, 0], [0.45, 0.7, 0], [0.2, 0.2, 0]],
    "crossing itself": [[0.1, 0.1, 0], [0.9, 0.8, 0], [0.9, 0.2, 0], [0.1, 0.8, 0]],
}


@pytest.mark.parametrize("name", LINES)
@pytest.mark.parametrize("mesh", [SQUARE, grid(1, 1), split_diagonals(7)], ids=["grid", "two", "flat faces"])
def test_plane(name: str, mesh: TriangleMesh) -> None:
    """Exact distances are those of the plane, to rounding, on the curve, beside it and far from it."""
    flat = TriangleMesh(mesh.vertices * [1, 1, 0], mesh.faces)
    distance = ExactDistance(flat).from_sources(curve(flat, LINES[name]))["distance"]
    np.testing.assert_allclose(distance, to_polyline(flat.vertices, LINES[name]), atol=1e-12)


@pytest.mark.parametrize(
    "settings", [{}, {"solver": "multigrid"}, {"boundary": "average"}, {"robust": True, "refine": False}]
)
def test_heat_method(settings: dict[str, Any]) -> None:
    """The heat method is exact in the faces of the curve, and accurate elsewhere; refined it is exact."""
    sources = curve(SQUARE, LINES["bent"])
    exact = to_polyline(SQUARE.vertices, LINES["bent"])
    found = HeatDistance(SQUARE, **settings).from_sources(sources)["distance"]
    beside = np.unique(SQUARE.faces[sources.segments[:, 2]])
    np.testing.assert_allclose(found[beside], exact[beside], atol=1e-12)
    assert np.abs(found - exact).mean() < 0.25 * SQUARE.mean_edge_length
    refined = HeatDistance(SQUARE, refine=True, **{k: v for k, v in settings.items() if k != "refine"})
    np.testing.assert_allclose(refined.from_sources(sources)["distance"], exact, atol=1e-12)


def test_with_other_sources() -> None:
    """Curves, points within faces, vertices and filled regions are sources together; a limit and targets hold."""
    line = LINES["segment"]
    region = [0, 1, 15, 16]
    sources = concatenate([curve(SQUARE, line), vertex_points(SQUARE, [200]), region_points(SQUARE, region)])
    exact = to_polyline(SQUARE.vertices, line)
    corner = np.linalg.norm(np.maximum(SQUARE.vertices[:, :2] - 1 / 14, 0), axis=1)
    exact = np.minimum(np.minimum(exact, corner), np.linalg.norm(SQUARE.vertices - SQUARE.vertices[200], axis=1))
    solver = ExactDistance(SQUARE)
    np.testing.assert_allclose(solver.from_sources(sources)["distance"], exact, atol=1e-12)
    limited = solver.from_sources(sources, limit=0.1)["distance"]
    np.testing.assert_array_equal(np.isfinite(limited), exact <= 0.1)
    assert solver.from_sources(sources, targets=[120])["distance"][120] == pytest.approx(exact[120], abs=1e-12)
    np.testing.assert_array_equal(solver.rows([sources])[0], solver.from_sources(sources)["distance"])


def test_curve_through_a_filled_region() -> None:
    """A curve within a region adds nothing."""
    region = region_points(SQUARE, np.flatnonzero(SQUARE.vertices[:, 0] < 0.5))
    inside = curve(SQUARE, [[0.13, 0.2, 0], [0.31, 0.77, 0]])
    solver = ExactDistance(SQUARE)
    both, alone = (solver.from_sources(points)["distance"] for points in (concatenate([region, inside]), region))
    np.testing.assert_allclose(both, alone, atol=1e-14)


def test_boundary_as_a_curve() -> None:
    """From the edges of the boundary, distances are those to the sides; from its vertices they may be longer."""
    mesh = TriangleMesh(SQUARE.vertices * [3, 1, 1], SQUARE.faces)
    edges = edge_points(mesh, np.flatnonzero(mesh.edge_table.face_counts[mesh.edge_table.of_faces.ravel()] == 1))
    x, y = mesh.vertices[:, :2].T
    expected = np.minimum(np.minimum(x, 3 - x), np.minimum(y, 1 - y))
    np.testing.assert_allclose(ExactDistance(mesh).from_sources(edges)["distance"], expected, atol=1e-12)


def test_circle_on_a_sphere() -> None:
    """Distance from a circle of latitude: to 1e-3 of the radius on 2,562 vertices."""
    ball = icosphere(4)
    turn, z = np.linspace(0, 2 * np.pi, 300), 0.3
    ring = np.stack([np.sqrt(1 - z**2) * np.cos(turn), np.sqrt(1 - z**2) * np.sin(turn), np.full(300, z)], axis=1)
    ring[-1] = ring[0]
    sources = curve(ball, ring)
    expected = np.abs(np.arcsin(ball.vertices[:, 2]) - np.arcsin(z))
    for found in (ExactDistance(ball).from_sources(sources), HeatDistance(ball, robust=True).from_sources(sources)):
        assert np.abs(found["distance"] - expected).max() < 2e-3
    assert np.abs(HeatDistance(ball).from_sources(sources)["distance"] - expected).mean() < 0.15 * ball.mean_edge_length


def test_cells_of_curves() -> None:
    """The border between the cells of two parallel lines is halfway; a point inside keeps its own cell."""
    lines = [curve(SQUARE, [[0.1, y, 0], [0.9, y, 0]]) for y in (0.22, 0.8)]
    cells = voronoi_cells(SQUARE, concatenate(lines))
    assert cells.areas.sum() == pytest.approx(1, rel=1e-12)
    assert cells.areas.tolist() == pytest.approx([0.51, 0.49], abs=1e-3)
    assert cells.result.report["sites"] == [{"curve": len(line)} for line in lines]
    x, y = SQUARE.vertices[:, :2].T
    middle = np.abs(x - 0.5) < 0.4
    np.testing.assert_array_equal(cells.label[middle], (y[middle] > 0.51).astype(int))
    np.testing.assert_allclose(
        cells.distance[middle], np.minimum(np.abs(y - 0.22), np.abs(y - 0.8))[middle], atol=1e-12
    )
    three = voronoi_cells(SQUARE, concatenate([*lines, vertex_points(SQUARE, [112])]))
    assert three.label[112] == 2
    assert three.areas.sum() == pytest.approx(1, rel=1e-12)


def test_vectors_from_a_curve() -> None:
    """Vectors across a line stay across it in the plane."""
    samples, along = even_samples(SQUARE, curve(SQUARE, LINES["segment"]), 0.25 * SQUARE.mean_edge_length)
    np.testing.assert_allclose(along, along[:1].repeat(len(along), axis=0), atol=1e-12)
    places = samples.positions(SQUARE)
    steps = np.linalg.norm(np.diff(places, axis=0), axis=1)
    np.testing.assert_allclose(steps, steps[0], rtol=1e-9)
    across = np.cross([0, 0, 1], along)
    found = VectorHeat(SQUARE).from_sources(samples, across)["transported"]
    np.testing.assert_allclose(found, np.tile(across[0], (len(found), 1)), atol=1e-9)


def test_levels_between_curves() -> None:
    """Between two concentric circles, a level has a fixed share of the way everywhere."""
    turn = np.linspace(0, 2 * np.pi, 121)
    inner, outer = (np.stack([0.5 + r * np.cos(turn), 0.5 + r * np.sin(turn), 0 * turn], axis=1) for r in (0.1, 0.45))
    fine = grid(40, 40)
    shares = levels_between(fine, curve(fine, inner), curve(fine, outer))
    found = isolines(fine, shares, [0.4])
    longest = int(found.lengths.argmax())
    points = found.positions[found.starts[longest] : found.starts[longest + 1]]
    radius = np.linalg.norm(points[:, :2] - 0.5, axis=1)
    np.testing.assert_allclose(radius, 0.1 + 0.4 * 0.35, atol=0.003)


def test_levels_between_components() -> None:
    """Sets on different components have nothing between them; a component without one of them has no values."""
    balls = two_spheres()
    one, near, far = (vertex_points(balls, [v]) for v in (0, 3, 170))
    with pytest.raises(FieldError, match="different components"):
        levels_between(balls, one, far)
    shares = levels_between(balls, one, near)
    assert np.isfinite(shares[:162]).all()
    assert np.isnan(shares[162:]).all()
    assert np.isnan(levels_between(balls, concatenate([one, far]), near)[163:]).all()


def test_selected_points_keep_their_segments() -> None:
    """Selecting points keeps the segments between them; equal points become one."""
    line = curve(SQUARE, LINES["closed"])
    assert (line.groups() == 0).all()
    once = line.unique()
    assert len(once) == len(line) - 1
    assert len(once.segments) == len(line.segments)
    half = line[np.arange(4)]
    assert half.segments[:, :2].tolist() == [[0, 1], [1, 2], [2, 3]]
    both = concatenate([half, half])
    assert both.groups().tolist() == [0] * 4 + [1] * 4
