"""Vector fields as the methods take them: tangential, one vector a face."""

import numpy as np

from geomhw.arrays import Floats, dot
from geomhw.errors import FieldError
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.results import Field


def face_vectors(mesh: TriangleMesh, field: Field) -> Floats:
    """A vector field as one vector a face, (m, 3); vertex values are averaged over the three corners."""
    values = np.asarray(field.values, dtype=float)
    if values.ndim != 2 or values.shape[1] != 3 or field.location == "mesh":
        raise FieldError(f"'{field.name}' is no vector field: it needs three components a face or vertex")
    return np.asarray(values[mesh.faces].mean(axis=1)) if field.location == "vertex" else values


def tangential(mesh: TriangleMesh, field: Floats) -> Floats:
    """A face field less its part normal to the faces, (m, 3); FieldError for another shape or a value not finite."""
    values = np.asarray(field, dtype=float)
    if values.shape != (mesh.n_faces, 3):
        raise FieldError(f"a face field on this mesh has shape ({mesh.n_faces}, 3), not {values.shape}")
    if not (finite := np.isfinite(values).all(axis=1)).all():
        raise FieldError(f"the field is not finite on face {int(np.argmin(finite))}")
    normal_part = np.einsum("fx,fx->f", values, mesh.face_normals)
    return np.asarray(values - normal_part[:, None] * mesh.face_normals)


def energy(mesh: TriangleMesh, field: Floats) -> float:
    """The integral of |V|², units of V² times area."""
    return dot(mesh.face_areas, np.einsum("fx,fx->f", field, field))
