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
    columns = mesh.numbers[matrix.indices]
    lengths, rows = np.diff(matrix.indptr), [first + np.repeat(np.arange(k), np.diff(matrix.indptr))]
    all_columns, all_data, fetched, layer = [columns], [matrix.data], [np.empty(0, dtype=np.int64)], mesh.ghosts
    for _ in range(layers):
        halo = Halo(ranks, starts, layer)
        found = halo(lengths)
        entries = _entries(matrix.indptr, halo.places)
        sent, received = _totals(lengths[halo.places], halo.sent), _totals(found, halo.received)
        all_columns.append(ranks.send(columns[entries], sent, received))
        all_data.append(ranks.send(matrix.data[entries], sent, received))
        rows.append(np.repeat(layer, found))
        fetched.append(layer)
        known = np.concatenate(fetched)
        new = np.unique(all_columns[-1])
        layer = np.setdiff1d(new[(new < first) | (new >= first + k)], known)
    ghosts = np.sort(np.concatenate([*fetched, layer]))
    places = [_local(np.concatenate(numbers), first, k, ghosts) for numbers in (rows, all_columns)]
    n = k + len(ghosts)
    whole = sp.coo_array((np.concatenate(all_data), tuple(places)), shape=(n, n)).tocsr()
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
