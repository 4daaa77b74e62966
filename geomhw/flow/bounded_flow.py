"""Advection of functions by a steady tangent field within their range, also through open boundaries."""

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.flow.flow_map import vertex_functions
from geomhw.flow.mass_correction import MassCorrection
from geomhw.flow.passive_scalar import SUBSTEP, PassiveScalar
from geomhw.flow.tangent_fields import tangential
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.directional_derivative import directional_derivative
from geomhw.solvers.expm import norm_bound

#: A flow crosses the boundary at a vertex if it makes an angle with it whose sine is larger.
CROSSING = 0.25


class BoundedFlow:
    """The flow of one field on one mesh, which creates no new extrema.

    Functions move as in `PassiveScalar`. At vertices where the field enters through the boundary they do not change, so
    that their boundary values are carried in.

    Parameters
    ----------
    field : (m, 3) array, V per face; its normal part is ignored. It may have sources and sinks.

    Attributes
    ----------
    field : (m, 3) array, the tangential part of V.
    inflow : the vertices at which the field enters.

    Raises
    ------
    FieldError
        If the field has another shape or is not finite.
    MeshError
        If a face has zero area.

    Examples
    --------
    >>> import numpy as np
    >>> from geomhw.mesh import grid
    >>> mesh = grid(8, 8)
    >>> wind = np.tile([1.0, 0.0, 0.0], (mesh.n_faces, 1))
    >>> advected = BoundedFlow(mesh, wind).advect(mesh.vertices[:, 0], 0.5)
    >>> bool(0 <= advected.min() and advected.max() <= 1)
    True
    """

    def __init__(self, mesh: TriangleMesh, field: Floats) -> None:
        self.mesh = mesh
        self.field = tangential(mesh, field)
        self.inflow = inflow_vertices(mesh, self.field)
        self._derivative = directional_derivative(mesh, self.field)
        self._norm = norm_bound(self._derivative)
        self._scalar = PassiveScalar(MassCorrection(mesh))

    def advect(self, functions: Floats, t: float) -> Floats:
        """Return functions, (n,) or (n, k), moved downstream for a time t ≥ 0."""
        values = vertex_functions(self.mesh, functions)
        return self._scalar.advect(self._derivative, values, t, self.inflow)

    def steps_at_once(self, dt: float) -> int:
        """Return how many time steps fit into a step of the scheme, at least 1."""
        return max(1, int(min(SUBSTEP / (self._norm * dt), 2**31))) if self._norm else 2**31


def inflow_vertices(mesh: TriangleMesh, field: Floats) -> Ints:
    """Return the vertices, ascending, at which a tangent field, (m, 3), enters through the boundary.

    It enters if the flux into the mesh through the boundary edges at the vertex is above the share `CROSSING` of the
    flux of a field of the same length across them. A field along a smooth boundary, which the mesh has as a polygon,
    thus does not enter.
    """
    faces, corners = np.nonzero(mesh.edge_table.face_counts[mesh.edge_table.of_faces] == 1)
    outward = np.cross(mesh.opposite_edges[faces, corners], mesh.face_normals[faces])
    flux = np.einsum("bx,bx->b", outward, field[faces])
    largest = np.linalg.norm(outward, axis=1) * np.linalg.norm(field[faces], axis=1)
    ends = np.stack([mesh.faces[faces, (corners + 1) % 3], mesh.faces[faces, (corners + 2) % 3]], axis=1)
    sums, sizes = (
        np.bincount(ends.ravel(), np.repeat(values, 2), minlength=mesh.n_vertices) for values in (flux, largest)
    )
    return np.flatnonzero(sums < -CROSSING * sizes)
