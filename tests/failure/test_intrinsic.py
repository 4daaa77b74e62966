"""Intrinsic triangulations refuse meshes in one point, and flips that do not end."""

import numpy as np
import pytest

from geomhw.errors import ConvergenceError, MeshError
from geomhw.intrinsic import delaunay
from geomhw.intrinsic.robust import RobustTriangulation
from geomhw.mesh.triangle_mesh import TriangleMesh
from support.meshes import spiky


def test_a_single_point_is_refused() -> None:
    """A mesh whose edge lengths are all zero raises."""
    with pytest.raises(MeshError, match="one point"):
        RobustTriangulation.of(TriangleMesh(np.ones((3, 3)), [[0, 1, 2]]))


def test_flips_that_do_not_end(monkeypatch: pytest.MonkeyPatch) -> None:
    """When the flips do not end, the error names a vertex beside a changing edge."""
    monkeypatch.setattr(delaunay, "MAX_FLIPS", 1)
    with pytest.raises(ConvergenceError, match=r"flips do not .*vertex \d+"):
        RobustTriangulation.of(spiky())
