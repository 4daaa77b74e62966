"""Exchange of values at the corners of faces that several ranks have."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Ints
from geomhw.distributed.local_mesh import LocalMesh
from geomhw.distributed.ranks import Ranks


class SharedFaces:
    """Faces with vertices of several ranks, which have these faces in the same order.

    Parameters
    ----------
    mesh : the part of each rank.
    faces : (q, 3) rows of ``mesh.vertices``: faces of the mesh in their order, some perhaps left out or repeated, on
        all ranks alike.
    """

    def __init__(self, mesh: LocalMesh, faces: Ints) -> None:
        self._ranks: Ranks = mesh.ranks
        size, me = mesh.ranks.size, mesh.ranks.rank
        #: Whether this is the first rank of a face, (q,), and a corner that is a vertex of that rank.
        self.first, self.first_corner = np.ones(len(faces), dtype=bool), np.zeros(len(faces), dtype=np.int64)
        shared = np.flatnonzero((faces >= mesh.n_own).any(axis=1))
        owners = np.searchsorted(mesh.part.starts, mesh.numbers_of(faces[shared]), side="right") - 1
        self.first[shared], self.first_corner[shared] = owners.min(axis=1) == me, owners.argmin(axis=1)
        others = np.sort(owners, axis=1)
        new = others != me
        new[:, 1:] &= others[:, 1:] != others[:, :-1]
        face, column = np.nonzero(new)
        to = others[face, column]
        pair, column = np.nonzero(owners[face] == me)
        self._places = _grouped(3 * shared[face[pair]] + column, to[pair])
        self._sent = np.bincount(to[pair], minlength=size)
        face, column = np.nonzero(owners != me)
        self._into = _grouped(3 * shared[face] + column, owners[face, column])
        self._received = np.bincount(owners[face, column], minlength=size)

    def __call__(self, values: NDArray[Any]) -> NDArray[Any]:
        """Return values at corners, (q, 3), where those at corners that are ghosts come from the ranks of these."""
        found = values.ravel().copy()
        found[self._into] = self._ranks.send(found[self._places], self._sent, self._received)
        return found.reshape(-1, 3)


def _grouped(values: Ints, ranks: Ints) -> Ints:
    """Sort values by rank, otherwise in their order."""
    return values[np.argsort(ranks, kind="stable")]
