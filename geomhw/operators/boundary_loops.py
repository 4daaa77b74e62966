"""Functions that are constant on each boundary loop: stream functions of flows that stay inside."""

import numpy as np
import scipy.sparse as sp

from geomhw.arrays import Ints
from geomhw.mesh.triangle_mesh import TriangleMesh


def loop_groups(mesh: TriangleMesh) -> Ints:
    """For each vertex, (n,), the vertex that stands for it: itself inside, one vertex for each boundary loop.

    Loops that touch share a vertex and so become one.
    """
    from scipy.sparse.csgraph import connected_components

    border = mesh.edges[mesh.edge_table.face_counts == 1]
    n = mesh.n_vertices
    links = sp.coo_array((np.ones(len(border)), (border[:, 0], border[:, 1])), shape=(n, n))
    labels = connected_components(links, directed=False)[1]
    first = np.unique(labels, return_index=True)[1]
    return np.asarray(first[labels])


def loop_prolongation(mesh: TriangleMesh) -> tuple[sp.csr_array, Ints]:
    """0/1 matrix E, (n, k), from one unknown an inner vertex and one a boundary loop to vertices; and (k,) vertices
    that stand for the unknowns."""
    stand_in, unknown = np.unique(loop_groups(mesh), return_inverse=True)
    n = mesh.n_vertices
    return sp.csr_array((np.ones(n), (np.arange(n), unknown)), shape=(n, len(stand_in))), stand_in
