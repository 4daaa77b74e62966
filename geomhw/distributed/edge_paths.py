"""Distance along edges from source vertices: Dijkstra's algorithm on each rank, again from ghosts that are nearer."""

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.distributed.assembly import LocalOperators
from geomhw.distributed.local_mesh import LocalMesh
from geomhw.mesh.topology import edge_graph


def edge_path_distance(mesh: LocalMesh, operators: LocalOperators, sources: Ints) -> Floats:
    """Return the length of the shortest path along edges from the nearest source vertex, (k,); inf without one.

    sources : rows of ``mesh.vertices``.
    """
    from scipy.sparse.csgraph import dijkstra

    n, k = len(mesh.vertices), mesh.n_own
    distance = np.full(n, np.inf)
    distance[sources] = 0.0
    changed = sources
    while True:
        if len(changed):
            # All paths start from one more vertex, n.
            starts = np.stack([np.full_like(changed, n), changed], axis=1)
            graph = edge_graph(
                np.concatenate([operators.edges, starts]), np.append(operators.lengths, distance[changed]), n + 1
            )
            found = dijkstra(graph, directed=False, indices=[n], min_only=True)[:n]
            np.minimum(distance, found, out=distance)
        ghosts = mesh.halo(distance[:k])
        changed = k + np.flatnonzero(ghosts < distance[k:])
        distance[k:] = np.minimum(distance[k:], ghosts)
        if not mesh.ranks.sum(len(changed)):
            return distance[:k]
