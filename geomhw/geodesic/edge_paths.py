"""Distance along edges: an upper bound on geodesic distance, and the order in which heat arrives."""

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.mesh.polyhedral import PolyhedralSurface
from geomhw.mesh.topology import edge_graph


def edge_path_distance(mesh: PolyhedralSurface, sources: Ints, start: Floats | None = None) -> Floats:
    """Length of the shortest path along edges from the nearest source vertex, (n,); inf where there is none.

    start: (n,), how long paths are already at the sources; by default 0.
    """
    from scipy.sparse.csgraph import dijkstra

    n, first = mesh.n_vertices, np.asarray(sources)
    edges, lengths = mesh.edges, mesh.edge_lengths
    if start is not None and start[first].any():
        # One more vertex, from which all paths start.
        edges = np.concatenate([edges, np.stack([np.full_like(first, n), first], axis=1)])
        lengths, first = np.append(lengths, start[first]), np.array([n])
    distances: Floats = dijkstra(edge_graph(edges, lengths, n + 1), directed=False, indices=first, min_only=True)
    return distances[:n]
