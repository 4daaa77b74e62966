"""Meshes of m faces that share one edge or one vertex, or that lie beside each other in one strip."""

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.mesh.triangle_mesh import TriangleMesh


def _circle(n: int) -> tuple[Floats, Ints]:
    """Return n points on the unit circle, (n, 3), and their numbers."""
    angles = np.linspace(0, 2 * np.pi, n, endpoint=False)
    return np.column_stack([np.cos(angles), np.sin(angles), np.zeros(n)]), np.arange(n)


def cone(m: int, height: float = 0.0) -> TriangleMesh:
    """A fan of m faces round vertex 0, flat by default."""
    circle, k = _circle(m)
    return TriangleMesh(np.vstack([[[0, 0, height]], circle]), np.column_stack([0 * k, k + 1, (k + 1) % m + 1]))


def bipyramid(m: int) -> TriangleMesh:
    """A closed surface of m faces, half of them at vertex 0 and half at vertex 1."""
    circle, k = _circle(m // 2)
    after = (k + 1) % len(k) + 2
    faces = np.vstack([np.column_stack([0 * k, k + 2, after]), np.column_stack([0 * k + 1, after, k + 2])])
    return TriangleMesh(np.vstack([[[0, 0, 1], [0, 0, -1]], circle]), faces)


def book(m: int) -> TriangleMesh:
    """m faces at the edge between vertices 0 and 1, on one half of a turn, so that they have a common normal."""
    circle, k = _circle(2 * m)
    points = np.vstack([[[0, 0, -0.5], [0, 0, 0.5]], circle[:m]])
    return TriangleMesh(points, np.column_stack([0 * k, 0 * k + 1, k + 2])[:m])


def needles(m: int) -> TriangleMesh:
    """A strip of m faces of height 1 and width 1e-5."""
    k, zero = np.arange(m // 2 + 1), np.zeros(m // 2 + 1)
    points = np.vstack([np.column_stack([1e-5 * k, zero, zero]), np.column_stack([1e-5 * k, zero + 1, zero])])
    low, high = k[:-1], k[:-1] + m // 2 + 1
    faces = np.vstack([np.column_stack([low, low + 1, high]), np.column_stack([low + 1, high + 1, high])])
    return TriangleMesh(points, faces)


#: Each shape by its name: a function of the number of faces.
CROWDED = {
    "fan": cone,
    "cone": lambda m: cone(m, 1.0),
    "bipyramid": bipyramid,
    "book": book,
    "needles": needles,
}
