"""Exact distances against closed forms: tetrahedron, cube, cylinder, flat torus, flat polygons with holes."""

from itertools import product

import numpy as np
import pytest

from geomhw.geodesic.exact import ExactDistance
from geomhw.mesh.named_points import face_point
from geomhw.mesh.primitives import grid
from geomhw.mesh.triangle_mesh import TriangleMesh
from support.exact import cylinder
from support.hostile import hostile
from support.meshes import flat_torus


def box(cells: int, lengths: tuple[float, float, float] = (1, 1, 1)) -> TriangleMesh:
    """Return the surface of a box with cells² squares a side."""
    ticks = np.linspace(0, 1, cells + 1)
    points, faces = [], []
    for axis, end in product(range(3), (0.0, 1.0)):
        square = grid(cells, cells)
        place = np.full((square.n_vertices, 3), end)
        u, v = np.divmod(np.arange(square.n_vertices), cells + 1)
        place[:, (axis + 1) % 3], place[:, (axis + 2) % 3] = ticks[u], ticks[v]
        faces.append(square.faces + len(points) * square.n_vertices)
        points.append(place)
    distinct, index = np.unique(np.concatenate(points), axis=0, return_inverse=True)
    return TriangleMesh(distinct * lengths, index.ravel()[np.concatenate(faces)])


def from_middle_of_side(points: np.ndarray) -> np.ndarray:
    """Return the distances on the unit cube from (½, ½, 0): over the bottom, over a side, or over a side to the top."""
    x, y, z = points.T - [[0.5], [0.5], [0]]
    unfoldings = []
    for along, up in ((x, y), (-x, y), (y, x), (-y, x)):  # over the edge at along = ½
        unfoldings += [
            np.where(along == 0.5, np.hypot(0.5 + z, up), np.inf),
            np.where(z == 1, np.hypot(2 - along, up), np.inf),
        ]
    return np.min([np.where(z == 0, np.hypot(x, y), np.inf), *unfoldings], axis=0)


@pytest.mark.parametrize("cells", [1, 2, 3, 6])
def test_cube(cells: int) -> None:
    """From the middle of a side of a cube, a vertex or a point on a diagonal."""
    mesh = box(cells)
    middle = np.flatnonzero((mesh.vertices == [0.5, 0.5, 0]).all(axis=1))
    solver = ExactDistance(mesh)
    if len(middle):
        found = solver.from_vertices(middle)["distance"]
    else:
        # The diagonal of the bottom through its middle belongs to some face.
        centers = mesh.vertices[mesh.faces]
        flat = (centers[:, :, 2] == 0).all(axis=1)
        for f in np.flatnonzero(flat):
            A = np.vstack([centers[f, :, :2].T, np.ones(3)])
            weights = np.linalg.solve(A, [0.5, 0.5, 1])
            if (weights > -1e-12).all():
                found = solver.from_sources(face_point(mesh, int(f), np.maximum(weights, 0)))["distance"]
                break
    np.testing.assert_allclose(found, from_middle_of_side(mesh.vertices), rtol=1e-12)


def test_box_from_corner() -> None:
    """Opposite corners of a box a ≤ b ≤ c are √((a + b)² + c²) apart."""
    mesh = box(4, (1, 2, 3))
    corner = np.flatnonzero((mesh.vertices == 0).all(axis=1))
    found = ExactDistance(mesh).from_vertices(corner)["distance"]
    assert found[(mesh.vertices == [1, 2, 3]).all(axis=1)] == pytest.approx(np.hypot(3, 3), rel=1e-12)


def test_tetrahedron() -> None:
    """The middle of a side of a regular tetrahedron is 2h/3 from its corners and 4h/3 from the fourth, h the height."""
    mesh = hostile("tetrahedron")
    found = ExactDistance(mesh).from_sources(face_point(mesh, 0))["distance"]
    h = np.sqrt(8) * np.sqrt(3) / 2
    np.testing.assert_allclose(found, [2 * h / 3, 2 * h / 3, 2 * h / 3, 4 * h / 3], rtol=1e-12)


def test_cylinder() -> None:
    """On a cylinder: the shorter straight line of its two unfoldings."""
    mesh, expected = cylinder()
    np.testing.assert_allclose(ExactDistance(mesh).from_vertices([0])["distance"], expected, rtol=1e-12)


def test_flat_torus() -> None:
    """On a torus of two equal prisms joined at both ends: the straight line of the unfolded plane."""
    mesh, places, width, height = flat_torus(7, 4)
    assert not len(mesh.boundary_vertices)
    for source in (0, 9, 30):
        u, v = (places - places[source]).T
        u, v = np.minimum(abs(u), width - abs(u)), np.minimum(abs(v), height - abs(v))
        found = ExactDistance(mesh).from_vertices([source])["distance"]
        np.testing.assert_allclose(found, np.hypot(u, v), rtol=1e-12, atol=1e-12)


def test_flat_polygon_u() -> None:
    """In a U of eight corners paths turn at its two inner corners."""
    points = [[0, 0, 0], [5, 0, 0], [5, 4, 0], [4, 4, 0], [4, 1, 0], [1, 1, 0], [1, 4, 0], [0, 4, 0]]
    faces = [[0, 5, 7], [5, 6, 7], [0, 1, 5], [1, 4, 5], [1, 2, 4], [2, 3, 4]]
    found = ExactDistance(TriangleMesh(points, faces)).from_vertices([7])["distance"]
    around = np.sqrt(10)
    expected = [4, around + np.hypot(4, 1), around + 3 + np.sqrt(10), around + 6, around + 3, around, 1, 0]
    np.testing.assert_allclose(found, expected, rtol=1e-12)


def test_square_with_hole() -> None:
    """Behind a square hole, paths turn at one corner or two of it."""
    square = grid(6, 6)
    x, y = 6 * (square.vertices[:, :2] - square.vertices[:, :2].min(axis=0)).T / np.ptp(square.vertices[:, 0])
    inside = (abs(x[square.faces].mean(axis=1) - 3) < 1) & (abs(y[square.faces].mean(axis=1) - 3) < 1)
    mesh = TriangleMesh(np.stack([x, y, 0 * x], axis=1), square.faces[~inside])
    source = int(np.flatnonzero((x == 3) & (y == 0))[0])
    found = ExactDistance(mesh).from_vertices([source])["distance"]
    to_corner = np.sqrt(5)
    assert found[(x == 3) & (y == 4)] == pytest.approx(to_corner + 2 + 1, rel=1e-12)
    assert found[(x == 3) & (y == 6)] == pytest.approx(to_corner + 0 + np.hypot(1, 2) + 2, rel=1e-12)
    assert found[(x == 0) & (y == 6)] == pytest.approx(np.hypot(3, 6), rel=1e-12)
    assert found[(x == 2) & (y == 6)] == pytest.approx(to_corner + 4, rel=1e-12)
