"""Partition of vertices along a Hilbert curve: a new numbering in which each rank has a contiguous range."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Floats, Ints, pieces
from geomhw.distributed.ranks import Ranks
from geomhw.distributed.sliced_file import SlicedFile
from geomhw.errors import MeshError
from geomhw.mesh.hilbert_curve import BITS, hilbert_keys


@dataclass(frozen=True)
class Partition:
    """The vertices of each rank, and the map between their numbers and those of the file.

    Attributes
    ----------
    starts : (ranks + 1,) first number of each rank, in the order of the curve, and n.
    vertices : (k, 3) coordinates of the vertices of this rank.
    in_file : (k,) their numbers in the file.
    file_starts : (ranks + 1,) first vertex of the file that each rank has read, and n.
    numbers : number of each vertex that this rank has read.
    """

    starts: Ints
    vertices: Floats
    in_file: Ints
    file_starts: Ints
    numbers: Ints


def partition(ranks: Ranks, file: SlicedFile) -> Partition:
    """Read the vertices of a file in slices and distribute them along a Hilbert curve, in equal numbers up to ties."""
    shares = ranks.shares(file.n_vertices)
    begin, end = shares[ranks.rank : ranks.rank + 2]
    with ranks.agreeing():
        points = file.read_vertices(int(begin), int(end))
        if not np.isfinite(points).all():
            bad = int(begin) + int(np.argmax(~np.isfinite(points).all(axis=1)))
            raise MeshError(f"vertex {bad} has a coordinate that is not finite")
    low = ranks.comm.allreduce(points.min(axis=0, initial=np.inf), op=_minimum)
    high = ranks.comm.allreduce(points.max(axis=0, initial=-np.inf), op=_maximum)
    keys, size = np.empty(len(points), dtype=np.uint64), float((high - low).max())
    for piece in pieces(len(points)):
        keys[piece] = hilbert_keys(points[piece], low=low, size=size)
    order = np.argsort(keys, kind="stable")
    counts = np.diff(np.searchsorted(keys[order], _splitters(ranks, keys[order])), prepend=0, append=len(keys))
    found, received = ranks.exchange(keys[order], counts)
    sent = np.argsort(found, kind="stable")  # equal keys stay in the order of the file
    vertices = ranks.send(points[order], counts, received)[sent]
    in_file = ranks.send(begin + order, counts, received)[sent]
    starts = ranks.starts(len(vertices))
    # In 32 bits if all vertices fit: half of the memory.
    kind = np.int32 if file.n_vertices < 2**31 else np.int64
    replies = np.empty(len(sent), dtype=kind)
    replies[sent] = starts[ranks.rank] + np.arange(len(sent))
    numbers = np.empty(len(order), dtype=kind)
    numbers[order] = ranks.send(replies, received, counts)
    return Partition(starts, vertices, in_file, shares, numbers)


def _splitters(ranks: Ranks, keys: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """Keys, (ranks - 1,), below which each rank's share of all keys lies; keys of this rank ascend."""
    targets = ranks.shares(ranks.sum(len(keys)))[1:-1]
    low = np.zeros(len(targets), dtype=np.uint64)
    high = np.full(len(targets), 1 << (3 * BITS), dtype=np.uint64)
    for _ in range(3 * BITS + 1):
        middle = low + (high - low) // np.uint64(2)
        enough = ranks.sum(np.searchsorted(keys, middle).astype(np.int64)) >= targets
        high, low = np.where(enough, middle, high), np.where(enough, low, middle)
    return high


def _minimum(one: Floats, other: Floats) -> Floats:
    return np.minimum(one, other)


def _maximum(one: Floats, other: Floats) -> Floats:
    return np.maximum(one, other)
