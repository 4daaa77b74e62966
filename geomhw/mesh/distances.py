"""Distance along edges: an upper bound on geodesic distance, and the order in which heat arrives."""

import numpy as np

from geomhw.mesh.arrays import Floats, Ints
from geomhw.mesh.polyhedral import PolyhedralSurface


def edge_path_distance(mesh: PolyhedralSurface, sources: Ints) -> Floats:
    """Length of the shortest path along edges from the nearest source, (n,); inf where there is none."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import dijkstra

    # Of several edges between the same vertices the shortest counts; a sparse matrix would add them up.
    order = np.lexsort((mesh.edge_lengths, *mesh.edges.T))
    ends = mesh.edges[order]
    shortest = np.any(np.diff(ends, axis=0, prepend=-1), axis=1)
    i, j = ends[shortest].T
    n = mesh.n_vertices
    graph = coo_array((mesh.edge_lengths[order][shortest], (i, j)), shape=(n, n)).tocsr()
    distances: Floats = dijkstra(graph, directed=False, indices=np.asarray(sources), min_only=True)
    return distances
