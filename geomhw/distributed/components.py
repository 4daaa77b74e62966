"""Connected components of a distributed mesh."""

import numpy as np

from geomhw.arrays import Ints
from geomhw.distributed.local_mesh import LocalMesh
from geomhw.mesh.topology import vertex_components


def component_labels(mesh: LocalMesh, edges: Ints) -> Ints:
    """Return the lowest vertex of the component of each vertex, (k,), in the order of the curve.

    edges : (e, 2) edges with a vertex of this rank, as rows of ``mesh.vertices``.
    """
    here = vertex_components(edges, len(mesh.vertices))
    labels = mesh.numbers
    while True:
        lowest = np.full(int(here.max(initial=-1)) + 1, mesh.n_vertices)
        np.minimum.at(lowest, here, labels)
        found = lowest[here]
        found[mesh.n_own :] = np.minimum(found[mesh.n_own :], mesh.halo(found[: mesh.n_own]))
        changed = mesh.ranks.sum(int((found != labels).sum()))
        labels = found
        if not changed:
            return labels[: mesh.n_own]
