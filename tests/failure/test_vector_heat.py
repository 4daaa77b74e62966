"""Vector transport refuses wrong sources, vectors and connections."""

import numpy as np
import pytest

from geomhw.errors import FieldError
from geomhw.transport.vector_heat import VectorHeat
from support.meshes import zoo_mesh


@pytest.mark.parametrize(
    ("sources", "vectors", "words"),
    [
        ([0, 0], [[1, 0, 0], [0, 1, 0]], "source 0 .*twice.*different vectors"),
        ([0], [[0, 0, 0]], "zero"),
        ([0], [[0, np.nan, 0]], "not finite"),
        ([0], [[np.inf, 0, 0]], "not finite"),
        ([0], [[0, 0, 2]], "normal to the surface"),
        ([0, 1], [[1, 0, 0]], "2 sources.*vectors"),
        ([999], [[1, 0, 0]], "source 999 is not a vertex"),
    ],
)
def test_refusals(sources: list[int], vectors: list[list[float]], words: str) -> None:
    """Wrong vectors and sources raise with their own keywords."""
    with pytest.raises(FieldError, match=words):
        VectorHeat(zoo_mesh("grid")).from_vertices(sources, vectors)


def test_robust_has_normals_only() -> None:
    """The intrinsic connection raises on a robust triangulation."""
    with pytest.raises(FieldError, match=r"no intrinsic connection; use"):
        VectorHeat(zoo_mesh("sphere"), connection="intrinsic", robust=True)
