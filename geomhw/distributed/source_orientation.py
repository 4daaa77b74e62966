"""The side of a distributed mesh on which its normals are, against that of the faces round its sources alone."""

import numpy as np

from geomhw.arrays import Ints
from geomhw.distributed.local_mesh import BLOCK, LocalMesh
from geomhw.distributed.orientation_cover import edges_of_rank, inner_links, orientation_labels
from geomhw.distributed.shared_faces import SharedFaces
from geomhw.distributed.source_stars import SourceStars
from geomhw.mesh.cut import cut_into_sheets
from geomhw.mesh.surface_points import SurfacePoints


def source_orientation(mesh: LocalMesh, stars: SourceStars, sources: SurfacePoints) -> Ints:
    """Return -1 for sources at vertices whose normal on the mesh of the stars is opposite to that on the whole, else 1.

    The whole mesh reverses the smaller part of the faces, as `face_signs`; the stars have some of them only.

    Returns
    -------
    (s,) array, the same on all ranks.
    """
    sides = np.ones(len(sources), dtype=np.int64)
    links = inner_links(*edges_of_rank(mesh))
    if not mesh.ranks.max(bool(links[2].any())):
        return sides
    at_vertex = np.flatnonzero(sources.faces < 0)
    vertices, corners = np.unique(stars.mesh.faces, return_index=True)
    corner = corners[np.searchsorted(vertices, stars.points(sources).corners[at_vertex, 0])]
    here = cut_into_sheets(stars.mesh)[0].corner_signs.ravel()[corner]
    labels = np.stack(orientation_labels(mesh, links), axis=1)
    first = SharedFaces(mesh, mesh.faces).first
    sides[at_vertex] = here * _signs(mesh, stars, corner // 3, labels, first)
    return sides


def _signs(mesh: LocalMesh, stars: SourceStars, faces: Ints, labels: Ints, first: Ints) -> Ints:
    """Return the signs of some faces of the stars on the whole mesh; 1 in a one-sided part, as at a lowest corner.

    labels : (f, 2) as `orientation_labels`. first : whether this is the first rank that has a face, (f,).
    """
    of_stars = np.zeros((stars.mesh.n_faces, 2), dtype=np.int64)
    rows, places = stars.common_faces(mesh)
    of_stars[places[first[rows]]] = labels[rows[first[rows]]]
    given, reverse = np.asarray(mesh.ranks.sum(of_stars))[faces].T
    patches, patch = np.unique(np.minimum(given, reverse), return_inverse=True)
    here = np.flatnonzero(first & np.isin(labels.min(axis=1), patches))
    of_rank = np.searchsorted(patches, labels[here].min(axis=1))
    agrees = labels[here, 0] < labels[here, 1]
    sizes = [mesh.ranks.sum(np.bincount(of_rank[side], minlength=len(patches))) for side in (agrees, ~agrees)]
    kept = sizes[0] > sizes[1]  # whether the faces that agree with the lowest one in the order of the curve are kept
    equal = np.flatnonzero((sizes[0] == sizes[1]) & (np.bincount(patch, given != reverse, len(patches)) > 0))
    kept[equal] = _first_agrees(mesh, here, agrees, of_rank, equal)
    return np.where((given == reverse) | ((given < reverse) == kept[patch]), 1, -1)


def _first_agrees(mesh: LocalMesh, faces: Ints, agrees: Ints, patch: Ints, wanted: Ints) -> Ints:
    """Return whether the face of some patches that is the first in the file agrees with the lowest in the curve."""
    in_file, count = mesh.with_ghosts(mesh.part.in_file), mesh.file.n_faces
    among = np.isin(patch, wanted)
    corners, agrees, patch = np.sort(in_file[mesh.faces[faces[among]]], axis=1), agrees[among], patch[among]
    found = np.zeros(len(wanted), dtype=bool)
    missing = np.ones(len(wanted), dtype=bool)
    for begin in range(0, count if len(wanted) else 0, BLOCK):
        with mesh.ranks.agreeing():
            block = np.sort(mesh.file.read_faces(begin, min(begin + BLOCK, count)), axis=1)
        rows, inverse = np.unique(np.concatenate([block, corners]), axis=0, return_inverse=True)
        place = np.full(len(rows), count)
        np.minimum.at(place, inverse.ravel()[: len(block)], np.arange(len(block)))
        place = place[inverse.ravel()[len(block) :]]  # in the block
        lowest = np.full(len(wanted), count)
        np.minimum.at(lowest, np.searchsorted(wanted, patch), place)
        best = np.min(mesh.ranks.comm.allgather(lowest), axis=0)
        side = np.zeros(len(wanted), dtype=np.int64)
        hit = (place < count) & (place == best[np.searchsorted(wanted, patch)])
        side[np.searchsorted(wanted, patch[hit])] = agrees[hit]
        side = np.asarray(mesh.ranks.sum(side))
        new = missing & (best < count)
        found[new], missing = side[new] > 0, missing & ~new
        if not missing.any():
            break
    return found
