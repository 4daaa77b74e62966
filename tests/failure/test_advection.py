"""Advection refuses wrong fields, functions, times and integrators."""

import numpy as np
import pytest

from geomhw.errors import FieldError
from geomhw.flow.advection import frames
from geomhw.flow.flow_map import FlowMap
from geomhw.flow.initial_fields import blob, rigid_field
from support.exact import Z
from support.meshes import zoo_mesh


def test_refusals() -> None:
    """Wrong fields, functions, times and integrators raise, with the size, face, vertex or choices."""
    mesh = zoo_mesh("sphere")
    V = rigid_field(mesh, Z)
    with pytest.raises(FieldError, match=r"\(1280, 3\)"):
        FlowMap(mesh, V[:5])
    bad = V.copy()
    bad[4] = np.nan
    with pytest.raises(FieldError, match="face 4"):
        FlowMap(mesh, bad)
    with pytest.raises(FieldError, match="taylor3, expm"):
        FlowMap(mesh, V, "euler")  # type: ignore[arg-type]
    flow = FlowMap(mesh, V)
    with pytest.raises(FieldError, match="642 values"):
        flow.advect(np.zeros(7), 1.0)
    with pytest.raises(FieldError, match="vertex 9"):
        flow.advect(np.where(np.arange(642) == 9, np.nan, 0.0), 1.0)
    for dt, steps, every, words in ((0.0, 1, 1, "positive"), (np.nan, 1, 1, "positive"), (1.0, 0, 1, "one step")):
        with pytest.raises(FieldError, match=words):
            list(frames(flow, mesh.vertices[:, 0], dt, steps, every))
    with pytest.raises(FieldError, match="axis"):
        rigid_field(mesh, np.zeros(3))
    with pytest.raises(FieldError, match="vertex 642"):
        blob(mesh, 642)
