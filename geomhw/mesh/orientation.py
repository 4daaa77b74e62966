"""Meshes made to agree on what is up: by turning faces, or, where a surface has one side only, by taking it twice."""

import numpy as np

from geomhw.mesh import orientation_signs
from geomhw.mesh.triangle_mesh import TriangleMesh


def without_duplicate_faces(mesh: TriangleMesh) -> TriangleMesh:
    """The mesh without the copies among its ``duplicate_faces``; the mesh itself if there are none."""
    if not len(mesh.duplicate_faces):
        return mesh
    return TriangleMesh(mesh.vertices, np.delete(mesh.faces, mesh.duplicate_faces[:, 0], axis=0))


def oriented(mesh: TriangleMesh) -> TriangleMesh:
    """The mesh with faces turned by `face_signs`, (a, b, c) to (a, c, b); itself if there is nothing to turn."""
    if mesh.is_oriented:
        return mesh
    turn = orientation_signs.face_signs(mesh.edge_table)[:, None] < 0
    return TriangleMesh(mesh.vertices, np.where(turn, mesh.faces[:, [0, 2, 1]], mesh.faces))


def orientation_cover(mesh: TriangleMesh) -> TriangleMesh:
    """A mesh that agrees on what is up wherever edges have two faces, over the same surface.

    That is the mesh without copies of faces, turned to agree. If some of it is one-sided, that is taken twice: 2n
    vertices, v and v + n in the same place, and a front and a back of each face [the orientation cover]. A tangent
    field on the mesh is one on the cover that is the same at v and at v + n.
    """
    single = without_duplicate_faces(mesh)
    if single.is_orientable:
        return oriented(single)
    faces = orientation_signs.cover_faces(single.faces, single.corner_signs, single.n_vertices)
    return TriangleMesh(np.concatenate([mesh.vertices, mesh.vertices]), faces)
