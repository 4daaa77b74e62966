"""Rows of a distributed matrix for some layers of vertices around those of a rank: overlapping subdomains."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from geomhw.arrays import Ints
from geomhw.distributed.local_mesh import Halo, LocalMesh


@dataclass(frozen=True)
class OverlappingRows:
    """A matrix in the rows of a rank's k vertices and of layers around them.

    Attributes
    ----------
    matrix : (k + g, k + g) sparse array; rows of the outermost ghosts are empty.
    overlap : (g,) mask of the ghosts that have rows.
    halo : exchange of values at these ghosts.
    """

    matrix: sp.csr_array
    overlap: Ints
    halo: Halo


def overlapping_rows(mesh: LocalMesh, matrix: sp.csr_array, layers: int) -> OverlappingRows:
    """Fetch the rows of ``layers`` layers of vertices around those of a rank, for the rows of each rank, (k, k + g)."""
    ranks, starts, first, k = mesh.ranks, mesh.part.starts, mesh.first, mesh.n_own
    lengths, layer, fetched = np.diff(matrix.indptr), mesh.ghosts, [np.empty(0, dtype=np.int64)]
    rows, columns, data = [], [], []
    for _ in range(layers):
        halo = Halo(ranks, starts, layer)
        found, entries = halo(lengths), _entries(matrix.indptr, halo.places)
        sent, received = _totals(lengths[halo.places], halo.sent), _totals(found, halo.received)
        columns.append(ranks.send(mesh.numbers_of(matrix.indices[entries]), sent, received))
        data.append(ranks.send(matrix.data[entries], sent, received))
        rows.append(np.repeat(layer, found))
        fetched.append(layer)
        new = np.unique(columns[-1])
        layer = np.setdiff1d(new[(new < first) | (new >= first + k)], np.concatenate(fetched))
    ghosts = np.sort(np.concatenate([*fetched, layer]))
    n = k + len(ghosts)
    places = [_local(np.concatenate(numbers), first, k, ghosts) for numbers in (rows, columns)]
    further = sp.coo_array((np.concatenate(data), (places[0] - k, places[1])), shape=(n - k, n)).tocsr()
    own = matrix.indices.copy()
    own[own >= k] = k + np.searchsorted(ghosts, mesh.ghosts)[own[own >= k] - k]
    parts = (matrix.data, further.data), (own, further.indices), (matrix.indptr, further.indptr[1:] + matrix.indptr[-1])
    whole = sp.csr_array(tuple(map(np.concatenate, parts)), shape=(n, n))
    return OverlappingRows(whole, ~np.isin(ghosts, layer), Halo(ranks, starts, ghosts))


def _entries(indptr: Ints, rows: Ints) -> Ints:
    """Positions of the entries of some rows, row by row."""
    counts = np.diff(indptr)[rows]
    return np.repeat(indptr[rows] - np.cumsum(counts) + counts, counts) + np.arange(counts.sum())


def _totals(lengths: Ints, counts: Ints) -> Ints:
    """Sum of the lengths in each group of rows."""
    return np.diff(np.concatenate([[0], np.cumsum(lengths)])[np.concatenate([[0], np.cumsum(counts)])])


def _local(numbers: Ints, first: int, k: int, ghosts: Ints) -> Ints:
    """Vertices of the mesh as rows: those of the rank, then ghosts."""
    own = (numbers >= first) & (numbers < first + k)
    return np.where(own, numbers - first, k + np.searchsorted(ghosts, numbers)).astype(np.int32)
