"""Both sides of a mesh as one closed surface: a home for boundaries, and for edges where three faces meet."""

import numpy as np

from geomhw.arrays import frozen
from geomhw.intrinsic.intrinsic_mesh import IntrinsicMesh
from geomhw.mesh.topology import Edges, halfedges


def tufted_cover(surface: IntrinsicMesh) -> IntrinsicMesh:
    """The tufted cover: a front and a back of each face, glued so that every edge has two faces which agree on what is
    up; over the same vertices, in two sheets [Sharp, Crane 2020, sec. 3.2].

    Turning round an edge, the side on which one face is left is glued to the side on which the next is met: at a
    boundary, a face's front to its own back. A function of the vertices has the same values on front and back. The
    corners of each face must be three different vertices.

    Sharp, Crane: A Laplacian for Nonmanifold Triangle Meshes. Computer Graphics Forum 39(5), 2020.
    """
    m, table = surface.n_faces, surface.gluing
    of_halfedge = table.of_faces.ravel()
    # The faces round an edge in the order of the file: any cyclic order makes a cover.
    order = np.argsort(of_halfedge, kind="stable")
    last = np.cumsum(table.face_counts) - 1
    previous = np.empty_like(order)
    previous[order] = np.roll(order, 1)
    previous[order[last - table.face_counts + 1]] = order[last]
    # Each halfedge is left by one side and met by the other; the edge of the cover has the number of the one left.
    start, end = halfedges(surface.faces).reshape(-1, 2).T
    own = np.arange(3 * m)
    front = np.where(start < end, own, previous).reshape(m, 3)
    back = np.where(start < end, previous, own).reshape(m, 3)
    over = [0, 2, 1]  # the back's corners, in its own sense
    faces = np.concatenate([surface.faces, surface.faces[:, over]])
    of_faces = np.concatenate([front, back[:, over]])
    twos, zeros = np.full(3 * m, 2), np.zeros(3 * m, dtype=np.int64)
    gluing = Edges(frozen(table.vertices[of_halfedge]), frozen(of_faces), frozen(twos), frozen(zeros))
    return IntrinsicMesh(surface.vertex_count, frozen(faces), gluing, frozen(surface.lengths[of_halfedge]), 2)
