"""Distance along edges: an upper bound on geodesic distance, and the order in which heat arrives."""

import numpy as np

from geomhw.mesh.arrays import Floats, Ints
from geomhw.mesh.triangle_mesh import TriangleMesh


def edge_path_distance(mesh: TriangleMesh, sources: Ints) -> Floats:
    """Length of the shortest path along edges from the nearest source, (n,); inf where there is none."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import dijkstra

    i, j = mesh.edges.T
    n = mesh.n_vertices
    graph = coo_array((mesh.edge_lengths, (i, j)), shape=(n, n)).tocsr()
    distances: Floats = dijkstra(graph, directed=False, indices=np.asarray(sources), min_only=True)
    return distances
