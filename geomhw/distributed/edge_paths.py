"""Distance along edges from sources: Dijkstra's algorithm on each rank, again from ghosts that are nearer."""

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.distributed.assembly import LocalOperators
from geomhw.distributed.local_mesh import LocalMesh
from geomhw.geodesic.edge_paths import paths_along_edges


def edge_path_distance(
    mesh: LocalMesh, operators: LocalOperators, sources: Ints, start: Floats | float = 0.0
) -> Floats:
    """Return the length of the shortest path along edges from the sources, (k,); inf without one.

    sources : rows of ``mesh.vertices``, own and ghosts. start : the distances there.
    """
    n, k = len(mesh.vertices), mesh.n_own
    distance, changed = np.full(n, np.inf), sources
    distance[sources] = start
    while True:
        if len(changed):
            found = paths_along_edges(operators.edges, operators.lengths, n, changed, distance)
            np.minimum(distance, found, out=distance)
        ghosts = mesh.halo(distance[:k])
        changed = k + np.flatnonzero(ghosts < distance[k:])
        distance[k:] = np.minimum(distance[k:], ghosts)
        if not mesh.ranks.sum(len(changed)):
            return distance[:k]
