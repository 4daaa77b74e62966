"""Isolines of piecewise-linear functions: complete, without doubles, through ties, and with both sides measured."""

import numpy as np
import pytest

from geomhw.curves import Isolines, isolines, split_mesh
from geomhw.errors import ArgumentError, FieldError
from geomhw.io import read_mesh
from geomhw.mesh import TriangleMesh, grid, icosphere, torus
from geomhw.mesh.topology import linked_components
from support.hostile import HOSTILE, hostile
from support.meshes import ZOO, zoo_mesh
from support.reference import needs_reference, reference

#: Meshes with coordinates in range, and with coordinates that tell neighboring vertices apart to 1e-12.
FINE = [name for name in HOSTILE if name not in ("huge_150", "tiny_150", "tiny_310", "far", "far_lost", "one_point")]
FILES = ["closed/moomoo.off", "closed/3holes.off", "hostile/camelhead.off", "hostile/lego.ply", "hostile/moebius.obj"]
FILES += ["hostile/fan3.obj", "hostile/triple_vierbein.obj", "hostile/platonic_shelf.obj", "hostile/woody.obj"]


def face_lengths(mesh: TriangleMesh, values: np.ndarray, level: float) -> float:
    """Return the sum over faces of the length of the level set, by the co-area formula: no vertex is at the level."""
    faces = np.delete(mesh.faces, mesh.duplicate_faces[:, 0], axis=0)
    above = values[faces] > level
    faces, above = faces[above.any(axis=1) & ~above.all(axis=1)], above[above.any(axis=1) & ~above.all(axis=1)]
    alone = np.where(above.sum(axis=1) == 1, above.argmax(axis=1), (~above).argmax(axis=1))
    tip = np.take_along_axis(faces, alone[:, None], axis=1)[:, 0]
    ends = []
    for step in (1, 2):
        other = np.take_along_axis(faces, (alone[:, None] + step) % 3, axis=1)[:, 0]
        share = (level - values[tip]) / (values[other] - values[tip])
        ends.append(mesh.vertices[tip] + share[:, None] * (mesh.vertices[other] - mesh.vertices[tip]))
    return float(np.linalg.norm(ends[0] - ends[1], axis=1).sum())


def check(mesh: TriangleMesh, values: np.ndarray, found: Isolines) -> None:
    """Points lie at their level in their face, faces have one segment a level, closed lines close, lengths add up."""
    line = np.repeat(np.arange(len(found)), np.diff(found.starts))
    corners = mesh.faces[found.faces]
    size = np.abs(mesh.vertices[mesh.faces]).max()
    assert (found.weights >= 0).all()
    positions = np.einsum("kc,kcx->kx", found.weights, mesh.vertices[corners])
    np.testing.assert_allclose(found.positions, positions, atol=1e-14 * size)
    at = np.einsum("kc,kc->k", found.weights, values[corners])
    np.testing.assert_allclose(at, found.levels[line], atol=1e-12 * np.abs(values).max())
    first, last = found.starts[:-1], found.starts[1:] - 1
    assert (found.positions[first] == found.positions[last])[found.closed].all()
    steps = np.linalg.norm(np.diff(found.positions, axis=0), axis=1)
    inner = np.ones(len(steps), dtype=bool)
    inner[last[:-1]] = False
    assert (steps[inner] > 0).all()
    sums = np.bincount(line[1:][inner], steps[inner], len(found))
    np.testing.assert_allclose(found.lengths, sums, rtol=1e-12)


def segments(found: Isolines) -> np.ndarray:
    """Return the segments as sorted pairs of rounded points, one row each."""
    inner = np.ones(len(found.positions), dtype=bool)
    inner[found.starts[1:] - 1] = False
    at = np.flatnonzero(inner)
    ends = np.stack([found.positions[at], found.positions[at + 1]], axis=1).round(9) + 0.0
    swap = np.lexsort(ends[:, :, ::-1].transpose(2, 0, 1), axis=-1) if len(ends) else np.empty((0, 2), dtype=int)
    return np.take_along_axis(ends, swap[:, :, None], axis=1).reshape(-1, 6)


def mesh_of(name: str) -> TriangleMesh:
    """Return a mesh of the zoo, a hostile one, or one of the reference folder."""
    if "/" in name:
        return read_mesh(reference(f"meshes/{name}"))
    return zoo_mesh(name) if name in ZOO else hostile(name)


NAMES = [*ZOO, *(name for name in FINE if name not in ZOO)]


@pytest.mark.parametrize("name", [*NAMES, *(pytest.param(name, marks=needs_reference) for name in FILES)])
def test_random_functions(name: str) -> None:
    """The length is the sum over faces, lines close on closed manifolds, and no face has two segments of a level."""
    mesh = mesh_of(name)
    values = np.random.default_rng(len(name)).normal(size=mesh.n_vertices)
    levels = np.quantile(values[np.unique(mesh.faces)], [0.2, 0.5, 0.83])
    found = isolines(mesh, values, levels)
    check(mesh, values, found)
    for level in levels:
        total = float(found.lengths[found.levels == level].sum())
        assert total == pytest.approx(face_lengths(mesh, values, level), rel=1e-12)
    if mesh.is_closed and mesh.is_edge_manifold and not len(mesh.duplicate_faces):
        assert found.closed.all()
        if mesh.genus == 0 and mesh.n_components == 1 and name != "hourglass":  # two spheres that share a vertex
            np.testing.assert_allclose(found.areas.sum(axis=1), mesh.face_areas.sum(), rtol=1e-12)
    line = np.repeat(np.arange(len(found)), np.diff(found.starts))
    kept = np.delete(np.arange(len(line)), found.starts[1:] - 1)
    keys = np.stack([found.faces[kept], np.searchsorted(levels, found.levels[line[kept]])], axis=1)
    assert len(np.unique(keys, axis=0)) == len(keys)


@pytest.mark.parametrize("name", NAMES)
def test_ties(name: str) -> None:
    """Levels through many vertices, edges and flat faces: no segment twice, and the lines in between stay."""
    mesh = mesh_of(name)
    values = np.round(np.random.default_rng(1).normal(size=mesh.n_vertices))
    found = isolines(mesh, values, [-1, 0, 1])
    check(mesh, values, found)
    if name not in ("same_place", "soup"):  # different vertices at one place
        rows = segments(found)
        rows = rows[np.abs(rows[:, :3] - rows[:, 3:]).max(axis=1) > 1e-8]
        assert len(np.unique(rows, axis=0)) == len(rows)


def test_between_lattice_lines() -> None:
    """A line along edges has the length of a line beside it, also at both ends of the range."""
    square = grid(4, 4)
    x = square.vertices[:, 0]
    found = isolines(square, x, [0, 0.25, 0.4, 1])
    np.testing.assert_allclose(found.lengths, np.ones(4), rtol=1e-12)
    np.testing.assert_allclose(found.areas, [[0, 1], [0.25, 0.75], [0.4, 0.6], [1, 0]], atol=1e-12)


def test_flat_region_is_outlined() -> None:
    """At the value of a plateau, the line is its outline: once, closed, whether values outside are lower or higher."""
    square = grid(8, 8)
    r = np.abs(square.vertices[:, :2] - 0.5).max(axis=1)
    for values in (np.maximum(r, 0.25), np.minimum(-r, -0.25)):
        found = isolines(square, values, [values[40]])
        assert found.closed.tolist() == [True]
        assert found.lengths.tolist() == pytest.approx([2.0])
        assert found.enclosed_areas.tolist() == pytest.approx([0.25])


def test_ridge_counts_once() -> None:
    """A ridge along edges is one open line, not a closed one there and back."""
    square = grid(4, 4)
    found = isolines(square, -np.abs(square.vertices[:, 0] - 0.5), [0.0])
    assert (found.lengths.tolist(), found.closed.tolist()) == ([pytest.approx(1.0)], [False])
    assert np.isnan(found.areas).all()


def test_saddle() -> None:
    """At a saddle with its vertex at the level, lines go round the lower values, and regions above are one."""
    square = grid(4, 4)
    x, y = (square.vertices[:, :2] - 0.5).T
    found = isolines(square, np.abs(x) - np.abs(y), [0.0])
    assert len(found) == 2
    np.testing.assert_allclose(found.areas[:, 0], 0.25, rtol=1e-12)
    np.testing.assert_allclose(found.areas[:, 1], 0.75, rtol=1e-12)


def test_nearly_at_a_vertex() -> None:
    """A level within rounding of a vertex passes through the vertex, without segments of no length."""
    ball = icosphere(2)
    values = ball.vertices[:, 2] + 3.0
    for step in range(-3, 4):
        level = values[17]
        for _ in range(abs(step)):
            level = np.nextafter(level, np.inf * step)
        found = isolines(ball, values, [level])
        check(ball, values, found)
        inner = np.delete(np.linalg.norm(np.diff(found.positions, axis=0), axis=1), found.starts[1:-1] - 1)
        assert inner.min() > 1e-12
        assert found.closed.all()


def parts_apart(mesh: TriangleMesh, found: Isolines, line: int) -> int:
    """Return the number of components of the surface without a line, by faces divided along all lines of its level."""
    inside = np.zeros(mesh.n_faces, dtype=bool)
    inside[found.faces[found.starts[line] : found.starts[line + 1]]] = True
    edges = mesh.edge_table.of_faces
    whole = np.flatnonzero(~inside)
    labels = linked_components(np.repeat(whole, 3), edges[whole].ravel() + mesh.n_faces, mesh.n_faces + mesh.n_edges)
    return len(np.unique(labels[whole]))


def test_circles_of_a_torus_do_not_separate() -> None:
    """Of the isolines round a torus, only those round its poles separate; pairs of circles do together."""
    ring = torus(40, 20)
    z, x = ring.vertices[:, 2], ring.vertices[:, 0]
    both = isolines(ring, z, [0.01])
    assert (len(both), np.isnan(both.areas).all()) == (2, True)
    caps = isolines(ring, x, [0.9 * x.max(), 0.01])
    assert np.isfinite(caps.areas).all(axis=1).tolist() == [False, False, True]
    assert parts_apart(ring, caps, 2) == 2
    assert parts_apart(ring, caps, 1) == 1


def test_areas_are_those_of_the_divided_faces() -> None:
    """Areas beside a line are those of the faces on its sides, up to the faces that it crosses."""
    ball = icosphere(4)
    values = ball.vertices @ [0.3, -0.5, 0.8]
    for level in (-0.6, 0.1, 0.5):
        found = isolines(ball, values, [level])
        middle = values[ball.faces].mean(axis=1)
        below = ball.face_areas[middle < level].sum()
        assert found.areas[0, 0] == pytest.approx(below, rel=0.02)


def test_orientation() -> None:
    """Higher values are on the left, seen from outside."""
    ball = icosphere(3)
    found = isolines(ball, ball.vertices[:, 2], [0.0, 0.3])
    for begin, end in zip(found.starts[:-1], found.starts[1:], strict=True):
        p = found.positions[begin:end]
        assert (np.cross(p[:-1], p[1:])[:, 2] > 0).all()


def test_scale_does_not_matter() -> None:
    """Scaling mesh, values and level gives the same lines, also near the ends of the range of numbers."""
    ball = icosphere(3)
    values = ball.vertices[:, 0] + 0.5 * ball.vertices[:, 1]
    plain = isolines(ball, values, [0.25])
    for size, factor in ((1e-20, 2.0**1000), (1e20, 2.0**-1000), (1.0, 1.5e308)):
        found = isolines(TriangleMesh(size * ball.vertices, ball.faces), factor * values, [factor * 0.25])
        np.testing.assert_allclose(found.weights, plain.weights, atol=1e-12)
        np.testing.assert_allclose(found.areas, plain.areas * size**2, rtol=1e-12)


def test_faces_without_values_have_no_lines() -> None:
    """Lines end where a corner is infinite or undefined."""
    square = grid(8, 8)
    values = square.vertices[:, 1].copy()
    values[square.vertices[:, 0] > 0.9] = np.inf
    values[square.vertices[:, 0] < 0.1] = np.nan
    found = isolines(square, values, [0.3])
    assert found.lengths.tolist() == pytest.approx([0.75])


def test_refusals() -> None:
    """Wrong shapes and levels are errors."""
    ball = icosphere(1)
    with pytest.raises(FieldError, match="one number per vertex"):
        isolines(ball, np.zeros(ball.n_faces), [0])
    with pytest.raises(ArgumentError, match="level"):
        isolines(ball, ball.vertices[:, 0], [])
    with pytest.raises(ArgumentError, match="finite"):
        isolines(ball, ball.vertices[:, 0], [np.nan])


@pytest.mark.parametrize("name", ["crumpled_torus", "annulus", "tetrahedron", "two_spheres", "klein", "hourglass"])
def test_areas_are_those_of_a_cut(name: str) -> None:
    """Cutting along a line that separates gives one more piece, with these areas; along another it gives none."""
    mesh = mesh_of(name)
    values = np.random.default_rng(3).normal(size=mesh.n_vertices)
    found = isolines(mesh, values, [-0.5, 0.0, 0.33])
    before = split_mesh(mesh, []).n_pieces
    for line in range(0, len(found), max(1, len(found) // 12)):
        apart = split_mesh(mesh, [found.curves[line]])
        areas = np.bincount(apart.pieces, apart.mesh.face_areas)
        if np.isnan(found.areas[line]).any():
            assert apart.n_pieces == before
        else:
            assert apart.n_pieces == before + 1
            for area in found.areas[line]:
                assert np.abs(areas - area).min() < 1e-9 * areas.sum()
