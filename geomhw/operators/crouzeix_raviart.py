"""Crouzeix-Raviart elements: functions linear on faces and continuous at edge midpoints, one value per edge.

The basis function of the edge opposite corner k of a face is 1 - 2 φ_k there, for the hat function φ_k. Gradients of
functions at vertices and quarter turns of gradients of Crouzeix-Raviart functions are orthogonal, and span all face
fields up to 2g harmonic ones [Polthier, Preuss 2003; Wardetzky 2006].

Polthier, Preuss: Identifying Vector Field Singularities Using a Discrete Hodge Decomposition. Vis. and Math. III, 2003.
Wardetzky: Discrete Differential Operators on Polyhedral Surfaces. PhD thesis, FU Berlin, 2006.
"""

import numpy as np
import scipy.sparse as sp

from geomhw.arrays import Floats, Ints
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.gradient import hat_gradients


def crouzeix_raviart_gradient(mesh: TriangleMesh) -> sp.csr_array:
    """Assemble the gradient of Crouzeix-Raviart functions.

    Returns
    -------
    (3m, e) sparse array, units 1/length, strong. Row 3f+k is component k, in world axes, on face f; columns are edges
    in the order of ``mesh.edges``.

    Raises
    ------
    MeshError
        If a face has zero area.

    References
    ----------
    Polthier, Preuss: Identifying Vector Field Singularities Using a Discrete Hodge Decomposition, 2003.

    Examples
    --------
    >>> from geomhw.mesh import grid
    >>> mesh = grid(4, 4)
    >>> midpoints = mesh.vertices[mesh.edges].mean(axis=1)
    >>> (crouzeix_raviart_gradient(mesh) @ midpoints[:, 0]).reshape(-1, 3)[0].round(12) + 0.0
    array([1., 0., 0.])
    """
    m = mesh.n_faces
    values = -2 * hat_gradients(mesh).transpose(0, 2, 1)
    columns = np.broadcast_to(mesh.edge_table.of_faces[:, None, :], (m, 3, 3))
    starts = np.arange(0, 9 * m + 1, 3)
    return sp.csr_array((values.ravel(), columns.ravel(), starts), shape=(3 * m, mesh.n_edges))


def edge_components(mesh: TriangleMesh) -> Ints:
    """Return a label of each edge, (e,): that of its component, where edges of one face are connected."""
    from scipy.sparse.csgraph import connected_components

    table = mesh.edge_table.of_faces
    pairs = np.concatenate([table[:, :2], table[:, 1:]])
    links = sp.coo_array((np.ones(len(pairs), dtype=np.int8), (pairs[:, 0], pairs[:, 1])), shape=(mesh.n_edges,) * 2)
    return np.asarray(connected_components(links, directed=False)[1])


def boundary_loop_edges(mesh: TriangleMesh) -> list[Ints]:
    """Return the edges of each boundary loop, as indices into ``mesh.edges``."""
    return [mesh.edge_table.between(np.stack([loop, np.roll(loop, -1)], axis=1)) for loop in mesh.boundary_loops]


def edges_to_vertices(mesh: TriangleMesh, values: Floats) -> Floats:
    """Return the mean of edge values, (e,), over the edges at each vertex, (n,); zero at a vertex without edges."""
    ends = mesh.edges.ravel()
    counts = np.bincount(ends, minlength=mesh.n_vertices)
    sums = np.bincount(ends, weights=np.repeat(values, 2), minlength=mesh.n_vertices)
    return np.asarray(sums / np.maximum(counts, 1))
