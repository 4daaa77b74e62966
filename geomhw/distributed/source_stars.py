"""The faces round source points as a small mesh that every rank has, in the order of the file."""

from dataclasses import dataclass

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.distributed.local_mesh import BLOCK, LocalMesh
from geomhw.mesh.surface_points import SurfacePoints
from geomhw.mesh.triangle_mesh import TriangleMesh


@dataclass(frozen=True)
class SourceStars:
    """All faces with a corner of the faces, or at the vertices, that contain some points.

    Attributes
    ----------
    mesh : the faces in the order of the file, with their vertices, ascending in the file.
    vertices, faces : their numbers in the file.
    """

    mesh: TriangleMesh
    vertices: Ints
    faces: Ints

    def points(self, sources: SurfacePoints) -> SurfacePoints:
        """Return points on the mesh of the file as points on this one."""
        faces = np.where(sources.faces < 0, -1, np.searchsorted(self.faces, sources.faces))
        return SurfacePoints(faces, np.searchsorted(self.vertices, sources.corners), sources.weights, sources.filled)

    def own_rows(self, mesh: LocalMesh) -> tuple[Ints, Ints]:
        """Return the rows of a rank's vertices that are here, and their places among ``vertices``."""
        rows = mesh.find(self.vertices) - mesh.first
        here = np.flatnonzero((rows >= 0) & (rows < mesh.n_own))
        return rows[here], here

    def fan_rows(self, mesh: LocalMesh, base: TriangleMesh) -> tuple[Ints, Ints]:
        """Return the rows of a rank's vertices that are here, and their places on the mesh cut into sheets.

        mesh : an orientation cover. base : as `cut_into_sheets` returns it.
        """
        faces, star = self.common_faces(mesh)
        own, column = np.nonzero(mesh.faces[faces] < mesh.n_own)
        rows = mesh.faces[faces[own], column]
        corners = self.vertices[self.mesh.faces[star[own]]]
        at = (corners == mesh.part.in_file[rows][:, None]).argmax(axis=1)
        return rows, base.faces[star[own], at]

    def common_faces(self, mesh: LocalMesh) -> tuple[Ints, Ints]:
        """Return the faces of a rank that are here, and their places here; of copies of a face the first place."""
        count, in_file = len(self.vertices), mesh.with_ghosts(mesh.part.in_file)
        faces = np.flatnonzero(np.isin(in_file, self.vertices)[mesh.faces].all(axis=1))
        keys, known = (
            (corners[:, 0] * count + corners[:, 1]) * count + corners[:, 2]
            for corners in (
                np.sort(places.astype(np.int64), axis=1)
                for places in (np.searchsorted(self.vertices, in_file[mesh.faces[faces]]), self.mesh.faces)
            )
        )
        known, first = np.unique(known, return_index=True)
        found = np.isin(keys, known)
        return faces[found], first[np.searchsorted(known, keys[found])]


def source_stars(mesh: LocalMesh, vertices: Ints) -> SourceStars:
    """Return the faces at some vertices of the file, the same on all ranks; each rank scans its slice of the file."""
    ranks, file = mesh.ranks, mesh.file
    begin, end = (int(share) for share in ranks.shares(file.n_faces)[ranks.rank : ranks.rank + 2])
    found, numbers = [np.empty((0, 3), dtype=np.int64)], [np.empty(0, dtype=np.int64)]
    with ranks.agreeing():
        for start in range(begin, end, BLOCK):
            corners = file.read_faces(start, min(start + BLOCK, end))
            here = np.flatnonzero(np.isin(corners, vertices).any(axis=1))
            found.append(corners[here])
            numbers.append(start + here)
    corners, faces = (np.concatenate(ranks.comm.allgather(np.concatenate(part))) for part in (found, numbers))
    used = np.unique(corners)
    return SourceStars(TriangleMesh(positions(mesh, used), np.searchsorted(used, corners)), used, faces)


def positions(mesh: LocalMesh, vertices: Ints) -> Floats:
    """Return the coordinates of vertices of the file, (v, 3), on all ranks."""
    numbers = mesh.find(vertices)
    found = np.zeros((len(vertices), 3))
    here = (numbers >= mesh.first) & (numbers < mesh.first + mesh.n_own)
    found[here] = mesh.vertices[numbers[here] - mesh.first]
    return np.asarray(mesh.ranks.sum(found))
