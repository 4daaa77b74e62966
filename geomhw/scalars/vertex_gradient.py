"""The gradient of a function at vertices, by cubic fits."""

import numpy as np

from geomhw.arrays import Floats
from geomhw.mesh.cut import cut_into_sheets, means_of_copies
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.local_fit import LocalFit


def vertex_gradient(mesh: TriangleMesh, values: Floats) -> Floats:
    """Compute the gradient of a function at vertices, with an error of O(h³) on irregular meshes too.

    Parameters
    ----------
    mesh
        The surface.
    values
        (n,) array.

    Returns
    -------
    (n, 3) array, units of the values per length, tangent to the surface that `LocalFit` fits. At pinched vertices and
    at edges of more than two faces, the mean of the gradients on the sheets that meet there.

    Raises
    ------
    MeshError
        If a face has zero area.

    Examples
    --------
    >>> from geomhw.mesh import grid
    >>> mesh = grid(4, 4)
    >>> (vertex_gradient(mesh, 2 * mesh.vertices[:, 0]).round(12)[7] + 0.0).tolist()
    [2.0, 0.0, 0.0]
    """
    surface, original = cut_into_sheets(mesh)
    fit = LocalFit(surface, degree=3)
    slopes = np.stack([D @ np.asarray(values, dtype=float)[original] for D in fit.vertex_slopes], axis=1)
    # Derivatives of the position along the coordinates of the fit, which are not quite tangent to the surface.
    tangents = np.stack(fit.tangents(surface.vertices), axis=1)
    metric = np.einsum("nax,nbx->nab", tangents, tangents) + np.finfo(float).tiny * np.eye(2)
    gradients = np.einsum("nab,nb,nax->nx", np.linalg.pinv(metric, hermitian=True), slopes, tangents)
    return np.asarray(means_of_copies(surface, original) @ gradients)
