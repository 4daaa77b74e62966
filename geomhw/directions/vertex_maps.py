"""Direction fields that commute with a vertex map, and fields designed on two meshes at once through one."""

import numpy as np
import scipy.sparse as sp

from geomhw.arrays import Complexes, Floats, Ints
from geomhw.directions.power_fields import unit_power
from geomhw.directions.smooth_fields import DirectionFields
from geomhw.errors import ArgumentError
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.local_fit import LocalFit
from geomhw.spectral.eigenpairs import smallest_eigenpairs
from geomhw.spectral.field_symmetry import checked_vertex_map

#: Weight of the commutator, over 4π/area.
COMMUTATOR = 1000.0


def map_turns(mesh: TriangleMesh, onto: TriangleMesh, vertex_map: Ints) -> tuple[Complexes, Floats]:
    """Return the differential of a vertex map as turns of directions, in the tangent frames of both meshes.

    Returns
    -------
    turns : (n,) unit complex numbers: a direction z at vertex i goes to turn z at its image, or to turn conj(z).
    reversing : (n,) mask of the vertices where the map reverses the orientation.
    """
    slopes = np.stack(LocalFit(mesh).tangents(onto.vertices[vertex_map]), axis=1)
    J = np.einsum("iax,ibx->iba", slopes, onto.tangent_frames[vertex_map])
    same = (J[:, 0, 0] + J[:, 1, 1]) + 1j * (J[:, 1, 0] - J[:, 0, 1])
    reverse = (J[:, 0, 0] - J[:, 1, 1]) + 1j * (J[:, 1, 0] + J[:, 0, 1])
    reversing = np.abs(reverse) > np.abs(same)
    return unit_power(np.where(reversing, reverse, same)), reversing


def commuting(fields: DirectionFields, vertex_map: Ints, weight: float = COMMUTATOR) -> Complexes:
    """Compute the smoothest field that commutes with a vertex map of the mesh, (n_vertices,) complex.

    The energy gets the term w ∫ |u∘σ - dσ u|², w = 4π weight/area: the commutator of the field, as an operator on
    functions, with the map.

    Parameters
    ----------
    vertex_map : σ, (n_vertices,), the image of each vertex.

    Raises
    ------
    ArgumentError
        If the map is none of the vertices of the mesh.
    """
    mesh = fields.mesh
    sigma = checked_vertex_map(vertex_map, mesh.n_vertices)
    penalty = _commutator(mesh, mesh, sigma, fields.n, 0, 0, 2 * mesh.n_vertices)
    area = float(mesh.face_areas.sum())
    return _smoothest([fields], penalty * (4 * np.pi * weight / area))[0]


def joint_fields(
    first: DirectionFields, second: DirectionFields, vertex_map: Ints, weight: float = COMMUTATOR
) -> tuple[Complexes, Complexes]:
    """Compute smooth fields on two meshes that a vertex map takes to each other.

    Both fields minimize the sum of their energies, each relative to 4π/area of its mesh, and the weighted square of the
    difference between the field on the second mesh and the image of the first.

    Parameters
    ----------
    vertex_map : (n,), the vertex of the second mesh for each one of the first.

    Raises
    ------
    ArgumentError
        If the numbers of directions differ, or the map is none from the first mesh to the second.
    """
    if first.n != second.n:
        raise ArgumentError(f"both fields need as many directions, not {first.n} and {second.n}")
    one, other = first.mesh, second.mesh
    sigma = checked_vertex_map(vertex_map, one.n_vertices, other.n_vertices)
    size = 2 * (one.n_vertices + other.n_vertices)
    penalty = _commutator(one, other, sigma, first.n, 0, one.n_vertices, size) / float(one.face_areas.sum())
    u, v = _smoothest([first, second], weight * penalty)
    return u, v


def _commutator(
    mesh: TriangleMesh, onto: TriangleMesh, sigma: Ints, n: int, offset: int, image_offset: int, size: int
) -> sp.csr_array:
    """Σ m_i |u_σ(i) - dσ u_i|² as a matrix on real and imaginary parts; offsets: of the unknowns of both meshes."""
    turns, reversing = map_turns(mesh, onto, sigma)
    turns = turns**n
    i = offset + np.arange(mesh.n_vertices)
    j = image_offset + sigma
    rows = np.arange(mesh.n_vertices)
    a, b, sign, one = turns.real, turns.imag, np.where(reversing, -1.0, 1.0), np.ones(mesh.n_vertices)
    down = np.concatenate([2 * rows, 2 * rows, 2 * rows, 2 * rows + 1, 2 * rows + 1, 2 * rows + 1])
    across = np.concatenate([2 * j, 2 * i, 2 * i + 1, 2 * j + 1, 2 * i, 2 * i + 1])
    values = np.concatenate([one, -a, b * sign, one, -b, -a * sign])
    C = sp.csr_array((values, (down, across)), shape=(2 * len(rows), size))
    return (C.T @ sp.diags_array(np.repeat(mesh.vertex_areas, 2)) @ C).tocsr()


def _smoothest(fields: list[DirectionFields], penalty: sp.csr_array) -> list[Complexes]:
    """The field of least energy on several meshes together, where the mass of each is 1 if there are several."""
    areas = [float(item.mass.sum()) if len(fields) > 1 else 1.0 for item in fields]
    used = np.concatenate([np.bincount(item.mesh.faces.ravel(), minlength=item.mesh.n_vertices) > 0 for item in fields])
    kept = np.repeat(used, 2)
    A = sp.block_diag([_real(item.energy) for item in fields], format="csr") + penalty
    M = sp.block_diag([_real(item.mass / area) for item, area in zip(fields, areas, strict=True)], format="csr")
    x = np.zeros(len(kept))
    x[kept] = smallest_eigenpairs(sp.csr_array(A)[kept][:, kept], sp.csr_array(M)[kept][:, kept], 1).vectors[:, 0]
    u = x[0::2] + 1j * x[1::2]
    return np.split(u, np.cumsum([item.mesh.n_vertices for item in fields])[:-1])


def _real(matrix: sp.csr_array) -> sp.csr_array:
    """The action of a complex matrix on real and imaginary parts, as a real matrix of twice the size."""
    entries = sp.coo_array(matrix)
    i, j, a, b = 2 * entries.row, 2 * entries.col, entries.data.real, entries.data.imag
    down, across = np.concatenate([i, i, i + 1, i + 1]), np.concatenate([j, j + 1, j, j + 1])
    shape = (2 * matrix.shape[0], 2 * matrix.shape[1])
    return sp.csr_array((np.concatenate([a, -b, b, a]), (down, across)), shape=shape)
