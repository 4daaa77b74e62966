"""The tufted cover: a closed oriented double cover of any triangle mesh, also open and non-manifold ones."""

import numpy as np

from geomhw.arrays import frozen
from geomhw.intrinsic.intrinsic_mesh import IntrinsicMesh
from geomhw.mesh.topology import Edges, halfedges


def tufted_cover(surface: IntrinsicMesh) -> IntrinsicMesh:
    """Build the tufted cover: a front and a back of each face, glued along edges with exactly two faces each.

    The faces around an edge are put in a cyclic order. The front of each is glued to the back of the next; at a
    boundary edge, the front of a face to its own back.

    Parameters
    ----------
    surface : IntrinsicMesh
        Each face must have three different vertices.

    Returns
    -------
    IntrinsicMesh
        Closed and consistently oriented, with the same n vertices, 2m faces and two ``sheets``. Integrals over it are
        averages of both sides, so a function on the vertices has the same energy as on ``surface``.

    References
    ----------
    Sharp, Crane: A Laplacian for Nonmanifold Triangle Meshes. Computer Graphics Forum 39(5), 2020, sec. 3.2.

    Examples
    --------
    >>> from geomhw.mesh import grid
    >>> cover = tufted_cover(IntrinsicMesh.of(grid(2, 2)))
    >>> cover.n_faces, cover.is_closed, cover.sheets
    (16, True, 2)
    """
    m, table = surface.n_faces, surface.gluing
    of_halfedge = table.of_faces.ravel()
    # The faces around each edge in the order of their indices; any cyclic order gives a cover.
    order = np.argsort(of_halfedge, kind="stable")
    last = np.cumsum(table.face_counts) - 1
    previous = np.empty_like(order)
    previous[order] = np.roll(order, 1)
    previous[order[last - table.face_counts + 1]] = order[last]
    # Each edge of the cover is numbered by the halfedge 3f+k on one of its two sides.
    start, end = halfedges(surface.faces).reshape(-1, 2).T
    own = np.arange(3 * m)
    front = np.where(start < end, own, previous).reshape(m, 3)
    back = np.where(start < end, previous, own).reshape(m, 3)
    over = [0, 2, 1]  # corners of a back, in its own orientation
    faces = np.concatenate([surface.faces, surface.faces[:, over]])
    of_faces = np.concatenate([front, back[:, over]])
    twos, zeros = np.full(3 * m, 2), np.zeros(3 * m, dtype=np.int64)
    gluing = Edges(frozen(table.vertices[of_halfedge]), frozen(of_faces), frozen(twos), frozen(zeros))
    return IntrinsicMesh(surface.vertex_count, frozen(faces), gluing, frozen(surface.lengths[of_halfedge]), 2)
