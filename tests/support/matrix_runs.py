"""Runs of ``geodesic --all-pairs`` that stop halfway, and the matrix that they should give."""

from collections.abc import Callable
from typing import Any

import numpy as np

from geomhw.geodesic.heat_method import HeatDistance
from geomhw.mesh.primitives import torus
from support.meshes import crumpled

MESH = crumpled(torus(16, 13))  # 208 vertices, four blocks
ALL = "geodesic mesh.off --time h2 --all-pairs -o D.npy"


def expected(**options: Any) -> np.ndarray:
    """Return all distances, one source after the other."""
    solver = HeatDistance(MESH, "h2", **options)
    return np.stack([solver.from_vertices([v])["distance"] for v in range(MESH.n_vertices)])


# -- interrupted runs -------------------------------------------------------------------------------------------------


def stopping(at: int, stop: Callable[[], object]) -> Callable[..., Any]:
    """Return a `HeatDistance.rows` that stops at one of its calls."""
    rows, calls = HeatDistance.rows, []

    def stopped(self: HeatDistance, queries: Any) -> Any:
        calls.append(1)
        if len(calls) == at:
            stop()
        return rows(self, queries)

    return stopped


def interrupt() -> None:
    raise KeyboardInterrupt
