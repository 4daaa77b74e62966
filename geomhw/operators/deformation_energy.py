"""The deformation energy of tangent fields at vertices: the squared strain of faces whose corners move along them."""

import numpy as np
import scipy.sparse as sp

from geomhw.arrays import Complexes
from geomhw.mesh.geometry import unit
from geomhw.mesh.polyhedral import PolyhedralSurface
from geomhw.mesh.tangent_frames import face_frames

#: Turn of a boundary, in radians, from which a vertex is a corner, where a tangent field vanishes.
CORNER = np.radians(75)


def deformation_energy(surface: PolyhedralSurface, ends: Complexes) -> sp.csr_array:
    """Assemble the deformation energy ∫ |½(∇V + ∇Vᵀ)|² of tangent fields at vertices.

    The flow of V changes the length of the edge from i to j at the rate V_j·t_j - V_i·t_i, for the directions t of the
    edge at its ends, since the first variation of a geodesic depends on its ends alone. The three rates determine the
    strain of a face. Isometric flows change no length, so that their energy is small of high order.

    Parameters
    ----------
    surface : faces without area are an error.
    ends : (e, 2) array, directions of the edges at their ends, of `edge_ends`.

    Returns
    -------
    (2n, 2n) sparse array, dimensionless, weak, symmetric, positive semidefinite. Rows 2i and 2i+1 are the real and the
    imaginary part at vertex i.

    Raises
    ------
    MeshError
        If a face has zero area.

    Examples
    --------
    A rotation of the sphere has no deformation.

    >>> from geomhw.mesh import icosphere
    >>> from geomhw.operators import edge_ends, to_complex
    >>> mesh = icosphere(1)
    >>> z = to_complex(mesh, np.cross([0, 0, 1.0], mesh.vertices))
    >>> V = np.stack([z.real, z.imag], axis=1).ravel()
    >>> float(V @ deformation_energy(mesh, edge_ends(mesh, "normals")) @ V) < 1e-12
    True
    """
    surface.require_area()
    frames = face_frames(surface.opposite_edges, surface.face_normals)
    x, y = np.einsum("fkx,fax->afk", unit(surface.opposite_edges.reshape(-1, 3)).reshape(-1, 3, 3), frames)
    # Orthonormal coordinates of symmetric matrices: the entries, the one off the diagonal times √2.
    rates_of_strain = np.stack([x * x, np.sqrt(2) * x * y, y * y], axis=2)
    strain = np.linalg.inv(rates_of_strain) * np.sqrt(surface.face_areas)[:, None, None]
    m, table = surface.n_faces, surface.edge_table.of_faces
    starts = np.arange(0, 9 * m + 1, 3)
    B = sp.csr_array((strain.ravel(), np.repeat(table, 3, axis=0).ravel(), starts), shape=(3 * m, surface.n_edges))
    B = B @ _rates(surface, ends)
    return (B.T @ B).tocsr()


def field_unknowns(surface: PolyhedralSurface, ends: Complexes, tangent: bool = True) -> sp.csr_array:
    """Assemble a basis of the tangent fields at vertices with faces.

    By default they do not cross the boundary: at a boundary vertex they are along the circle through it
    and its two neighbors. They vanish at corners.

    Returns
    -------
    (2n, r) sparse array with orthonormal columns, from unknowns to real and imaginary parts.
    """
    n = surface.n_vertices
    inner = np.ones(n, dtype=bool)
    inner[surface.unreferenced_vertices] = False
    along = np.zeros(n, dtype=complex)
    if tangent:
        inner[surface.boundary_vertices] = False
        along = _boundary_tangents(surface, ends)
    both, one = np.flatnonzero(inner), np.flatnonzero(along)
    rows = np.concatenate([2 * both, 2 * both + 1, 2 * one, 2 * one + 1])
    last = 2 * len(both) + np.arange(len(one))
    columns = np.concatenate([np.arange(2 * len(both)), last, last])
    values = np.concatenate([np.ones(2 * len(both)), along[one].real, along[one].imag])
    return sp.csr_array((values, (rows, columns)), shape=(2 * n, 2 * len(both) + len(one)))


def _rates(surface: PolyhedralSurface, ends: Complexes) -> sp.csr_array:
    """Relative rates at which a field changes the lengths of edges, (e, 2n), 1/length."""
    i, j = surface.edges.T
    t = -ends / surface.edge_lengths[:, None]
    values = np.stack([t[:, 0].real, t[:, 0].imag, t[:, 1].real, t[:, 1].imag], axis=1)
    columns = np.stack([2 * i, 2 * i + 1, 2 * j, 2 * j + 1], axis=1)
    starts = np.arange(0, 4 * len(i) + 1, 4)
    return sp.csr_array((values.ravel(), columns.ravel(), starts), shape=(len(i), 2 * surface.n_vertices))


def boundary_directions(surface: PolyhedralSurface, ends: Complexes) -> tuple[Complexes, Complexes]:
    """Return the directions of boundary edges to the next and to the previous vertex, (n,) each, over their lengths.

    They are zero at other vertices. ``ends`` is that of `edge_ends`.
    """
    table = surface.edge_table
    outer = table.face_counts[table.of_faces] == 1
    edge = table.of_faces[outer]
    start, end = np.roll(surface.faces, -1, axis=1)[outer], np.roll(surface.faces, -2, axis=1)[outer]
    upward = (start < end).astype(int)
    ahead, behind = np.zeros((2, surface.n_vertices), dtype=complex)
    ahead[start] = ends[edge, 1 - upward] / surface.edge_lengths[edge]
    behind[end] = ends[edge, upward] / surface.edge_lengths[edge]
    return ahead, behind


def _boundary_tangents(surface: PolyhedralSurface, ends: Complexes) -> Complexes:
    """Unit tangents of the boundary, (n,); zero at corners and elsewhere."""
    ahead, behind = boundary_directions(surface, ends)
    smooth = (ahead != 0) & (behind != 0) & (np.abs(np.angle(-ahead * np.conj(behind))) <= CORNER)
    circle = np.where(smooth, ahead - behind, 0)
    return np.asarray(circle / np.where(smooth, np.abs(circle), 1.0))
