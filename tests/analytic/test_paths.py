"""Shortest paths and straightest geodesics against closed forms: cube, tetrahedron, cylinder, cone, plane, sphere."""

import numpy as np
import pytest

from geomhw.errors import FieldError
from geomhw.geodesic import ShortestPaths, StraightestGeodesics
from geomhw.mesh import TriangleMesh, cylinder_band, grid, icosphere
from geomhw.mesh.named_points import face_point, vertex_points
from geomhw.mesh.nearest import nearest_point
from geomhw.mesh.surface_points import concatenate
from support.hostile import hostile
from support.meshes import flat_torus, zoo_mesh
from support.rates import fitted_rate


def cone(n: int = 7, slant: float = 2.0, angle: float = 3.0) -> tuple[TriangleMesh, float]:
    """Return a fan of n faces around a vertex of a total angle, and the angle of a face."""
    step = angle / n
    radius = slant * np.sin(step / 2) / np.sin(np.pi / n)
    turn = 2 * np.pi * np.arange(n) / n
    rim = np.stack([radius * np.cos(turn), radius * np.sin(turn), 0 * turn], axis=1)
    apex = [[0, 0, np.sqrt(slant**2 - radius**2)]]
    ring = 1 + np.arange(n)
    return TriangleMesh(np.concatenate([apex, rim]), np.stack([0 * ring, ring, np.roll(ring, -1)], axis=1)), step


def cube() -> TriangleMesh:
    """Return a cube of two triangles a side."""
    points = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return TriangleMesh(points, [face for a, b, c, d in quads for face in ([a, b, c], [a, c, d])])


def test_cube() -> None:
    """Opposite corners of a cube are √5 apart, through the middle of an edge; the centers of opposite sides 2."""
    mesh = cube()
    paths = ShortestPaths(mesh)
    (path,) = paths.between(vertex_points(mesh, [0]), vertex_points(mesh, [7]))
    assert path.length == pytest.approx(np.sqrt(5), rel=1e-14)
    assert (np.abs(np.sort(path.positions, axis=1) - [0, 0.5, 1]).max(axis=1) < 1e-12).any()
    bottom, top = nearest_point(mesh, [0.5, 0.5, 0]), nearest_point(mesh, [0.5, 0.5, 1])
    assert paths.between(bottom, top)[0].length == pytest.approx(2, rel=1e-14)


def test_tetrahedron() -> None:
    """The middles of opposite edges of a regular tetrahedron of edge a are a apart."""
    mesh = hostile("tetrahedron")
    a = mesh.edge_lengths[0]
    f = mesh.faces
    edge = [face_point(mesh, 0, [0.5, 0.5, 0])]
    (g,) = [k for k in range(4) if f[0, 0] not in f[k]]
    ends = np.array([v not in (f[0, 0], f[0, 1]) for v in f[g]], dtype=float)
    edge.append(face_point(mesh, g, ends / 2))
    assert ShortestPaths(mesh).between(*edge)[0].length == pytest.approx(a, rel=1e-14)


def test_helix() -> None:
    """On a cylinder the path is a helix: as long as the hypotenuse, and of constant slope."""
    n = 24
    mesh = cylinder_band(n, 8, height=2.0)
    width = 2 * n * np.sin(np.pi / n) / n
    end = int(np.flatnonzero((np.arange(mesh.n_vertices) % n == 7) & (mesh.vertices[:, 2] == mesh.vertices[-1, 2]))[0])
    rise = mesh.vertices[end, 2] - mesh.vertices[0, 2]
    (path,) = ShortestPaths(mesh).between(vertex_points(mesh, [0]), vertex_points(mesh, [end]))
    assert path.length == pytest.approx(np.hypot(7 * width, rise), rel=1e-13)
    heights = path.positions[:, 2] - mesh.vertices[0, 2]
    np.testing.assert_allclose(heights, path.arc_length * rise / path.length, atol=1e-12)


def test_cone() -> None:
    """On a cone of total angle 3 two points at radius r are 2 r sin(angle / 2) apart, apart by less than 1.5."""
    mesh, step = cone()
    r = np.linalg.norm(mesh.vertices[1] - mesh.vertices[0])
    for k in (1, 2, 3):
        (path,) = ShortestPaths(mesh).between(vertex_points(mesh, [1]), vertex_points(mesh, [1 + k]))
        assert path.length == pytest.approx(2 * r * np.sin(k * step / 2), rel=1e-13)


def test_round_a_corner() -> None:
    """A path in a flat L turns at the inner corner, a boundary vertex."""
    square = grid(4, 4)
    centers = square.face_centers
    mesh = TriangleMesh(square.vertices, square.faces[(centers[:, 0] < 0.5) | (centers[:, 1] < 0.5)])
    ends = vertex_points(mesh, [4, 20])  # opposite ends of the L
    (path,) = ShortestPaths(mesh).between(ends[np.array([0])], ends[np.array([1])])
    corner = int(np.flatnonzero((mesh.vertices[:, :2] == 0.5).all(axis=1))[0])
    assert corner in path.vertices
    a, b = ends.positions(mesh)
    legs = [np.linalg.norm(mesh.vertices[corner] - x) for x in (a, b)]
    assert path.length == pytest.approx(sum(legs), rel=1e-14)


def test_plane() -> None:
    """Lines in a plane are straight, through vertices too, and end at the boundary."""
    mesh = grid(6, 6)
    lines = StraightestGeodesics(mesh)
    starts = concatenate([vertex_points(mesh, [24]), face_point(mesh, 30), face_point(mesh, 31, [0.5, 0, 0.5])])
    for start in starts.split():
        x = start.positions(mesh)[0]
        for degrees in np.arange(0, 360, 15):
            vector = np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees)), 0])
            line = lines.trace(start, vector, 0.2)
            np.testing.assert_allclose(line.positions[-1], x + 0.2 * vector, atol=1e-12)
            assert (line.stop, line.length) == ("", pytest.approx(0.2, rel=1e-12))
            line = lines.trace(start, vector, 9)
            assert line.stop == "boundary"
            np.testing.assert_allclose(np.abs(line.positions[-1] - 0.5)[:2].max(), 0.5, atol=1e-12)


def test_lines_on_a_flat_torus() -> None:
    """A line on a flat torus is straight in the unfolded plane, across vertices and round both ways."""
    mesh, places, width, height = flat_torus(7, 4)
    size, lines = np.array([width, height]), StraightestGeodesics(mesh)
    for source in (0, 9, 30):
        first = mesh.faces[(mesh.faces == source).any(axis=1)][0]
        k = first.tolist().index(source)
        edge = places[first[(k + 1) % 3]] - places[source]
        edge -= size * np.round(edge / size)
        start = np.degrees(np.arctan2(edge[1], edge[0]))
        for degrees in np.arange(0, 360, 17.0):
            line = lines.trace_angle(vertex_points(mesh, [source]), degrees, 11.0)
            corners = places[mesh.faces[line.faces[-1]]]
            corners -= size * np.round((corners - corners[0]) / size)
            turned = np.radians(start + degrees)
            off = line.weights[-1] @ corners - places[source] - 11.0 * np.array([np.cos(turned), np.sin(turned)])
            assert line.length == pytest.approx(11.0, rel=1e-12)
            np.testing.assert_allclose(off, size * np.round(off / size), atol=1e-11)


def test_cylinder_lines() -> None:
    """A line on a cylinder is a helix, along its rulings and across its vertices."""
    mesh = cylinder_band(24, 8, height=2.0)
    lines, start = StraightestGeodesics(mesh), 24 * 4
    for slope in (0.0, 0.3, 1.0):
        ahead = mesh.vertices[start + 1] - mesh.vertices[start]
        vector = ahead / np.linalg.norm(ahead) + [0, 0, slope]
        line = lines.trace(vertex_points(mesh, [start]), vector, 1.3)
        expected = mesh.vertices[start, 2] + line.arc_length * slope / np.hypot(1, slope)
        # From the first vertex on, the direction in a face counts, not that in the tangent plane.
        np.testing.assert_allclose(line.positions[:, 2], expected, atol=1e-12)


def test_through_a_vertex() -> None:
    """Through the tip of a cone a line has half of the total angle on both sides."""
    mesh, _ = cone(n=8)
    line = StraightestGeodesics(mesh).trace(vertex_points(mesh, [1]), mesh.vertices[0] - mesh.vertices[1], 3.0)
    np.testing.assert_allclose(line.positions[1], mesh.vertices[0], atol=1e-12)
    np.testing.assert_allclose(line.positions[2], mesh.vertices[0] + (mesh.vertices[5] - mesh.vertices[0]) / 2)


def test_great_circles() -> None:
    """After one turn, lines on spheres are back at their start up to h^1.5, 0.4 % of the radius at 10k vertices."""
    errors, h = [], []
    for level in (2, 3, 4):
        mesh, rng = icosphere(level), np.random.default_rng(0)
        lines = StraightestGeodesics(mesh)
        ends = []
        for v in rng.integers(mesh.n_vertices, size=20).tolist():
            line = lines.trace(vertex_points(mesh, [v]), np.cross(rng.normal(size=3), mesh.vertices[v]), 2 * np.pi)
            ends.append(np.linalg.norm(line.positions[-1] - mesh.vertices[v]))
        errors.append(np.mean(ends))
        h.append(mesh.mean_edge_length)
    assert fitted_rate(h, errors) > 1.3
    assert errors[-1] < 0.012


def test_zero_area() -> None:
    """Lines do not start into faces of zero area."""
    mesh = TriangleMesh([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0]], [[0, 1, 2], [0, 1, 3]])
    lines = StraightestGeodesics(mesh)
    for start in (face_point(mesh, 0), vertex_points(mesh, [2])):
        with pytest.raises(FieldError, match="zero area"):
            lines.trace_angle(start, 0, 1.0)


def test_ties() -> None:
    """Opposite corners and centers of a cube, and opposite points of a cylinder, have several shortest paths."""
    paths = ShortestPaths(mesh := cube(), ties=True)
    bottom = nearest_point(mesh, [0.5, 0.5, 0])
    for start, end, tied in [
        (vertex_points(mesh, [0]), vertex_points(mesh, [7]), True),
        (vertex_points(mesh, [0]), vertex_points(mesh, [1]), False),
        (bottom, nearest_point(mesh, [0.5, 0.5, 1]), True),
        (bottom, nearest_point(mesh, [0.52, 0.57, 1]), False),
    ]:
        assert paths.between(start, end)[0].tied is tied
    paths = ShortestPaths(mesh := cylinder_band(24, 8, height=2.0), ties=True)
    ends = vertex_points(mesh, 24 * 5 + np.array([11, 12, 13]))
    assert [path.tied for path in paths.to_nearest(vertex_points(mesh, [0]), ends)] == [False, True, False]


@pytest.mark.parametrize("power", [-40, -13, 39])
def test_straightest_lines_scale_with_the_mesh(power: int) -> None:
    """A line from a vertex along a vector is the same to the bit on a mesh that is scaled by a power of two."""
    ball = zoo_mesh("crumpled_sphere")
    small = TriangleMesh(ball.vertices * 2.0**power, ball.faces)
    for vector in ([1.0, 2.0, 3.0], [-1.0, 0.5, 0.1]):
        lines = [
            StraightestGeodesics(mesh).trace(vertex_points(mesh, [5]), vector, length)
            for mesh, length in ((ball, 2.5), (small, 2.5 * 2.0**power))
        ]
        assert lines[0].positions.tobytes() == (lines[1].positions / 2.0**power).tobytes()


def test_directions_where_faces_lie_over_each_other() -> None:
    """Of two flat faces over each other that have a direction, the numbering does not choose."""
    points = [[0, 0, 0], [1, -0.2, 0], [0.6, 1, 0], [1, 0.5, 0], [-1, 1, 0], [-1, -1, 0]]
    faces = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5], [0, 5, 1]]
    ends = []
    for order in ([0, 1, 2, 3, 4], [2, 3, 4, 0, 1], [1, 2, 3, 4, 0]):
        mesh = TriangleMesh(points, [faces[k] for k in order])
        line = StraightestGeodesics(mesh).trace(vertex_points(mesh, [0]), [1.0, 0.9, 0], 0.2)
        ends.append(sorted(mesh.faces[line.faces[0]].tolist()))
    assert ends[0] == ends[1] == ends[2]
