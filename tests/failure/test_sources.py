"""Sources and their vectors are refused outside the mesh, or where they contradict each other."""

from collections.abc import Callable

import numpy as np
import pytest

from geomhw.errors import FieldError
from geomhw.mesh.named_points import boundary_points, face_point, vertex_range
from geomhw.mesh.nearest import nearest_point
from geomhw.mesh.surface_points import SurfacePoints, concatenate
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.transport.vector_heat import VectorHeat
from support.meshes import zoo_mesh


@pytest.mark.parametrize(
    ("place", "words"),
    [
        (lambda m: face_point(m, 640), r"face 640 .*640 faces \(0 to 639\)"),
        (lambda m: face_point(m, -1), "face -1 does not exist"),
        (lambda m: face_point(m, 3, [0.5, 0.7, -0.2]), "0.5, 0.7, -0.2 .*outside .*face 3.*negative"),
        (lambda m: face_point(m, 3, [0.5, 0.2, 0.2]), r"sum to 0\.9"),
        (lambda m: face_point(m, 3, [0.5, 0.5]), "three barycentric coordinates"),
        (lambda m: face_point(m, 3, [np.nan, 0.5, 0.5]), "three barycentric coordinates"),
        (lambda m: vertex_range(m, 3, 10**15), "source 1000000000000000 is not a vertex"),
        (lambda m: vertex_range(m, 160, 163), "source 162 belongs to no face"),
        (boundary_points, "no boundary"),
        (lambda m: nearest_point(m, [0, np.inf, 0]), "finite coordinates"),
    ],
)
def test_refusals(place: Callable[[TriangleMesh], SurfacePoints], words: str) -> None:
    """Faces, weights, ranges and points outside the mesh raise, with the numbers."""
    with pytest.raises(FieldError, match=words):
        place(zoo_mesh("two_spheres"))


def test_vectors_within_faces_refused() -> None:
    """A vector normal to its face, and two vectors at one point, raise."""
    mesh = zoo_mesh("sphere")
    point = face_point(mesh, 7)
    with pytest.raises(FieldError, match=r"source face 7 \(0.333333, .*normal to the surface"):
        VectorHeat(mesh).from_sources(point, mesh.face_normals[[7]])
    with pytest.raises(FieldError, match=r"source face 7 .*twice.*different vectors"):
        VectorHeat(mesh).from_sources(concatenate([point, point]), [[1, 0, 0], [0, 1, 0]])
