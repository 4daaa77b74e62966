"""Distance along edges (Dijkstra): an upper bound on geodesic distance, and the order in which heat arrives."""

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.mesh.polyhedral import PolyhedralSurface
from geomhw.mesh.topology import edge_graph


def edge_path_distance(mesh: PolyhedralSurface, sources: Ints, start: Floats | None = None) -> Floats:
    """Return the length of the shortest path along edges from the nearest source vertex.

    Parameters
    ----------
    sources : (k,) array of vertices.
    start : (n,) array, of which the values at the sources are added to the paths from there; by default 0.

    Returns
    -------
    (n,) array; inf on components without a source.

    Examples
    --------
    >>> from geomhw.mesh import grid
    >>> edge_path_distance(grid(2, 2), np.array([0])).round(3).tolist()
    [0.0, 0.5, 1.0, 0.5, 0.707, 1.207, 1.0, 1.207, 1.414]
    """
    return paths_along_edges(mesh.edges, mesh.edge_lengths, mesh.n_vertices, np.asarray(sources), start)


def paths_along_edges(edges: Ints, lengths: Floats, n: int, sources: Ints, start: Floats | None = None) -> Floats:
    """Return what `edge_path_distance` does for edges, (e, 2), of given lengths, (e,), between n vertices."""
    from scipy.sparse.csgraph import dijkstra

    first = sources
    if start is not None and start[first].any():
        # All paths start from one more vertex, n.
        edges = np.concatenate([edges, np.stack([np.full_like(first, n), first], axis=1)])
        lengths, first = np.append(lengths, start[first]), np.array([n])
    distances: Floats = dijkstra(edge_graph(edges, lengths, n + 1), directed=False, indices=first, min_only=True)
    return distances[:n]
