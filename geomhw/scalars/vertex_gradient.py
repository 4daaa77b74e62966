"""The gradient of a function at vertices, by quadratic fits."""

import numpy as np

from geomhw.arrays import Floats
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.local_fit import LocalFit


def vertex_gradient(mesh: TriangleMesh, values: Floats) -> Floats:
    """Compute the gradient of a function at vertices, with an error of O(h²) on irregular meshes too.

    Parameters
    ----------
    mesh
        The surface.
    values
        (n,) array.

    Returns
    -------
    (n, 3) array, units of the values per length, in the tangent planes of the surface that `LocalFit` fits.

    Raises
    ------
    MeshError
        If a face has zero area.

    Examples
    --------
    >>> from geomhw.mesh import grid
    >>> mesh = grid(4, 4)
    >>> vertex_gradient(mesh, 2 * mesh.vertices[:, 0]).round(12)[7].tolist()
    [2.0, 0.0, 0.0]
    """
    fit = LocalFit(mesh)
    slopes = np.stack([D @ np.asarray(values, dtype=float) for D in fit.vertex_slopes])
    vectors = np.einsum("ai,iax->ix", slopes, fit.axes)
    # A tangent vector of the surface that has these components along the axes.
    upward = np.einsum("ix,ix->i", vectors, fit.normals) / np.maximum(
        np.einsum("ix,ix->i", mesh.vertex_normals, fit.normals), 0.1
    )
    return np.asarray(vectors - upward[:, None] * mesh.vertex_normals)
