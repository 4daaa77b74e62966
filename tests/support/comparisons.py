"""Results with arrays of every kind, and the same with one value changed."""

from dataclasses import replace

import numpy as np

from geomhw.compare import Comparison, Finding, Ignored, Tolerance
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.results import Field, Result

NONE, DEFAULT = Ignored(), Tolerance()


def arrays_on(mesh: TriangleMesh) -> Result:
    """Return a mesh with an array of each kind and location, with infinity and NaN."""
    rng = np.random.default_rng(1)
    reach = rng.normal(size=mesh.n_vertices)
    reach[0], reach[1] = np.inf, np.nan
    return Result(
        mesh,
        [
            Field("reach", "vertex", reach),
            Field("wind", "vertex", rng.normal(size=(mesh.n_vertices, 3))),
            Field("gale", "face", rng.normal(size=(mesh.n_faces, 3))),
            Field("label", "face", np.arange(mesh.n_faces)),
        ],
    )


def planted(result: Result, name: str, index: tuple[int, ...], value: float) -> Result:
    """Return the result with one value changed."""
    fields = []
    for field in result.fields:
        values = np.array(field.values)
        if field.name == name:
            values[index] = value
        fields.append(replace(field, values=values))
    return replace(result, fields=fields)


def one(comparison: Comparison) -> Finding:
    """Return the only finding that differs."""
    (finding,) = comparison.different
    return finding
