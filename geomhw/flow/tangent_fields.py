"""Tangent vector fields with one vector per face."""

import numpy as np

from geomhw.arrays import Floats, dot
from geomhw.errors import FieldError
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.results import Field


def face_vectors(mesh: TriangleMesh, field: Field) -> Floats:
    """Return a vector field per face, (m, 3); values at vertices are averaged over the three corners of each face.

    Raises
    ------
    FieldError
        If the field is not a vector field per face or per vertex.
    """
    values = np.asarray(field.values, dtype=float)
    if values.ndim != 2 or values.shape[1] != 3 or field.location == "mesh":
        raise FieldError(f"'{field.name}' is not a vector field: it needs three components per face or vertex")
    return np.asarray(values[mesh.faces].mean(axis=1)) if field.location == "vertex" else values


def tangential(mesh: TriangleMesh, field: Floats) -> Floats:
    """Return the tangential part of a face field, V - (V·n) n, (m, 3).

    Raises
    ------
    FieldError
        If the field is not of shape (m, 3) or not finite.
    """
    values = np.asarray(field, dtype=float)
    if values.shape != (mesh.n_faces, 3):
        raise FieldError(f"a face field on this mesh has shape ({mesh.n_faces}, 3), not {values.shape}")
    if not (finite := np.isfinite(values).all(axis=1)).all():
        raise FieldError(f"the field is not finite on face {int(np.argmin(finite))}")
    normal_part = np.einsum("fx,fx->f", values, mesh.face_normals)
    return np.asarray(values - normal_part[:, None] * mesh.face_normals)


def energy(mesh: TriangleMesh, field: Floats) -> float:
    """Return the integral of |V|² over the surface, units of V² times area."""
    return dot(mesh.face_areas, np.einsum("fx,fx->f", field, field))
