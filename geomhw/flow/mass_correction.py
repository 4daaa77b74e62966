"""The inverse of the consistent mass as a series of products, and the filter of the shortest waves that it yields."""

import numpy as np
import scipy.sparse as sp

from geomhw.arrays import Floats
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.mass import consistent_mass

#: Terms of the series M_c⁻¹ = (I + R + R² + ...) M⁻¹, R = I - M⁻¹M_c. With the lumped mass alone waves lag; each term
#: reduces the lag by half or more.
MASS_CORRECTIONS = 2


class MassCorrection:
    """The operator R = I - M⁻¹M_c of one mesh, which is zero on constants and at most 3/4.

    Attributes
    ----------
    areas, inverse_areas : (n,) arrays, the lumped mass M and M⁻¹; zero at a vertex without faces.
    """

    def __init__(self, mesh: TriangleMesh) -> None:
        self.mesh = mesh
        self.areas = mesh.vertex_areas
        self.inverse_areas = np.divide(1.0, self.areas, out=np.zeros_like(self.areas), where=self.areas > 0)
        self._mass = consistent_mass(mesh)
        self._R = (sp.eye_array(mesh.n_vertices) - sp.diags_array(self.inverse_areas) @ self._mass).tocsr()

    def mass_corrected(self, density: Floats, terms: int = MASS_CORRECTIONS) -> Floats:
        """Return B M d ≈ M_c⁻¹ M d, (n,) or (n, k), by the series in R: symmetric in q = M d, and without a solve."""
        w = density
        for _ in range(terms):
            w = density + self._R @ w
        return np.asarray(w)

    def hyperdiffusion(self, w: Floats, alpha: Floats) -> Floats:
        """Return R √α R √α R w, (n,) or (n, k): M times it is symmetric, semidefinite, and zero for constants.

        On a wave of length L it is about (h/L)⁶ of its value on the shortest wave.
        """
        root = np.sqrt(alpha)
        return np.asarray(self._R @ (root * (self._R @ (root * (self._R @ w)))))
