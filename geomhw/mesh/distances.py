"""Distance along edges: an upper bound on geodesic distance, and the order in which heat arrives."""

import numpy as np

from geomhw.mesh.arrays import Floats, Ints
from geomhw.mesh.polyhedral import PolyhedralSurface
from geomhw.mesh.topology import counting_order


def edge_path_distance(mesh: PolyhedralSurface, sources: Ints, start: Floats | None = None) -> Floats:
    """Length of the shortest path along edges from the nearest source vertex, (n,); inf where there is none.

    start: (n,), how long paths are already at the sources; by default 0.
    """
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import dijkstra

    n, first = mesh.n_vertices, np.asarray(sources)
    (i, j), lengths = mesh.edges.T, mesh.edge_lengths
    if start is not None and start[first].any():
        # One more vertex, from which all paths start.
        i, j = np.append(i, np.full(len(first), n)), np.append(j, first)
        lengths, first = np.append(lengths, start[first]), np.array([n])
    # Several edges between two vertices stay several entries: the shortest counts.
    order = counting_order(i)
    starts = np.append(0, np.cumsum(np.bincount(i, minlength=n + 1)))
    graph = csr_array((lengths[order], j[order], starts), shape=(n + 1, n + 1))
    distances: Floats = dijkstra(graph, directed=False, indices=first, min_only=True)
    return distances[:n]
