"""n-direction fields as complex numbers u = zⁿ at vertices, their energy, and their directions.

Knöppel, Crane, Pinkall, Schröder: Globally Optimal Direction Fields. ACM Trans. Graph. 32(4), 2013.
"""

import numpy as np
import scipy.sparse as sp

from geomhw.arrays import Complexes, Floats, scatter_add
from geomhw.errors import ArgumentError
from geomhw.mesh.curvature import angle_defects
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.edge_matrix import edge_matrix, weight_sums
from geomhw.operators.parallel_transport import edge_transport, from_complex, to_complex

#: Numbers of directions: vectors, lines, crosses, and six directions.
COUNTS = (1, 2, 4, 6)


def power_transport(mesh: TriangleMesh, n: int) -> Complexes:
    """Return the unit complex number r_ijⁿ, (e,), that brings u = zⁿ from j to i along each edge (i, j), i < j.

    The connection is the intrinsic one, so that transport about a face turns u by n times its curvature.
    """
    return np.asarray(edge_transport(mesh, "intrinsic") ** n)


def direction_energy(mesh: TriangleMesh, n: int, s: float = 0.0, nonnegative: bool = False) -> sp.csr_array:
    """Assemble the energy of n-direction fields, uᴴAu = ∫ |∇u|² - s n ∫ K |u|².

    Parameters
    ----------
    n : 1, 2, 4 or 6.
    s : 0 for the Dirichlet energy, 1 for the holomorphic energy, which is zero for conformal fields, -1 for the
        antiholomorphic one, or a number between.
    nonnegative : whether negative cotan weights, at edges that are not Delaunay, are replaced by 0.

    Returns
    -------
    (n_vertices, n_vertices) complex sparse array, dimensionless, weak, Hermitian.

    Raises
    ------
    ArgumentError
        If n or s is out of range.
    MeshError
        If the mesh is not an oriented manifold with a single fan at each vertex, or a face has zero area.

    References
    ----------
    Knöppel, Crane, Pinkall, Schröder: Globally Optimal Direction Fields, 2013, sec. 4 and 6.1.1.
    """
    if n not in COUNTS:
        choices = ", ".join(map(str, COUNTS))
        raise ArgumentError(f"fields of {n} directions are not computed; choose from {choices}")
    if not -1 <= s <= 1:
        raise ArgumentError(f"s is between -1 and 1, not {s:g}")
    mesh.require_area()
    w = np.maximum(mesh.edge_cotan_weights, 0.0) if nonnegative else mesh.edge_cotan_weights
    diagonal = weight_sums(mesh.edges, w, mesh.n_vertices) - s * n * angle_defects(mesh)
    return edge_matrix(mesh.edges, -w * power_transport(mesh, n), diagonal)


def unit_power(u: Complexes) -> Complexes:
    """Return u / |u|, (n,); 1 where u is zero."""
    size = np.abs(u)
    return np.where(size > 0, u / np.where(size > 0, size, 1.0), 1.0)


def power_of(mesh: TriangleMesh, vectors: Floats, n: int) -> Complexes:
    """Return |z| (z/|z|)ⁿ, (n_vertices,), of the tangential parts z of vectors at vertices, (n_vertices, 3)."""
    z = to_complex(mesh, vectors)
    return np.asarray(np.abs(z) * unit_power(z) ** n)


def directions_of(mesh: TriangleMesh, u: Complexes, n: int) -> Floats:
    """Return the n unit directions at each vertex, (n, n_vertices, 3): the roots of u, counterclockwise."""
    root = np.exp(1j * np.angle(u) / n)
    return np.stack([from_complex(mesh, root * np.exp(2j * np.pi * k / n)) for k in range(n)])


def edge_turns(mesh: TriangleMesh, u: Complexes, n: int) -> Floats:
    """Return the angle, (e,), between -π and π, by which u at j leads u brought from i to j, for each edge (i, j)."""
    i, j = mesh.edges.T
    return np.angle(u[j] * power_transport(mesh, n) * np.conj(u[i]))


def face_curvatures(mesh: TriangleMesh) -> Floats:
    """Return the integrated curvature of each face, (m,), radians: the sum of its scaled angles, minus π.

    Angles around an inner vertex are scaled to a full turn. On a closed mesh the curvatures sum to 2π χ; else to 2π χ
    minus the turns of the boundary.
    """
    totals = scatter_add(mesh.angles.ravel(), mesh.faces.ravel(), mesh.n_vertices)
    scale = 2 * np.pi / np.where(totals > 0, totals, 1.0)
    scale[mesh.boundary_vertices] = 1.0
    return np.asarray((mesh.angles * scale[mesh.faces]).sum(axis=1) - np.pi)
