"""Where arrows may stand: at vertices or in the middles of faces, and all over large faces."""

import numpy as np

from geomhw.arrays import Floats
from geomhw.mesh.geometry import unit
from geomhw.mesh.sampling import area_samples, points_on
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.render.layers import Arrows

#: Area of a large face in squares of the spacing, samples for each square, of which few remain, and samples in all.
LARGE, DENSITY, MOST = 4, 4, 50_000


def arrow_places(mesh: TriangleMesh, arrows: Arrows, spacing: float) -> tuple[Floats, Floats, Floats]:
    """Return the points, vectors and unit normals of arrows before they are thinned, (k, 3) each.

    In large faces, vectors at vertices are turned into the plane of the face and interpolated. spacing: of arrows, in
    units of the mesh.
    """
    per_face, vectors = arrows.location == "face", np.asarray(arrows.vectors, dtype=float)
    normals = mesh.face_normals if per_face else mesh.vertex_normals
    if arrows.points is not None:
        return arrows.points, vectors, normals
    points = mesh.face_centers if per_face else mesh.vertices
    large = np.flatnonzero(mesh.face_areas > LARGE * spacing**2)
    if not len(large):
        return points, vectors, normals
    part = TriangleMesh(mesh.vertices, mesh.faces[large])
    count = int(min(DENSITY * part.face_areas.sum() / spacing**2, MOST))
    face, weights = area_samples(part, count)
    upright = part.face_normals[face]
    found = vectors[large[face]] if per_face else _in_faces(vectors[part.faces[face]], weights, upright)
    return (
        np.concatenate([points, points_on(part, face, weights)]),
        np.concatenate([vectors, found]),
        np.concatenate([normals, upright]),
    )


def _in_faces(corners: Floats, weights: Floats, normals: Floats) -> Floats:
    """Vectors at the corners, (k, 3, 3), interpolated in length, and in direction after projection to the face."""
    length = np.einsum("pk,pk->p", weights, np.linalg.norm(corners, axis=2))
    mean = np.einsum("pk,pkx->px", weights, corners)
    mean -= np.einsum("px,px->p", mean, normals)[:, None] * normals
    return np.asarray(length[:, None] * unit(mean))
