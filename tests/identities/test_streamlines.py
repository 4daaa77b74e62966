"""Evenly spaced streamlines: exact distances, tangent segments, spacing, ends, invariances."""

import numpy as np
import pytest

from geomhw.errors import ArgumentError, MeshError
from geomhw.flow.even_streamlines import even_streamlines
from geomhw.flow.flat_faces import flat_faces
from geomhw.flow.harmonic import harmonic_basis
from geomhw.flow.initial_fields import random_field, rigid_field
from geomhw.flow.nearby_lines import LineStore, nearest_line
from geomhw.flow.search_windows import search_room
from geomhw.flow.streamline_polylines import STOPS, Streamlines
from geomhw.flow.tangent_fields import tangential
from geomhw.geodesic.shortest_paths import ShortestPaths
from geomhw.mesh.named_points import face_point
from geomhw.mesh.primitives import grid, icosphere, torus
from geomhw.mesh.surface_points import concatenate
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.gradient import gradient_of
from support.meshes import annulus, book, crumpled

BALL, RING = icosphere(3), torus(32, 16)
SHEET = grid(12, 10)
#: Meshes with fields of several kinds, and a spacing.
CASES = {
    "rotation": (BALL, rigid_field(BALL, [0.3, 0.2, 1.0]), 0.3),
    "stream function": (BALL, np.cross(BALL.face_normals, gradient_of(BALL, BALL.vertices[:, 2])), 0.25),
    "random": (RING, random_field(RING, 3), 0.3),
    "harmonic": (RING, harmonic_basis(RING)[0], 0.3),
    "saddle": (SHEET, (SHEET.face_centers - [0.5, 0.4, 0]) * [1, -1, 0], 0.08),
    "spiral": (SHEET, np.cross([0, 0, 1], SHEET.face_centers - [0.5, 0.4, 0]) - 0.1 * SHEET.face_centers, 0.08),
    "crumpled": (crumpled(RING), random_field(crumpled(RING), 2, 4), 0.4),
}
FOUND: dict[str, Streamlines] = {}
KINDS = pytest.mark.parametrize("name", CASES)


def found(name: str) -> Streamlines:
    """Return the streamlines of a case."""
    return FOUND.setdefault(name, even_streamlines(*CASES[name]))


def inner_segments(lines: Streamlines) -> np.ndarray:
    """Return the first point of each segment."""
    return np.setdiff1d(np.arange(len(lines.faces)), lines.lines[1:] - 1)


@pytest.mark.parametrize(
    "mesh", [crumpled(torus(16, 13)), annulus(), icosphere(1)], ids=["saddles", "boundary", "convex"]
)
def test_search_finds_exact_distance(mesh: TriangleMesh) -> None:
    """The nearest point is as far as the shortest path on the surface is long."""
    rng, flat, paths = np.random.default_rng(0), flat_faces(mesh), ShortestPaths(mesh)
    for _ in range(8):
        (f, g), (a, b) = rng.integers(0, mesh.n_faces, 2), rng.dirichlet(np.ones(3), 2)
        first = np.full(mesh.n_faces, -1)
        first[f] = 0
        numbers, zero = np.zeros(1, dtype=np.int64), np.zeros(1)
        store = LineStore(
            numbers + f, numbers, a[None], a[None], zero, zero, zero, numbers.astype(np.int32), numbers - 1, first
        )
        distance, line = nearest_line(flat, store, search_room(mesh), int(g), b, 1e3, 7, np.nan, 1.0)
        path = paths.to_nearest(face_point(mesh, int(f), a), face_point(mesh, int(g), b))[0]
        assert line == 0
        assert distance == pytest.approx(path.length, rel=1e-6, abs=1e-9)


@KINDS
def test_segments_follow_the_field(name: str) -> None:
    """Each segment lies in its face along the field, forward; it follows an edge only where the fields meet there."""
    lines, V = found(name), tangential(CASES[name][0], CASES[name][1])
    first = inner_segments(lines)
    step = lines.positions[first + 1] - lines.positions[first]
    direction = V[lines.faces[first]]
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    free = lines.along_edge[first] == 0
    assert np.linalg.norm(np.cross(step, direction)[free], axis=1).max() < 1e-12
    assert (np.einsum("sx,sx->s", step, direction)[free] > -1e-13).all()
    assert free.mean() > 0.8
    assert (lines.weights >= 0).all()
    np.testing.assert_allclose(lines.weights.sum(axis=1), 1, atol=1e-14)
    assert ((lines.weights[first[~free]] == 0).any(axis=1)).all()
    np.testing.assert_allclose(np.diff(lines.arc_length)[first], np.linalg.norm(step, axis=1), atol=1e-12)
    np.testing.assert_allclose(
        (np.diff(lines.time) * lines.speed[:-1])[first[free]], np.diff(lines.arc_length)[first[free]], atol=1e-12
    )


@KINDS
def test_even_spacing(name: str) -> None:
    """Distances to the nearest streamline are from half of the spacing to twice it."""
    spacing = CASES[name][2]
    lines = found(name)
    ratios = lines.neighbor_distances / spacing
    assert ((ratios >= 0.5) & (ratios <= 2)).mean() > 0.98
    assert 0.7 < np.median(ratios) < 1.2


@pytest.mark.parametrize("name", ["random", "crumpled"])
def test_spacing_by_shortest_paths(name: str) -> None:
    """Shortest paths from points of a streamline to those of all others are as long as the spacing, too."""
    mesh, _, spacing = CASES[name]
    lines, paths = found(name), ShortestPaths(mesh)
    number = np.repeat(np.arange(len(lines)), np.diff(lines.lines))
    points = [face_point(mesh, int(f), b) for f, b in zip(lines.faces, lines.weights, strict=True)]
    for k in np.random.default_rng(1).choice(len(points), 4, replace=False):
        others = concatenate([point for point, line in zip(points, number, strict=True) if line != number[k]])
        assert 0.59 < paths.to_nearest(others, points[k])[0].length / spacing < 2


def test_parallel_lines() -> None:
    """A constant field on a square gives straight lines at exactly the spacing, from boundary to boundary."""
    lines = even_streamlines(SHEET, np.tile([1.0, 0, 0], (SHEET.n_faces, 1)), 0.1)
    heights = np.sort(lines.positions[lines.lines[:-1], 1])
    np.testing.assert_allclose(np.diff(heights), 0.1, rtol=1e-7)
    np.testing.assert_allclose(lines.lengths, 1, rtol=1e-12)
    assert (lines.stops == STOPS.index("boundary")).all()


def test_closed_lines() -> None:
    """All streamlines of n x grad z on the sphere close, but those that meet a saddle of the interpolated z."""
    lines = found("stream function")
    assert lines.closed.sum() > 0.9 * len(lines)
    for k in np.flatnonzero(lines.closed):
        first, last = lines.lines[k], lines.lines[k + 1] - 1
        np.testing.assert_allclose(lines.positions[first], lines.positions[last], atol=1e-12)
        assert lines.faces[first] == lines.faces[last]
        heights = lines.positions[first : last + 1, 2]
        assert np.ptp(heights) < 1e-12


def test_reasons_of_ends() -> None:
    """Streamlines say where they end: at the boundary and the source, or near others."""
    lines = even_streamlines(SHEET, SHEET.face_centers - [0.51, 0.42, 0], 0.08)
    boundary = np.isclose(lines.positions[:, :2], 0) | np.isclose(lines.positions[:, :2], 1)
    at_boundary = boundary.any(axis=1)[lines.lines[1:] - 1]
    assert (lines.stops[at_boundary, 1] == STOPS.index("boundary")).all()
    assert {STOPS[k] for k in lines.stops[:, 0]} == {"critical point", "near another"}
    counts = lines.report()["ends"]
    assert counts["critical point"] >= 1
    assert sum(counts.values()) == 2 * len(lines)


@pytest.mark.parametrize("name", ["rotation", "random", "crumpled"])
def test_invariance(name: str) -> None:
    """Rescaling, turning and renumbering change nothing beyond rounding."""
    mesh, V, spacing = CASES[name]
    lines, rng = found(name), np.random.default_rng(4)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    vertices, faces = rng.permutation(mesh.n_vertices), rng.permutation(mesh.n_faces)
    renamed = np.argsort(vertices)[mesh.faces[faces]][:, [1, 2, 0]]
    scale = 1e-12
    moved = TriangleMesh(scale * mesh.vertices[vertices] @ turn.T, renamed)
    again = even_streamlines(moved, (V @ turn.T)[faces], scale * spacing)
    np.testing.assert_array_equal(again.stops, lines.stops)
    np.testing.assert_allclose(again.positions @ turn / scale, lines.positions, atol=1e-7)


def test_fields_without_streamlines() -> None:
    """A zero field has none, and on a mesh of two parts, one at rest, they fill the other."""
    assert len(even_streamlines(BALL, np.zeros((BALL.n_faces, 3)), 0.3)) == 0
    n, m = BALL.n_vertices, BALL.n_faces
    pair = TriangleMesh(
        np.concatenate([BALL.vertices, BALL.vertices + 3]), np.concatenate([BALL.faces, BALL.faces + n])
    )
    V = np.concatenate([np.zeros((m, 3)), CASES["rotation"][1]])
    assert (even_streamlines(pair, V, 0.3).faces >= m).all()


def test_impossible_arguments() -> None:
    """A spacing is positive and finite, and edges have at most two faces."""
    for spacing in (0.0, -1.0, np.inf, np.nan, 1e-9):
        with pytest.raises(ArgumentError, match="spacing"):
            even_streamlines(BALL, CASES["rotation"][1], spacing)
    pages = book()
    with pytest.raises(MeshError, match="manifold"):
        even_streamlines(pages, np.ones((pages.n_faces, 3)), 0.3)
