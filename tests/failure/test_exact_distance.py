"""Exact distances: limits, targets and meshes that they refuse; loops over faces of zero area end."""

from math import inf

import numpy as np
import pytest

from geomhw.errors import FieldError, MeshError
from geomhw.geodesic.exact import ExactDistance
from geomhw.geodesic.front_distance import NONE
from geomhw.geodesic.windows import LAST
from geomhw.mesh.named_points import face_point, vertex_points
from geomhw.mesh.primitives import grid
from geomhw.mesh.triangle_mesh import TriangleMesh
from support.hostile import hostile


@pytest.mark.parametrize("limit", [-1.0, float("nan")])
def test_limit_is_a_length(limit: float) -> None:
    with pytest.raises(FieldError, match="limit"):
        ExactDistance(grid(2, 2)).from_vertices([0], limit=limit)
    with pytest.raises(FieldError, match="limit"):
        ExactDistance(grid(2, 2)).matrix(limit)


@pytest.mark.parametrize("targets", [[9], [-1], [0.5]])
def test_targets_are_vertices(targets: list[int]) -> None:
    with pytest.raises(FieldError, match="vertex"):
        ExactDistance(grid(2, 2)).from_vertices([0], targets=targets)


@pytest.mark.parametrize("name", ["huge_150", "tiny_150", "tiny_310"])
def test_range_of_coordinates(name: str) -> None:
    with pytest.raises(MeshError, match="unit of length"):
        ExactDistance(hostile(name))


def test_targets_out_of_reach() -> None:
    """A target on another component has distance inf, and all others are computed."""
    mesh = hostile("two_ways")
    solver = ExactDistance(mesh)
    other = mesh.n_vertices - 1
    found = solver.from_vertices([0], targets=[other])["distance"]
    np.testing.assert_array_equal(found, solver.from_vertices([0])["distance"])
    assert np.isinf(found[other])


def test_limit_below_all_vertices() -> None:
    """Within a limit that reaches no vertex, the report has no farthest vertex."""
    mesh = grid(2, 2)
    result = ExactDistance(mesh).from_sources(face_point(mesh, 0), limit=1e-3)
    assert np.isinf(result["distance"]).all()
    assert result.report["farthest"] is None
    assert result.report["vertices_beyond"] == 9


def test_all_vertices_in_one_place() -> None:
    """On a mesh of no extent all distances are 0."""
    mesh = TriangleMesh(np.zeros((6, 3)), [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5], [2, 3, 5], [1, 2, 4]])
    assert not ExactDistance(mesh).from_vertices([0])["distance"].any()


def test_closed_strip_of_zero_width() -> None:
    """Windows that circle a tube of zero width end."""
    tube = hostile("tube")
    flat = TriangleMesh(tube.vertices * [0, 0, 1], tube.faces)
    found = ExactDistance(flat).from_vertices([0])["distance"]
    np.testing.assert_allclose(found, abs(flat.vertices[:, 2] - flat.vertices[0, 2]), rtol=1e-12)


def test_many_faces_at_an_edge() -> None:
    """Room for windows grows with the number of faces at an edge, not with its square."""
    room = []
    for n in (4000, 16000):
        points = np.random.default_rng(0).normal(size=(n + 2, 3))
        faces = np.stack([np.zeros(n, dtype=int), np.ones(n, dtype=int), np.arange(2, n + 2)], axis=1)
        solver = ExactDistance(TriangleMesh(points, faces))
        front, reached = solver._front(vertex_points(solver.mesh, [5]), inf, NONE, NONE)
        room.append(len(front.windows))
        assert len(reached) == n + 2
    assert room[1] <= 8 * room[0]


def test_source_of_high_valence() -> None:
    """A source whose windows need more room than there is at first gets it."""
    n = 50_000
    angle = 2 * np.pi * np.arange(n) / n
    rings = [np.stack([r * np.cos(angle), r * np.sin(angle), 0 * angle], axis=1) for r in (1.0, 2.0)]
    a, b = 1 + np.arange(n), 1 + np.roll(np.arange(n), -1)
    hub = np.zeros(n, dtype=int)
    faces = np.concatenate([np.stack(f, axis=1) for f in ((hub, a, b), (a, a + n, b), (b, a + n, b + n))])
    solver = ExactDistance(TriangleMesh(np.concatenate([np.zeros((1, 3)), *rings]), faces))
    front, _ = solver._front(vertex_points(solver.mesh, [0]), inf, NONE, NONE)
    assert len(front.windows) > n
    np.testing.assert_allclose(front.distance[1 : n + 1], 1.0, rtol=1e-9)
    np.testing.assert_allclose(front.distance[n + 1 :], 2.0, rtol=1e-9)


def test_long_ribbon_with_straight_borders() -> None:
    """In a ribbon of squares, paths along its border and beside it tie: rounding keeps no windows from each vertex."""
    n = 16000
    i, x = np.arange(n), np.arange(n + 1) * 3e-5
    points = np.concatenate([np.stack([x, 0 * x, 0 * x], axis=1), np.stack([x, 0 * x + 3e-5, 0 * x], axis=1)])
    faces = np.concatenate([np.stack([i, i + 1, n + 2 + i], axis=1), np.stack([i, n + 2 + i, n + 1 + i], axis=1)])
    solver = ExactDistance(TriangleMesh(points, faces))
    front, _ = solver._front(vertex_points(solver.mesh, [n // 2]), inf, NONE, NONE)
    np.testing.assert_allclose(front.distance, np.linalg.norm(points - points[n // 2], axis=1), rtol=1e-11)
    assert front.counts[LAST] < 1000
