"""Principal curvature directions as a target of direction fields: the trace-free part of the shape operator."""

import numpy as np

from geomhw.arrays import Complexes
from geomhw.directions.power_fields import unit_power
from geomhw.errors import ArgumentError
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.local_fit import LocalFit


def principal_target(mesh: TriangleMesh, n: int) -> Complexes:
    """Return the principal curvature directions as u, (n_vertices,), of size |κ1 - κ2| / 2.

    The shape operator comes from the derivatives of fitted normals. With n = 2 the direction is that of the larger
    curvature, where a surface curves away from its normals with positive curvature; with n = 4 both.

    Raises
    ------
    ArgumentError
        If n is not 2 or 4: principal directions are orthogonal lines.
    MeshError
        If a face has zero area.

    References
    ----------
    Knöppel, Crane, Pinkall, Schröder: Globally Optimal Direction Fields, 2013, sec. 5.2.
    """
    if n not in (2, 4):
        raise ArgumentError(f"principal curvature directions are lines or crosses, n = 2 or 4, not {n}")
    fit = LocalFit(mesh)
    slopes = np.stack([D @ fit.normals for D in fit.vertex_slopes], axis=1)
    W = np.einsum("iax,ibx->iab", slopes, fit.axes)
    hopf = (W[:, 0, 0] - W[:, 1, 1]) / 2 + 0.5j * (W[:, 0, 1] + W[:, 1, 0])
    return np.asarray(hopf if n == 2 else np.abs(hopf) * unit_power(hopf) ** 2)
