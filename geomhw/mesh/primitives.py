"""Mesh generators: icosphere, grid, strip, torus, cylinder and Möbius band.

All meshes are deterministic and oriented outward; flat ones have the normal +z.
"""

from typing import Literal

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.mesh.geometry import unit
from geomhw.mesh.topology import unique_edges
from geomhw.mesh.triangle_mesh import TriangleMesh

# -- spheres -----------------------------------------------------------------------------------------------------------


def icosphere(level: int, radius: float = 1.0) -> TriangleMesh:
    """Generate a sphere around the origin: an icosahedron, each face split into four ``level`` times.

    Returns
    -------
    TriangleMesh
        10·4^level + 2 vertices; those of the previous level come first.

    Examples
    --------
    >>> [icosphere(level).n_vertices for level in range(4)]
    [12, 42, 162, 642]
    """
    points, faces = _icosahedron()
    for _ in range(level):
        edges = unique_edges(faces)
        middle = len(points) + edges.of_faces  # of the edge opposite each corner
        points = unit(np.concatenate([points, points[edges.vertices].sum(axis=1)]))
        a, b, c = faces.T
        x, y, z = middle.T
        faces = np.stack([a, z, y, z, b, x, y, x, c, x, y, z], axis=1).reshape(-1, 3)
    return TriangleMesh(radius * points, faces)


def _icosahedron() -> tuple[Floats, Ints]:
    """Return the vertices, (12, 3), and faces, (20, 3), of the icosahedron in the unit sphere."""
    golden = (1 + np.sqrt(5)) / 2
    short = np.array([[-1, golden, 0], [1, golden, 0], [-1, -golden, 0], [1, -golden, 0]])
    points = unit(np.concatenate([np.roll(short, k, axis=1) for k in range(3)]))
    # Faces are the triples at edge distance, oriented outward.
    a, b, c = np.indices((12, 12, 12)).reshape(3, -1)
    near = points @ points.T > 0.4  # neighbors have cosine 1/√5, other pairs less
    outward = np.linalg.det(points[np.stack([a, b, c], axis=1)]) > 0
    faces = np.stack([a, b, c], axis=1)[near[a, b] & near[b, c] & near[c, a] & outward & (a < b) & (a < c)]
    return points, faces


# -- lattices, flat and periodic ---------------------------------------------------------------------------------------


def grid(
    nx: int,
    ny: int,
    width: float = 1.0,
    height: float = 1.0,
    diagonal: Literal["alternating", "uniform"] = "alternating",
) -> TriangleMesh:
    """Generate the rectangle [0, width] x [0, height] in the plane z = 0.

    Parameters
    ----------
    nx, ny : int
        Number of cells along x and y; each cell has two triangles.
    width, height : float
    diagonal : {"alternating", "uniform"}
        Whether the diagonals of neighboring cells alternate or are parallel.

    Returns
    -------
    TriangleMesh
        Vertex j (nx + 1) + i lies at (i width/nx, j height/ny, 0). The normal is +z.

    Examples
    --------
    >>> grid(4, 3)
    TriangleMesh(20 vertices, 24 faces)
    """
    j, i = np.indices((ny + 1, nx + 1)).reshape(2, -1)
    points = np.stack([i * width / nx, j * height / ny, np.zeros(len(i))], axis=1)
    return TriangleMesh(points, _lattice_faces(nx, ny, alternate=diagonal == "alternating"))


def strip(length_cells: int, width_cells: int = 1, cell: float = 1.0) -> TriangleMesh:
    """Generate a flat strip of square cells of side ``cell`` along x; the numbering is that of `grid`.

    Examples
    --------
    >>> strip(100)
    TriangleMesh(202 vertices, 200 faces)
    """
    return grid(length_cells, width_cells, length_cells * cell, width_cells * cell)


def torus(n_major: int, n_minor: int, major: float = 1.0, minor: float = 0.4) -> TriangleMesh:
    """Generate a torus around the z axis with n_major x n_minor vertices.

    Parameters
    ----------
    n_major, n_minor : int
        Number of vertices around the axis and around the tube.
    major, minor : float
        Radius of the center circle and of the tube.

    Examples
    --------
    >>> torus(24, 12).genus
    1
    """
    j, i = np.indices((n_minor, n_major)).reshape(2, -1)
    u, v = 2 * np.pi * i / n_major, 2 * np.pi * j / n_minor
    r = major + minor * np.cos(v)
    points = np.stack([r * np.cos(u), r * np.sin(u), minor * np.sin(v)], axis=1)
    return TriangleMesh(points, _lattice_faces(n_major, n_minor, wrap_i=True, wrap_j=True))


def cylinder_band(n_around: int, n_high: int, radius: float = 1.0, height: float = 1.0) -> TriangleMesh:
    """Generate an open cylinder around the z axis, -height/2 ≤ z ≤ height/2, with n_around x n_high cells.

    Examples
    --------
    >>> len(cylinder_band(12, 3).boundary_loops)
    2
    """
    j, i = np.indices((n_high + 1, n_around)).reshape(2, -1)
    u = 2 * np.pi * i / n_around
    points = np.stack([radius * np.cos(u), radius * np.sin(u), height * (j / n_high - 0.5)], axis=1)
    return TriangleMesh(points, _lattice_faces(n_around, n_high, wrap_i=True))


def moebius_band(n_around: int, n_across: int, radius: float = 1.0, width: float = 0.6) -> TriangleMesh:
    """Generate a Möbius band around the z axis with n_around x n_across cells.

    Parameters
    ----------
    n_around, n_across : int
        Number of cells along and across the band.
    radius, width : float
        Radius of the center circle and width of the band.

    Examples
    --------
    >>> band = moebius_band(40, 4)
    >>> band.is_orientable, len(band.boundary_loops)
    (False, 1)
    """
    j, i = np.indices((n_across + 1, n_around)).reshape(2, -1)
    u, s = 2 * np.pi * i / n_around, width * (j / n_across - 0.5)
    r = radius + s * np.cos(u / 2)
    points = np.stack([r * np.cos(u), r * np.sin(u), s * np.sin(u / 2)], axis=1)
    faces = _lattice_faces(n_around, n_across)
    # Column n_around is column 0 with reversed rows.
    row, column = np.divmod(faces, n_around + 1)
    past = column == n_around
    return TriangleMesh(points, np.where(past, (n_across - row) * n_around, row * n_around + column))


def _lattice_faces(ni: int, nj: int, wrap_i: bool = False, wrap_j: bool = False, alternate: bool = False) -> Ints:
    """Return two triangles for each of ni x nj cells; vertices are numbered with i fastest."""
    j, i = np.indices((nj, ni)).reshape(2, -1)
    columns, rows = ni + (not wrap_i), nj + (not wrap_j)
    a, b = j * columns + i, j * columns + (i + 1) % columns
    c, d = (j + 1) % rows * columns + (i + 1) % columns, (j + 1) % rows * columns + i
    quads = np.stack([a, b, c, d], axis=1)
    odd = ((i + j) % 2 == 1) & alternate
    return split_quads(np.where(odd[:, None], np.roll(quads, 1, axis=1), quads))


def split_quads(quads: Ints) -> Ints:
    """Split quads, (q, 4), into triangles, (2q, 3), along the diagonal from the first corner to the third."""
    return quads[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
