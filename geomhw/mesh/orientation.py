"""Consistent orientation of a mesh: reversed faces, the orientation double cover, removal of duplicate faces."""

import numpy as np

from geomhw.mesh import orientation_signs
from geomhw.mesh.triangle_mesh import TriangleMesh


def without_duplicate_faces(mesh: TriangleMesh) -> TriangleMesh:
    """Remove faces that have the three vertices of an earlier face.

    Returns
    -------
    TriangleMesh
        A mesh without the faces ``mesh.duplicate_faces[:, 0]``; ``mesh`` itself if there are none.

    Examples
    --------
    >>> mesh = TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2], [1, 0, 2]])
    >>> without_duplicate_faces(mesh).faces
    array([[0, 1, 2]], dtype=int32)
    """
    if not len(mesh.duplicate_faces):
        return mesh
    return TriangleMesh(mesh.vertices, np.delete(mesh.faces, mesh.duplicate_faces[:, 0], axis=0))


def oriented(mesh: TriangleMesh) -> TriangleMesh:
    """Orient a mesh consistently by reversing faces, (a, b, c) to (a, c, b).

    Faces are compared across edges with exactly two faces. Of each part of the surface that these edges connect, the
    smaller number of faces is reversed. One-sided parts stay as they are.

    Returns
    -------
    TriangleMesh
        The same vertices and faces in the same order; ``mesh`` itself if no face is reversed.

    Examples
    --------
    >>> square = TriangleMesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 3, 2]])
    >>> oriented(square).faces.tolist()
    [[0, 1, 2], [0, 2, 3]]
    """
    if mesh.is_oriented:
        return mesh
    turn = orientation_signs.face_signs(mesh.edge_table)[:, None] < 0
    return TriangleMesh(mesh.vertices, np.where(turn, mesh.faces[:, [0, 2, 1]], mesh.faces))


def orientation_cover(mesh: TriangleMesh) -> TriangleMesh:
    """Build a consistently oriented mesh over the same surface.

    Duplicate faces are removed. An orientable mesh is `oriented`; any other is replaced by its orientation double
    cover. Orientation is consistent across edges with exactly two faces.

    Returns
    -------
    TriangleMesh
        A mesh with n vertices if ``mesh`` is orientable. Otherwise 2n vertices, v and v + n at the same position, and
        2m faces, a front and a back of each. A tangent field on ``mesh`` is a field on the cover with equal values at
        v and v + n.

    Examples
    --------
    >>> from geomhw.mesh import moebius_band
    >>> cover = orientation_cover(moebius_band(20, 2))
    >>> cover.n_vertices, cover.is_oriented
    (120, True)
    """
    single = without_duplicate_faces(mesh)
    if single.is_orientable:
        return oriented(single)
    faces = orientation_signs.double_cover_faces(single.faces, single.corner_signs, single.n_vertices)
    return TriangleMesh(np.concatenate([mesh.vertices, mesh.vertices]), faces)
