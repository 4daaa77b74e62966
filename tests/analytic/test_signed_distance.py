"""Signed distance to whole, broken, noisy and crossing curves, and curves without sides, on spheres and tori."""

from typing import Any

import numpy as np
import pytest

from geomhw.arrays import Floats
from geomhw.curves import SignedHeat, bridge_gaps, isolines, signed_distance, trace_polyline, trace_polylines
from geomhw.errors import FieldError, MeshError
from geomhw.geodesic import ExactDistance, SurfacePath
from geomhw.mesh import SurfacePoints, TriangleMesh, curve_points, grid, icosphere, moebius_band, torus, vertex_points
from geomhw.mesh.surface_points import concatenate
from geomhw.operators.edge_vectors import edge_connection_stiffness
from support.meshes import ZOO, book, crumpled, two_spheres, zoo_mesh

BALL, COARSE = icosphere(5), icosphere(4)


def sources(*paths: SurfacePath) -> SurfacePoints:
    """Return paths as curves."""
    return concatenate([curve_points(path.mesh, path.faces, path.weights) for path in paths])


def latitude(z: float, count: int = 400) -> Floats:
    """Return the circle of latitude on the unit sphere, eastward and closed."""
    turn = np.linspace(0, 2 * np.pi, count)
    ring = np.stack([np.sqrt(1 - z**2) * np.cos(turn), np.sqrt(1 - z**2) * np.sin(turn), np.full(count, z)], axis=1)
    ring[-1] = ring[0]
    return ring


def to_latitude(mesh: TriangleMesh, z: float) -> Floats:
    """Return the signed distance on the sphere, positive to the north."""
    return np.arcsin(np.clip(mesh.vertices[:, 2], -1, 1)) - np.arcsin(z)


def test_latitudes() -> None:
    """10,242 vertices: 0.02 h in the mean by heat; 2e-4 of the radius when corrected, as the polyhedron allows."""
    curve, expected = sources(trace_polyline(BALL, latitude(0.5)).path), to_latitude(BALL, 0.5)
    plain = SignedHeat(BALL)(curve)
    assert np.abs(plain - expected).mean() < 0.01 * BALL.mean_edge_length
    result = signed_distance(BALL, curve)
    error = np.abs(result["signed_distance"] - expected)
    assert error.mean() < 1.5e-4
    assert error.max() < 5e-4
    assert result.report["vertices"] == {"exact": BALL.n_vertices, "generalized": 0, "unsigned": 0}


def test_latitudes_of_a_fine_mesh() -> None:
    """40,962 vertices: 0.02 h in the mean by heat, near the poles too."""
    fine = icosphere(6)
    heat = SignedHeat(fine)
    for z in (0.3, 0.7, 0.9):
        error = np.abs(heat(sources(trace_polyline(fine, latitude(z)).path)) - to_latitude(fine, z))
        assert error.mean() < 0.02 * fine.mean_edge_length


def test_meridians_of_a_torus() -> None:
    """By heat, 10,240 vertices: at most the error of potpourri3d, 0.1865 h; two regions meet where distances cross."""
    ring = torus(160, 64)
    curve = sources(*(SurfacePath(ring, *c) for c in isolines(ring, ring.vertices[:, 0], [0.013]).curves))
    expected = np.where(ring.vertices[:, 0] > 0.013, 1, -1) * ExactDistance(ring).from_sources(curve)["distance"]
    error = np.abs(SignedHeat(ring)(curve) - expected)
    assert error.mean() < 0.1865 * ring.mean_edge_length


def broken(kind: str) -> list[SurfacePath]:
    """Return a circle of latitude without a fifth of its segments."""
    ring, kept = latitude(0.5, 151), np.ones(150, dtype=bool)
    if kind == "random":
        kept[np.random.default_rng(0).permutation(150)[:30]] = False
    else:
        kept[10:40] = False
    rows = np.flatnonzero(kept)
    parts = np.split(rows, np.flatnonzero(np.diff(rows) > 1) + 1)
    lines = [ring[part[0] : part[-1] + 2] for part in parts]
    return [curve.path for curve in trace_polylines(COARSE, lines, ["part"] * len(parts))]


@pytest.mark.parametrize("kind", ["random", "one gap"])
def test_a_fifth_is_missing(kind: str) -> None:
    """With its gaps closed, a broken curve has at most twice the mean error of the whole; without, part of an edge."""
    paths, expected = broken(kind), to_latitude(COARSE, 0.5)
    whole = sources(trace_polyline(COARSE, latitude(0.5, 151)).path)
    closed = sources(*paths, *bridge_gaps(COARSE, paths))
    result = signed_distance(COARSE, closed)
    assert result.report["vertices"]["exact"] == COARSE.n_vertices
    for correct in (True, False):
        error, least = (
            np.abs(signed_distance(COARSE, curve, correct)["signed_distance"] - expected).mean()
            for curve in (closed, whole)
        )
        assert error < 2 * least
    opened = signed_distance(COARSE, sources(*paths))
    assert opened.report["vertices"]["generalized"] == COARSE.n_vertices
    assert np.abs(opened["signed_distance"] - expected).mean() < 0.3 * COARSE.mean_edge_length


def test_noisy_curve() -> None:
    """Noise of a fifth of an edge, which makes the curve cross itself, keeps the sign away from it."""
    ring = latitude(0.3, 500)
    ring[:-1] += 0.2 * COARSE.mean_edge_length * np.random.default_rng(1).normal(size=(499, 3))
    ring[-1] = ring[0]
    expected = to_latitude(COARSE, 0.3)
    found = signed_distance(COARSE, sources(trace_polyline(COARSE, ring).path))["signed_distance"]
    far = np.abs(expected) > COARSE.mean_edge_length
    assert (np.sign(found[far]) == np.sign(expected[far])).all()
    assert np.abs(found - expected).mean() < 0.6 * COARSE.mean_edge_length


def test_meridian_pair_of_a_torus() -> None:
    """Two meridians of opposite direction bound two halves; one alone has the same piece on both sides."""
    ring = torus(60, 30)
    lines = isolines(ring, ring.vertices[:, 0], [0.013])
    pair = concatenate([curve_points(ring, *curve) for curve in lines.curves])
    found = signed_distance(ring, pair)
    unsigned = ExactDistance(ring).from_sources(pair)["distance"]
    side = np.where(ring.vertices[:, 0] > 0.013, 1, -1)
    np.testing.assert_allclose(found["signed_distance"], side * unsigned, atol=1e-12)
    plain = SignedHeat(ring)(pair)
    assert np.abs(plain - side * unsigned).mean() < 0.3 * ring.mean_edge_length
    alone = signed_distance(ring, curve_points(ring, *lines.curves[0]))
    assert alone.report["vertices"]["unsigned"] == ring.n_vertices
    assert (alone["signed_distance"] >= 0).all()
    one, other = (SurfacePath(ring, *curve).positions for curve in lines.curves)
    same_way = signed_distance(ring, sources(*(trace_polyline(ring, line).path for line in (one, other[::-1]))))
    assert same_way.report["vertices"]["unsigned"] == ring.n_vertices


def test_zero_level_is_the_curve_and_slopes_are_one() -> None:
    """Distances beside the curve are those to its segments, on both sides, and unit slope holds to the mesh size."""
    square = crumpled(grid(24, 24))
    square = TriangleMesh(square.vertices * [1, 1, 0], square.faces)
    corners = np.array([[0.3, 0.3, 0], [0.71, 0.32, 0], [0.52, 0.74, 0], [0.3, 0.3, 0]])
    curve = sources(trace_polyline(square, corners).path)
    found = signed_distance(square, curve)["signed_distance"]
    unsigned = ExactDistance(square).from_sources(curve)["distance"]
    a, b, c = corners[:3, :2]
    P = square.vertices[:, :2]

    def left_of(p: Floats, q: Floats) -> np.ndarray:
        return (q[0] - p[0]) * (P[:, 1] - p[1]) - (q[1] - p[1]) * (P[:, 0] - p[0]) > 0

    inside = left_of(a, b) & left_of(b, c) & left_of(c, a)
    np.testing.assert_allclose(found, np.where(inside, unsigned, -unsigned), atol=1e-12)


def test_open_and_crossing_curves() -> None:
    """A segment has both signs beside it; a figure eight has a sign in each lobe."""
    square = grid(30, 30)
    found = signed_distance(square, sources(trace_polyline(square, [[0.3, 0.5, 0], [0.7, 0.5, 0]]).path))
    d, (x, y) = found["signed_distance"], square.vertices[:, :2].T
    assert found.report["vertices"]["generalized"] > 0
    beside = (np.abs(x - 0.5) < 0.15) & (np.abs(y - 0.5) < 0.2)
    np.testing.assert_allclose(d[beside], (y - 0.5)[beside], atol=0.1 * square.mean_edge_length)
    turn = np.linspace(0, 2 * np.pi, 161)
    eight = np.stack([0.5 + 0.35 * np.sin(turn), 0.5 + 0.35 * np.sin(turn) * np.cos(turn), 0 * turn], axis=1)
    eight[-1] = eight[0]
    lobes = signed_distance(square, sources(trace_polyline(square, eight).path))
    signs = [np.sign(lobes["signed_distance"][np.argmin(np.hypot(x - u, y - 0.5))]) for u in (0.25, 0.75)]
    assert sorted(signs) == [-1, 1]
    assert lobes.report["vertices"]["exact"] > 0


def test_strip_from_boundary_to_boundary() -> None:
    """A curve that ends on the boundary divides the surface, too."""
    square = grid(12, 12)
    curve = sources(trace_polyline(square, [[0.37, 0, 0], [0.37, 1, 0]]).path)
    found = signed_distance(square, curve)
    np.testing.assert_allclose(found["signed_distance"], 0.37 - square.vertices[:, 0], atol=1e-12)
    assert found.report["vertices"]["exact"] == square.n_vertices


@pytest.mark.parametrize("change", [{"scale": 1e-9}, {"scale": 1e9}, {"reverse": True}, {"renumber": True}])
def test_invariance(change: dict[str, Any]) -> None:
    """Scale and numbering change nothing; reversing the curve changes the sign."""
    ball = icosphere(3)
    ring = latitude(0.3, 100)
    before = [
        signed_distance(ball, sources(trace_polyline(ball, ring).path), correct)["signed_distance"]
        for correct in (True, False)
    ]
    scale = change.get("scale", 1.0)
    order = (
        np.random.default_rng(0).permutation(ball.n_vertices) if change.get("renumber") else np.arange(ball.n_vertices)
    )
    other = TriangleMesh(scale * ball.vertices[order], np.argsort(order)[ball.faces])
    points = scale * (ring[::-1] if change.get("reverse") else ring)
    sign = -1 if change.get("reverse") else 1
    for correct, expected in zip((True, False), before, strict=True):
        found = signed_distance(other, sources(trace_polyline(other, points).path), correct)["signed_distance"]
        np.testing.assert_allclose(found, sign * scale * expected[order], atol=1e-6 * scale)


def test_components_without_a_curve() -> None:
    """Their distance is infinite; other components do not change."""
    balls = two_spheres()
    path = trace_polyline(balls, latitude(0.2, 60)).path
    for correct in (True, False):
        result = signed_distance(balls, sources(path), correct)
        far = balls.vertices[:, 0] > 2
        assert np.isinf(result["signed_distance"][far]).all()
        assert np.isfinite(result["signed_distance"][~far]).all()
        assert result.report["unreachable_vertices"] == far.sum() - 1  # one vertex has no face


@pytest.mark.parametrize("name", ZOO)
def test_edge_connection(name: str) -> None:
    """The stiffness is Hermitian and positive semidefinite; on flat meshes parallel fields are in its kernel."""
    mesh = zoo_mesh(name)
    L = edge_connection_stiffness(mesh)
    assert abs(L - L.conj().T).max() < 1e-12 * abs(L).max()
    v = np.random.default_rng(0).normal(size=mesh.n_edges) + 1j * np.random.default_rng(1).normal(size=mesh.n_edges)
    assert (v.conj() @ (L @ v)).real > 0
    if np.ptp(mesh.vertices[:, 2]) == 0:
        along = mesh.vertices[mesh.edges[:, 1]] - mesh.vertices[mesh.edges[:, 0]]
        parallel = 1 / (along @ np.array([1, 1j, 0]))
        assert np.abs(L @ (parallel / np.abs(parallel))).max() < 1e-10


def test_refusals() -> None:
    """Points, one-sided surfaces and edges of more than two faces are errors."""
    ball = icosphere(2)
    with pytest.raises(FieldError, match="curve"):
        signed_distance(ball, vertex_points(ball, [3]))
    band = moebius_band(40, 4)
    with pytest.raises(MeshError, match="one-sided"):
        signed_distance(band, sources(trace_polyline(band, band.vertices[[0, 9]]).path))
    pages = book(3)
    with pytest.raises(MeshError, match="3 faces meet"):
        signed_distance(pages, sources(trace_polyline(pages, [[0.5, 0, 0.4], [-0.25, 0.433, 0.4]]).path))
