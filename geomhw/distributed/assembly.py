"""Edges, lumped mass and cotan stiffness on the part of a mesh that a rank has, by blocks of faces."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from geomhw.arrays import Floats, Ints
from geomhw.distributed.local_mesh import LocalMesh
from geomhw.mesh.geometry import distances
from geomhw.operators.edge_matrix import edge_matrix, weight_sums


@dataclass(frozen=True)
class LocalOperators:
    """Operators in the rows of a rank's k vertices, with columns for its vertices and ghosts.

    Attributes
    ----------
    edges : (e, 2) edges with a vertex of this rank, as rows of ``LocalMesh.vertices``; lengths : (e,).
    areas : (k,) barycentric vertex areas.
    stiffness : (k, k + g) sparse array.
    mean_edge_length : of the whole mesh.
    weights : the least cotan weight of an edge of the whole mesh, and the largest absolute value.
    """

    edges: Ints
    lengths: Floats
    areas: Floats
    stiffness: sp.csr_array
    mean_edge_length: float
    weights: tuple[float, float]


def assemble(mesh: LocalMesh) -> LocalOperators:
    """Assemble the operators of a rank.

    Raises
    ------
    MeshError
        If a face has zero area.
    """
    n, k = len(mesh.vertices), mesh.n_own
    areas, edges, weights = np.zeros(n), [np.empty((0, 2), dtype=np.int32)], [np.empty(0)]
    with mesh.ranks.agreeing():
        for used, block in mesh.blocks():
            areas[used] += block.vertex_areas
            ends = used[block.edges]
            here = (ends < k).any(axis=1)
            edges.append(ends[here].astype(np.int32))
            weights.append(block.edge_cotan_weights[here])
    pairs, cotan = _summed(np.concatenate(edges), np.concatenate(weights), n)
    lengths = distances(mesh.vertices, pairs)
    S = edge_matrix(pairs, -cotan, weight_sums(pairs, cotan, n))[:k]
    ours = counted_here(mesh, pairs)
    least = mesh.ranks.min(float(cotan[ours].min(initial=np.inf)))
    largest = mesh.ranks.max(float(np.abs(cotan[ours]).max(initial=0.0)))
    return LocalOperators(pairs, lengths, areas[:k], S, mean_length(mesh, lengths[ours]), (least, largest))


def counted_here(mesh: LocalMesh, edges: Ints) -> NDArray[np.bool_]:
    """Whether edges with a vertex of this rank, (e, 2), have their first vertex in the order of the curve here."""
    ours: NDArray[np.bool_] = np.asarray((edges < mesh.n_own).all(axis=1))
    ours[~ours] = mesh.ghosts[edges[~ours].max(axis=1) - mesh.n_own] >= mesh.first
    return ours


def mean_length(mesh: LocalMesh, lengths: Floats) -> float:
    """Return the mean length of the edges of the whole mesh; lengths : (e,) of those of `counted_here`."""
    total, count = mesh.ranks.sum(np.array([lengths.sum(), len(lengths)]))
    return float(total / count)


def _summed(edges: Ints, weights: Floats, n: int) -> tuple[Ints, Floats]:
    """Return each edge, (e, 2), the lower end first, once, with the sum of its weights."""
    table = sp.coo_array((weights, (edges[:, 0], edges[:, 1])), shape=(n, n)).tocsr()
    return np.stack([np.repeat(np.arange(n, dtype=np.int32), np.diff(table.indptr)), table.indices], axis=1), table.data
