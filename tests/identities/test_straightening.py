"""Curves shortened within their homotopy class: lengths, angles on both sides, loops."""

import numpy as np
import pytest

from geomhw.errors import FieldError
from geomhw.geodesic import ShortestPaths, curve_through, straighten
from geomhw.mesh import cylinder_band, grid, icosphere, torus
from geomhw.mesh.named_points import face_point, vertex_points
from geomhw.mesh.surface_points import concatenate
from support.hostile import hostile
from support.meshes import annulus, crumpled
from support.paths import angle, lies_in_faces, turns


def is_geodesic(path) -> bool:
    """Whether a path is straight across edges, and has angles of at least π at inner vertices."""
    mesh, x = path.mesh, path.positions
    total = np.bincount(mesh.faces.ravel(), mesh.angles.ravel())
    at = np.setdiff1d(np.flatnonzero((path.weights == 1).any(axis=1)), [0, len(x) - 1])
    vertices = mesh.faces[path.faces[at], path.weights[at].argmax(axis=1)]
    inner = ~np.isin(vertices, mesh.boundary_vertices)
    return (
        lies_in_faces(path)
        and np.abs(turns(path)).max(initial=0) < 1e-6
        and (total[vertices[inner]] > 2 * np.pi - 1e-9).all()
    )


@pytest.mark.parametrize("mesh", [icosphere(3), crumpled(icosphere(2))], ids=["sphere", "crumpled"])
def test_detours_shrink(mesh) -> None:
    """A detour by way points becomes a geodesic, no longer than the curve and no shorter than the shortest path."""
    rng, paths = np.random.default_rng(2), ShortestPaths(mesh)
    for _ in range(10):
        stops = vertex_points(mesh, rng.choice(mesh.n_vertices, 4, replace=False))
        curve = curve_through(mesh, stops)
        path = straighten(curve)
        shortest = paths.between(stops[np.array([0])], stops[np.array([3])])[0].length
        assert shortest * (1 - 1e-12) <= path.length <= curve.length * (1 + 1e-12)
        assert is_geodesic(path)
        assert straighten(path).length == pytest.approx(path.length, rel=1e-12)


def test_flat() -> None:
    """In a plane, the result is the straight segment."""
    mesh = grid(8, 8)
    stops = concatenate([face_point(mesh, 3), vertex_points(mesh, [70, 44]), face_point(mesh, 100)])
    path = straighten(curve_through(mesh, stops))
    a, b = stops.positions(mesh)[[0, -1]]
    assert path.length == pytest.approx(np.linalg.norm(b - a), rel=1e-13)
    assert (path.weights > 0).all(axis=1)[[0, -1]].all()


def test_stays_on_its_side() -> None:
    """Around a hole, both ways stay what they are."""
    mesh = annulus()
    ends = [int(np.abs(mesh.vertices[:, :2] - corner).sum(axis=1).argmin()) for corner in ([0, 0], [1, 1])]
    lengths = []
    for corner in ([0, 1], [1, 0]):
        middle = int(np.abs(mesh.vertices[:, :2] - corner).sum(axis=1).argmin())
        path = straighten(curve_through(mesh, vertex_points(mesh, [ends[0], middle, ends[1]])))
        side = (path.positions[:, 0] - path.positions[:, 1]) * (corner[0] - corner[1])
        assert side.min() > -1e-12
        assert side.max() > 0.1
        lengths.append(path.length)
    assert lengths[0] == pytest.approx(lengths[1], rel=1e-12)


def test_closed_geodesics() -> None:
    """Loops round a cylinder and a torus have the closed forms: a polygon, the inner equator, a circle of the tube."""
    mesh = cylinder_band(24, 8, height=2.0)
    loop = straighten(curve_through(mesh, vertex_points(mesh, [0, 30, 60, 88, 100, 20]), closed=True), closed=True)
    assert loop.length == pytest.approx(48 * np.sin(np.pi / 24), rel=1e-12)
    mesh = torus(24, 12)
    around = np.arange(24) + 24 * 2
    loop = straighten(curve_through(mesh, vertex_points(mesh, around), closed=True), closed=True)
    assert loop.length == pytest.approx(48 * 0.6 * np.sin(np.pi / 24), rel=1e-12)
    tube = straighten(curve_through(mesh, vertex_points(mesh, np.arange(0, 288, 24) + np.arange(12) % 2), True), True)
    assert tube.length <= 24 * 0.4 * np.sin(np.pi / 12) * (1 + 1e-12)
    for path in (loop, tube):
        assert is_geodesic(path)
        np.testing.assert_allclose(path.positions[0], path.positions[-1], atol=1e-12)
        first, last = np.diff(path.positions, axis=0)[[0, -1]]
        if not (path.weights[0] == 1).any():
            assert angle(first, last) < 0.3  # no kink where it closes


def test_contractible() -> None:
    """A loop that bounds a disk shrinks to a point."""
    mesh = icosphere(3)
    curve = curve_through(mesh, vertex_points(mesh, [0, 40, 90]), closed=True)
    assert curve.length > 1
    point = straighten(curve, closed=True)
    assert (len(point.faces), point.length) == (1, 0)


def test_refusals() -> None:
    """A closed curve ends where it starts, and does not pass pinched vertices; an open one is fixed there."""
    mesh = hostile("hourglass")
    ends = [face_point(mesh, 0), face_point(mesh, mesh.n_faces - 1)]
    curve = curve_through(mesh, concatenate(ends))
    assert straighten(curve).length == pytest.approx(curve.length, rel=1e-12)
    with pytest.raises(FieldError, match="end where it starts"):
        straighten(curve, closed=True)
    with pytest.raises(FieldError, match="fans of faces meet"):
        straighten(curve_through(mesh, concatenate(ends), closed=True), closed=True)
