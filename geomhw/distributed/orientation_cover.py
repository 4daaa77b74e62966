"""A consistently oriented cover of a distributed mesh, cut into sheets: where tangent vectors diffuse."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Ints
from geomhw.distributed.assembly import counted_here, mean_length
from geomhw.distributed.local_mesh import Halo, LocalMesh
from geomhw.distributed.shared_faces import SharedFaces
from geomhw.mesh.geometry import distances
from geomhw.mesh.topology import Edges, inner_pairs, linked_components, pinched_vertices, unique_edges


@dataclass(frozen=True)
class LocalCover:
    """The part of the cover on one rank; a vertex and its copies are on the same rank.

    Attributes
    ----------
    mesh : one vertex for each fan of faces at a vertex, two if a part of the surface is one-sided.
    original : (k',) the vertex of this rank, counted from 0, that each vertex is a copy of, ascending.
    sides : 2 if a part of the surface is one-sided, else 1.
    crossings : numbers of edges of more than two faces, and of other vertices with several fans; no zeros.
    mean_edge_length : of the mesh that is covered; None if the cover is the mesh itself.
    """

    mesh: LocalMesh
    original: Ints
    sides: int
    crossings: dict[str, int]
    mean_edge_length: float | None = None


def orientation_cover(mesh: LocalMesh) -> LocalCover:
    """Return the cover of a distributed mesh, as `TangentDomain.cover` is that of a mesh; ``mesh`` itself if it is one.

    Faces are connected across edges with exactly two of them. If a part is one-sided, every fan has two copies,
    with its faces in opposite orientation.
    """
    k, ranks, faces = mesh.n_own, mesh.ranks, mesh.faces
    table, here = edges_of_rank(mesh)
    pinched = pinched_vertices(faces, table, most=2) if len(faces) else np.empty(0, dtype=np.int32)
    links = inner_links(table, here)
    if not ranks.max(bool(links[2].any() or (pinched < k).any())):
        return LocalCover(mesh, np.arange(k), 1, {})
    given, reverse = orientation_labels(mesh, links)
    sides = 1 + int(ranks.max(bool((given == reverse).any())))
    kept = np.stack([given <= reverse, given > reverse], axis=1) if sides == 1 else np.ones((len(faces), 2), dtype=bool)
    face, turn = np.nonzero(kept)
    cover, original = _cut(mesh, faces[face], turn == 1, _fans(links, kept))
    copies = np.bincount(original, minlength=k) > sides
    counted, several = table.vertices[here], table.face_counts[here] > 2
    ours, sheets = counted_here(mesh, counted), counted[several]
    copies[sheets[sheets < k]] = False
    counts = {
        "non_manifold_edges": int((ours & several).sum()),
        "non_manifold_vertices": int(copies.sum()),
    }
    totals = {name: int(ranks.sum(count)) for name, count in counts.items()}
    crossings = {name: total for name, total in totals.items() if total}
    return LocalCover(cover, original, sides, crossings, mean_length(mesh, distances(mesh.vertices, counted[ours])))


def edges_of_rank(mesh: LocalMesh) -> tuple[Edges, NDArray[np.bool_]]:
    """Return the edges of the faces of a rank, and whether an end is its own vertex: then all faces there are here."""
    if not len(mesh.faces):
        return Edges(*(np.empty(shape, dtype=np.int32) for shape in ((0, 2), (0, 3), 0, 0))), np.empty(0, dtype=bool)
    table = unique_edges(mesh.faces)
    return table, np.asarray((table.vertices < mesh.n_own).any(axis=1))


def inner_links(table: Edges, here: NDArray[np.bool_]) -> list[Ints]:
    """Return what `inner_pairs` does for the edges that `edges_of_rank` marks."""
    return [part[here[table.face_counts == 2]] for part in inner_pairs(table)]


def orientation_labels(mesh: LocalMesh, links: list[Ints]) -> tuple[Ints, Ints]:
    """Label each face, (f,), as given and reversed, by component of the cover.

    links : as `inner_links`. In an orientable part the label of a face that agrees with the lowest one is the lower.
    """
    m, ranks, shared = len(mesh.faces), mesh.ranks, SharedFaces(mesh, mesh.faces)
    numbers = np.zeros(m, dtype=np.int64)
    count = int(shared.first.sum())
    numbers[shared.first] = ranks.starts(count)[ranks.rank] + np.arange(count)
    numbers = shared(np.repeat(numbers[:, None], 3, axis=1))[np.arange(m), shared.first_corner]
    labels = np.concatenate([2 * numbers, 2 * numbers + 1])
    left, right, against = links[0] // 3, links[1] // 3, links[2]
    one, other = np.concatenate([left, left + m]), np.concatenate([right + m * against, right + m * ~against])
    parts = linked_components(one, other, 2 * m)
    while True:
        lowest = np.full(int(parts.max(initial=-1)) + 1, np.iinfo(np.int64).max)
        np.minimum.at(lowest, parts, labels)
        sides = lowest[parts].reshape(2, m)
        found = np.concatenate([shared(np.repeat(side[:, None], 3, axis=1)).min(axis=1) for side in sides])
        changed = ranks.sum(int((found != labels).sum()))
        labels = found
        if not changed:
            return labels[:m], labels[m:]


def _fans(links: list[Ints], kept: NDArray[np.bool_]) -> Ints:
    """Label the fan of each corner, (q, 3), of the faces of the cover.

    kept : (f, 2) whether each face as given and reversed is one of them; these are counted row by row.
    """
    place = np.cumsum(kept).reshape(-1, 2) - 1
    one, other, against = links
    ends = [[3 * place[edge // 3] + ((edge + step) % 3)[:, None] for step in (1, 2)] for edge in (one, other)]
    # Consistent faces run along an edge in opposite directions.
    ends[1] = [np.where(against[:, None], ends[1][step][:, ::-1], ends[1][1 - step]) for step in (0, 1)]
    both = kept[one // 3]
    left, right = (np.concatenate([end[both] for end in side]) for side in ends)
    return linked_components(left, right, 3 * int(kept.sum())).reshape(-1, 3)


def _cut(mesh: LocalMesh, faces: Ints, turn: NDArray[np.bool_], fans: Ints) -> tuple[LocalMesh, Ints]:
    """Give each fan of the faces, (q, 3), a vertex, and reverse some faces; also return the vertex of each fan."""
    k, ranks, own = mesh.n_own, mesh.ranks, faces < mesh.n_own
    labels, first = np.unique(fans[own], return_index=True)
    at = np.concatenate([faces[own][first], np.setdiff1d(np.arange(k), faces[own])])
    order = np.argsort(at, kind="stable")
    row = np.zeros(int(fans.max(initial=-1)) + 1, dtype=np.int64)
    row[labels] = np.argsort(order, kind="stable")[: len(labels)]
    original, starts = at[order], ranks.starts(len(order))
    begin, n = starts[ranks.rank], len(order)
    numbers = np.asarray(SharedFaces(mesh, faces)(np.where(own, begin + row[fans], 0)))
    ghosts = np.unique(numbers[~own])
    local = np.where(own, numbers - begin, n + np.searchsorted(ghosts, numbers)).astype(np.int32)
    local[turn] = local[turn][:, [0, 2, 1]]
    halo, points = Halo(ranks, starts, ghosts), mesh.vertices[original]
    part = replace(mesh.part, starts=starts, vertices=points, in_file=mesh.part.in_file[original])
    return LocalMesh(ranks, part, mesh.file, ghosts, np.concatenate([points, halo(points)]), local, halo), original
