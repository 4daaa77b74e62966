"""The part of a mesh on one rank: its own vertices, the faces at them, and ghosts, the other corners of these faces."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Floats, Ints
from geomhw.distributed.partition import Partition, partition
from geomhw.distributed.ranks import Ranks, release_memory
from geomhw.distributed.sliced_file import SlicedFile
from geomhw.errors import MeshError
from geomhw.mesh.triangle_mesh import TriangleMesh

#: Faces that are read, or computed on, at a time.
BLOCK = 1 << 18


@dataclass(frozen=True)
class LocalMesh:
    """The part of a mesh of n vertices and m faces on one rank.

    Attributes
    ----------
    ranks : Ranks
    starts : (ranks + 1,) first vertex of each rank in the order of a Hilbert curve, and n.
    in_file : (k,) the number in the file of each of the k vertices of this rank.
    ghosts : (g,) vertices of other ranks at faces of this rank, ascending.
    vertices : (k + g, 3) coordinates of the vertices of this rank, then of the ghosts.
    faces : (f, 3) all faces with a vertex of this rank, as rows of ``vertices``; copies of a face are left out.
    halo : exchange of values at ghosts.
    """

    ranks: Ranks
    part: Partition
    file: SlicedFile
    ghosts: Ints
    vertices: Floats
    faces: Ints
    halo: "Halo"

    @property
    def n_own(self) -> int:
        """Number of vertices of this rank."""
        return len(self.part.vertices)

    @property
    def first(self) -> int:
        """The first vertex of this rank."""
        return int(self.part.starts[self.ranks.rank])

    @property
    def n_vertices(self) -> int:
        """Number of vertices of the whole mesh."""
        return int(self.part.starts[-1])

    @property
    def numbers(self) -> Ints:
        """Vertices of this rank and ghosts as vertices of the whole mesh, (k + g,)."""
        return np.concatenate([self.first + np.arange(self.n_own), self.ghosts])

    def numbers_of(self, local: Ints) -> Ints:
        """Return vertices of the whole mesh, from rows of ``vertices``."""
        numbers = self.first + local.astype(np.int64)
        outside = local >= self.n_own
        numbers[outside] = self.ghosts[local[outside] - self.n_own]
        return numbers

    def with_ghosts(self, values: NDArray[Any]) -> NDArray[Any]:
        """Append the values at ghosts to those at the vertices of this rank."""
        return np.concatenate([values, self.halo(values)])

    def blocks(self) -> Iterator[tuple[Ints, TriangleMesh]]:
        """Yield the faces block by block, each as a mesh with the rows of ``vertices`` that are its vertices."""
        for begin in range(0, len(self.faces), BLOCK):
            used, corners = np.unique(self.faces[begin : begin + BLOCK], return_inverse=True)
            yield used, TriangleMesh(self.vertices[used], corners.reshape(-1, 3))

    def find(self, in_file: Ints) -> Ints:
        """Return the numbers of vertices of the file, (k,); every rank asks for the same ones."""
        begin, end = self.part.file_starts[self.ranks.rank : self.ranks.rank + 2]
        here = (in_file >= begin) & (in_file < end)
        found = np.zeros(len(in_file), dtype=np.int64)
        found[here] = self.part.numbers[in_file[here] - begin]
        return np.asarray(self.ranks.sum(found))

    def local(self, numbers: Ints) -> Ints:
        """Return those of some vertices of the mesh that are here, as rows of ``vertices``, own and ghosts."""
        own = numbers[(numbers >= self.first) & (numbers < self.first + self.n_own)] - self.first
        return np.concatenate([own, self.n_own + np.flatnonzero(np.isin(self.ghosts, numbers))])


class Halo:
    """Exchange of values between the vertices of a rank and the ghosts of others."""

    def __init__(self, ranks: Ranks, starts: Ints, ghosts: Ints) -> None:
        self._ranks = ranks
        self.received = np.diff(np.searchsorted(ghosts, starts))
        wanted, self.sent = ranks.exchange(ghosts, self.received)
        #: Vertices of this rank that are ghosts of others, once for each rank that has them.
        self.places = wanted - starts[ranks.rank]

    def __call__(self, values: NDArray[Any]) -> NDArray[Any]:
        """Return the values at the ghosts of this rank from those at its vertices."""
        return self._ranks.send(values[self.places], self.sent, self.received)


def distribute(ranks: Ranks, file: SlicedFile) -> LocalMesh:
    """Read a mesh in slices and return the part of each rank; no rank holds more than its share and the ghosts of it.

    Raises
    ------
    FormatError
        If the file is damaged.
    MeshError
        If a coordinate is not finite, an index is out of range, or a face repeats a vertex.
    """
    part = partition(ranks, file)
    release_memory()
    faces = _without_copies(_faces(ranks, file, part))
    release_memory()
    first, end = part.starts[ranks.rank : ranks.rank + 2]
    others = faces[(faces < first) | (faces >= end)]
    ghosts = np.unique(others)
    halo = Halo(ranks, part.starts, ghosts)
    vertices = np.concatenate([part.vertices, halo(part.vertices)])
    is_ghost = (faces < first) | (faces >= end)
    faces = (faces - first).astype(np.int32, copy=False)
    faces[is_ghost] = len(part.vertices) + np.searchsorted(ghosts, others)
    del others, is_ghost
    release_memory()
    return LocalMesh(ranks, part, file, ghosts, vertices, faces, halo)


def _faces(ranks: Ranks, file: SlicedFile, part: Partition) -> Ints:
    """Return all faces, (f, 3), with a vertex of this rank, as vertices in the order of the curve."""
    shares = ranks.shares(file.n_faces)
    begin, end = (int(share) for share in shares[ranks.rank : ranks.rank + 2])
    found = []
    for k in range(int(-(-np.diff(shares).max() // BLOCK))):
        with ranks.agreeing():
            here = begin + k * BLOCK
            corners = file.read_faces(min(here, end), min(here + BLOCK, end))
            _check(corners, here, file.n_vertices)
        used, inverse = np.unique(corners, return_inverse=True)
        counts = np.diff(np.searchsorted(used, part.file_starts))
        asked, received = ranks.exchange(used, counts)
        numbers = ranks.send(part.numbers[asked - part.file_starts[ranks.rank]], received, counts)
        corners = numbers[inverse].reshape(-1, 3)
        found.append(_sent_to_owners(ranks, part.starts, corners))
    return np.concatenate([np.empty((0, 3), dtype=np.int64), *found])


def _sent_to_owners(ranks: Ranks, starts: Ints, corners: Ints) -> Ints:
    """Send each face to the ranks of its corners, and return the received ones."""
    owners = np.sort(np.searchsorted(starts, corners, side="right") - 1, axis=1)
    new = np.ones(owners.shape, dtype=bool)
    new[:, 1:] = owners[:, 1:] != owners[:, :-1]
    face, column = np.nonzero(new)
    owner = owners[face, column]
    order = np.argsort(owner, kind="stable")
    return ranks.exchange(corners[face[order]], np.bincount(owner, minlength=ranks.size))[0]


def _check(corners: Ints, first: int, n: int) -> None:
    """Raise MeshError for a face that has a vertex which does not exist, or one twice."""
    if (outside := ((corners < 0) | (corners >= n)).any(axis=1)).any():
        bad = int(np.argmax(outside))
        raise MeshError(f"face {first + bad} has a vertex that does not exist: {corners[bad].tolist()}, of {n}")
    if (twice := (corners == np.roll(corners, 1, axis=1)).any(axis=1)).any():
        bad = int(np.argmax(twice))
        raise MeshError(f"face {first + bad} has the same vertex twice: {corners[bad].tolist()}")


def _without_copies(faces: Ints) -> Ints:
    """Sort faces by their lowest vertices, so that neighbors are close in memory, and leave out copies of others."""
    keys = np.sort(faces, axis=1)
    order = np.lexsort(keys.T[::-1])
    keys = keys[order]
    order = order[np.append(True, (keys[1:] != keys[:-1]).any(axis=1))[: len(order)]]
    del keys
    return faces[order]
