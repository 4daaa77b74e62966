"""Vertices from which something spreads: checked once, here."""

from collections.abc import Sequence

import numpy as np

from geomhw.errors import FieldError
from geomhw.mesh.arrays import Ints
from geomhw.mesh.triangle_mesh import TriangleMesh


def default_source(mesh: TriangleMesh) -> int:
    """The vertex of largest y that belongs to a face, the lowest index on a tie."""
    height = mesh.vertices[:, 1].copy()
    height[mesh.unreferenced_vertices] = -np.inf
    return int(height.argmax())


def checked_sources(mesh: TriangleMesh, sources: Sequence[int] | Ints) -> Ints:
    """Sources as ascending unique vertex indices; FieldError if one is no vertex of the surface."""
    wanted = np.atleast_1d(np.asarray(sources))
    if wanted.size == 0:
        raise FieldError("there is no source; name at least one vertex")
    if not np.issubdtype(wanted.dtype, np.integer):
        raise FieldError(f"a source is a vertex index, a whole number, not {wanted.flat[0]}")
    if (outside := (wanted < 0) | (wanted >= mesh.n_vertices)).any():
        bad = wanted[outside][0]
        raise FieldError(f"source {bad} is not a vertex: the mesh has {mesh.n_vertices} (0 to {mesh.n_vertices - 1})")
    if (loose := np.isin(wanted, mesh.unreferenced_vertices)).any():
        raise FieldError(f"source {wanted[loose][0]} belongs to no face; choose a vertex on the surface")
    return np.unique(wanted)
