"""Division of the faces of a surface into four, from edge lengths."""

import numpy as np

from geomhw.arrays import frozen
from geomhw.intrinsic.intrinsic_mesh import IntrinsicMesh
from geomhw.mesh.polyhedral import PolyhedralSurface
from geomhw.mesh.topology import Edges


def divided_faces(surface: PolyhedralSurface) -> IntrinsicMesh:
    """Divide each face into four similar ones at the middles of its edges; the surface stays the same.

    Returns
    -------
    IntrinsicMesh
        n + e vertices: those given, then one for each edge. The faces at the corners 0, 1, 2 of each given face, with
        that corner first, then the one in the middle, (4m, 3).

    Examples
    --------
    >>> from geomhw.mesh import icosphere
    >>> ball = icosphere(2)
    >>> fine = divided_faces(ball)
    >>> fine.n_faces == 4 * ball.n_faces, bool(np.isclose(fine.face_areas.sum(), ball.face_areas.sum()))
    (True, True)
    """
    table, n, e = surface.edge_table, surface.n_vertices, len(surface.edge_lengths)
    faces, of_faces = surface.faces.astype(np.int64), table.of_faces.astype(np.int64)
    middle = n + of_faces
    across = 2 * e + np.arange(of_faces.size).reshape(-1, 3)  # the edge between the middles beside each corner
    parts, opposite = [], []
    for k in range(3):
        corner, after, before = faces[:, k], (k + 1) % 3, (k + 2) % 3
        parts.append(np.stack([corner, middle[:, before], middle[:, after]], axis=1))
        halves = [2 * edge + (corner != table.vertices[edge, 0]) for edge in (of_faces[:, after], of_faces[:, before])]
        opposite.append(np.stack([across[:, k], *halves], axis=1))
    ends = np.stack([table.vertices, np.broadcast_to(n + np.arange(e)[:, None], (e, 2))], axis=2).reshape(-1, 2)
    inner = np.sort(np.stack([np.roll(middle, -1, axis=1), np.roll(middle, -2, axis=1)], axis=2).reshape(-1, 2), axis=1)
    signs = table.orientation_sums[:, None] * np.array([1, -1])
    gluing = Edges(
        frozen(np.concatenate([ends, inner])),
        frozen(np.stack([*opposite, across], axis=1).reshape(-1, 3)),
        frozen(np.concatenate([np.repeat(table.face_counts, 2), np.full(inner.shape[0], 2)])),
        frozen(np.concatenate([signs.ravel(), np.zeros(inner.shape[0], dtype=signs.dtype)])),
    )
    lengths = np.concatenate([np.repeat(surface.edge_lengths, 2), surface.edge_lengths[of_faces].ravel()]) / 2
    fine = np.stack([*parts, middle], axis=1).reshape(-1, 3)
    return IntrinsicMesh(n + e, frozen(fine), gluing, frozen(lengths), surface.sheets)
