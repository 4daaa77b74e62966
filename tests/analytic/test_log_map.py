"""The logarithmic map: plane, sphere, cone, saddle, and its inverse, the exponential map."""

import numpy as np
import pytest

from geomhw.errors import ArgumentError
from geomhw.geodesic import ExactDistance, ShortestPaths, StraightestGeodesics
from geomhw.mesh import grid, icosphere
from geomhw.mesh.named_points import face_point, vertex_points
from geomhw.mesh.surface_points import SurfacePoints
from geomhw.transport import LogarithmicMap
from support.hostile import hostile
from support.meshes import crumpled, split_diagonals, two_spheres


@pytest.mark.parametrize("source", [vertex_points(grid(6, 6), [24]), face_point(grid(6, 6), 31, [0.2, 0.5, 0.3])])
def test_plane(source: SurfacePoints) -> None:
    """In a plane, log is the vector from the source, in the frame of the first edge."""
    mesh = grid(6, 6)
    result = LogarithmicMap(mesh).from_source(source)
    face = int(source.faces[0]) if source.faces[0] >= 0 else int(np.flatnonzero((mesh.faces == 24).any(axis=1))[0])
    k = int(np.flatnonzero(mesh.faces[face] == 24)[0]) if source.faces[0] < 0 else 0
    a, b = mesh.vertices[mesh.faces[face][[k, (k + 1) % 3]], :2]
    (c, s) = (b - a) / np.linalg.norm(b - a)
    x = mesh.vertices[:, :2] - source.positions(mesh)[0, :2]
    np.testing.assert_allclose(result["log"], x @ [[c, -s], [s, c]], atol=1e-13)


def test_degenerate_faces() -> None:
    """Also where lines cross faces of zero area."""
    mesh = split_diagonals(6)
    (v,) = np.flatnonzero((np.abs(mesh.vertices[:, :2] - 0.5) < 1e-12).all(axis=1))
    log = LogarithmicMap(mesh).from_source(vertex_points(mesh, [v]))["log"]
    x = mesh.vertices[:, :2] - mesh.vertices[v, :2]
    turn = (log @ [1, 1j]) / np.where(np.arange(len(x)) == v, 1, x @ [1, 1j])
    np.testing.assert_allclose(np.delete(turn, v), turn[v - 1], atol=1e-11)


@pytest.mark.parametrize("source", [0, 100])
def test_sphere(source: int) -> None:
    """On spheres, up to 2.8 from the source, errors of angle fall with the mesh size."""
    angles = []
    for level in (3, 4):
        mesh = icosphere(level)
        result = LogarithmicMap(mesh).from_source(vertex_points(mesh, [source]))
        n, x = mesh.vertices[source], mesh.vertices
        e1 = mesh.tangent_frames[source, 0]
        exact = np.arctan2(x @ np.cross(n, e1), x @ e1)
        kept = (result["radius"] < 2.8) & (result["radius"] > 0)
        error = np.degrees(np.abs((result["angle"] - exact + np.pi) % (2 * np.pi) - np.pi))[kept]
        angles.append(error.mean())
    assert angles[1] < 0.5 * angles[0] < 0.6


def test_inverse() -> None:
    """exp(log v) = v where shortest paths do not turn; radius is the exact distance."""
    mesh = icosphere(3)
    for source in (vertex_points(mesh, [7]), face_point(mesh, 30, [0.2, 0.3, 0.5])):
        result = LogarithmicMap(mesh).from_source(source)
        np.testing.assert_allclose(result["radius"], ExactDistance(mesh).from_sources(source)["distance"], rtol=1e-12)
        lines = StraightestGeodesics(mesh)
        for v in range(3, mesh.n_vertices, 23):
            line = lines.trace_angle(source, np.degrees(result["angle"][v]), result["radius"][v])
            np.testing.assert_allclose(line.positions[-1], mesh.vertices[v], atol=1e-9)


def test_starts_like_the_path() -> None:
    """Beyond saddles, too, the angle is that at which the shortest path starts."""
    mesh = crumpled(icosphere(2))
    result = LogarithmicMap(mesh).from_source(vertex_points(mesh, [5]))
    lines, targets = StraightestGeodesics(mesh), np.arange(10, 160, 7)
    for v, path in zip(
        targets, ShortestPaths(mesh).to_nearest(vertex_points(mesh, [5]), vertex_points(mesh, targets)), strict=True
    ):
        step = path.positions[1] - path.positions[0]
        line = lines.trace_angle(vertex_points(mesh, [5]), np.degrees(result["angle"][v]), np.linalg.norm(step) / 2)
        np.testing.assert_allclose(line.positions[-1] - path.positions[0], step / 2, atol=1e-9)


def test_scaled_angles() -> None:
    """The angles of the edges at a vertex are those of the faces, scaled to a full turn, from the first edge on."""
    mesh = crumpled(icosphere(1))
    angle = LogarithmicMap(mesh).from_source(vertex_points(mesh, [3]))["angle"]
    corners = np.argwhere(mesh.faces == 3)
    following = {int(mesh.faces[f, (k + 1) % 3]): (int(mesh.faces[f, k - 1]), mesh.angles[f, k]) for f, k in corners}
    f, k = corners[0]
    total, v, a = sum(size for _, size in following.values()), int(mesh.faces[f, (k + 1) % 3]), 0.0
    for _ in following:
        assert np.exp(1j * angle[v]) == pytest.approx(np.exp(2j * np.pi * a / total), abs=1e-12)
        v, a = following[v][0], a + following[v][1]


def test_boundary() -> None:
    """At a corner of a square, angles are not scaled."""
    mesh = grid(3, 3)
    angle = LogarithmicMap(mesh).from_source(vertex_points(mesh, [0]))["angle"]
    assert np.ptp(np.delete(angle, 0)) == pytest.approx(np.pi / 2, abs=1e-12)


def test_limits() -> None:
    """Beyond the radius and on other components, radius is inf and log is NaN."""
    mesh = two_spheres()
    whole = LogarithmicMap(mesh).from_source(vertex_points(mesh, [0]))
    assert whole.report["unreachable_vertices"] == 162
    near = LogarithmicMap(mesh).from_source(vertex_points(mesh, [0]), 1.0)
    inside = np.asarray(whole["radius"]) <= 1
    np.testing.assert_array_equal(np.isfinite(near["radius"]), inside)
    np.testing.assert_array_equal(near["log"][inside], whole["log"][inside])
    assert np.isnan(near["log"][~inside]).all()


def test_refusals() -> None:
    """One source, at a manifold vertex; a radius is not negative."""
    mesh = grid(2, 2)
    with pytest.raises(ArgumentError, match="one source"):
        LogarithmicMap(mesh).from_source(vertex_points(mesh, [0, 1]))
    with pytest.raises(ArgumentError, match="radius"):
        LogarithmicMap(mesh).from_source(vertex_points(mesh, [0]), -1.0)
    pinched = hostile("bow_tie")
    with pytest.raises(ArgumentError, match="not manifold"):
        LogarithmicMap(pinched).from_source(vertex_points(pinched, [0]))
