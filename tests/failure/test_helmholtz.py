"""The Helmholtz-Hodge decomposition refuses wrong fields and one-sided meshes."""

import numpy as np
import pytest

from geomhw.errors import FieldError, MeshError
from geomhw.flow.helmholtz import HelmholtzDecomposition
from geomhw.mesh.primitives import moebius_band
from support.meshes import zoo_mesh


def test_refusals() -> None:
    """A field of the wrong size, a NaN and a one-sided mesh raise."""
    mesh = zoo_mesh("sphere")
    decomposition = HelmholtzDecomposition(mesh)
    with pytest.raises(FieldError, match=r"\(1280, 3\)"):
        decomposition(np.zeros((5, 3)))
    bad = np.zeros((mesh.n_faces, 3))
    bad[7, 1] = np.nan
    with pytest.raises(FieldError, match="face 7"):
        decomposition(bad)
    with pytest.raises(MeshError, match="oriented"):
        HelmholtzDecomposition(moebius_band(12, 2))
