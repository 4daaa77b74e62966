"""The deformation energy of tangent fields at vertices: its smallest eigenpairs, and the gap above Killing fields."""

from typing import get_args

import numpy as np
import scipy.sparse as sp

from geomhw.arrays import Complexes, Floats
from geomhw.errors import ArgumentError
from geomhw.mesh.curvature import angle_defects
from geomhw.mesh.polyhedral import PolyhedralSurface
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.deformation_energy import deformation_energy, field_unknowns
from geomhw.operators.edge_directions import carried_to_faces, edge_ends
from geomhw.operators.local_fit import LocalFit
from geomhw.options import Connection, FieldBoundary
from geomhw.spectral.eigenpairs import Eigenpairs, smallest_eigenpairs
from geomhw.spectral.field_symmetry import independent, real_parts

#: Angle defects below this, in radians, are errors of coordinates with six digits: the metric is flat.
FLAT = 1e-5
#: Energies times area below this are rounding.
ROUNDING = 1e-10
#: Least ratio of neighboring energies that is a gap, and largest energy, times area, of a Killing field, in h²/area.
CLEAR, RESOLVED = 10.0, 100.0
#: Independent Killing fields of a connected surface, and components whose fields are looked for, at most.
MOST_FIELDS, MOST_COMPONENTS = 3, 20


class KillingFields:
    """The deformation energy ∫ |½(∇V + ∇Vᵀ)|² of tangent fields at the vertices of one surface.

    Parameters
    ----------
    surface : an oriented manifold, with coordinates or with edge lengths alone.
    boundary : ``tangent``, fields do not cross the boundary, or ``free``.
    connection : ``normals``, which is second-order accurate by fitted normals, or ``intrinsic``, first-order, exact on
        flat metrics, and the only one without coordinates. By default ``intrinsic`` where the metric is flat.

    Attributes
    ----------
    ends : (e, 2) array, as `geomhw.operators.edge_ends`.
    fit : LocalFit of the mesh, whose normals define the tangent planes; None for the intrinsic connection.
    energy : (2n, 2n) sparse array, as `geomhw.operators.deformation_energy`.
    unknowns : (2n, r) sparse array, as `geomhw.operators.field_unknowns`.

    Raises
    ------
    ArgumentError
        If an option is unknown, or the connection needs normals.
    MeshError
        If a face has zero area or the surface is not an oriented manifold.

    References
    ----------
    Azencot, Ben-Chen, Chazal, Ovsjanikov: An Operator Approach to Tangent Vector Field Processing, 2013, sec. 5.
    Ben-Chen, Butscher, Solomon, Guibas: On Discrete Killing Vector Fields and Patterns on Surfaces, 2010.

    Examples
    --------
    A sphere has three rotations.

    >>> from geomhw.mesh import icosphere
    >>> fields = KillingFields(icosphere(3))
    >>> fields.gap(fields.pairs(6).values)[0]
    3
    """

    def __init__(
        self, surface: PolyhedralSurface, boundary: FieldBoundary = "tangent", connection: Connection | None = None
    ) -> None:
        if boundary not in get_args(FieldBoundary):
            choices = ", ".join(get_args(FieldBoundary))
            raise ArgumentError(f"there is no boundary condition '{boundary}'; choose from {choices}")
        self.surface, self.fit = surface, None
        self.connection: Connection = connection or _connection(surface)
        if isinstance(surface, TriangleMesh):
            surface.require_oriented("the deformation energy")
            self.fit = LocalFit(surface) if self.connection == "normals" else None
        self.ends = edge_ends(surface, self.connection, self.fit.normals if self.fit else None)
        self.energy = deformation_energy(surface, self.ends)
        self.unknowns = field_unknowns(surface, self.ends, tangent=boundary == "tangent")

    def pairs(self, k: int) -> Eigenpairs:
        """Compute the k fields of least energy.

        Returns
        -------
        Eigenpairs
            Energies per unit field, unit 1/length², ascending, and fields, (n, k) complex, at vertices.

        Raises
        ------
        ArgumentError
            If k exceeds the number of unknowns.
        ConvergenceError
            As `smallest_eigenpairs`.
        """
        E = self.unknowns
        M = E.T @ sp.diags_array(self._mass) @ E
        found = smallest_eigenpairs((E.T @ self.energy @ E).tocsr(), M.tocsr(), k)
        vectors = (E @ found.vectors).reshape(-1, 2, k)
        return Eigenpairs(found.values, vectors[:, 0] + 1j * vectors[:, 1], found.residuals)

    def stationary(self, fields: Complexes) -> tuple[Floats, Floats]:
        """Return the stationary energies, (c,), in the space of some fields, (n, d), and coefficients, (d, c)."""
        B = real_parts(fields)
        T = independent(B.T @ (self._mass[:, None] * B))
        B = B @ T
        values, turns = np.linalg.eigh(B.T @ (self.energy @ B)) if T.size else (np.empty(0), np.empty((0, 0)))
        return np.maximum(values, 0.0), np.asarray(T @ turns)

    def on_faces(self, fields: Complexes) -> Floats:
        """Return fields at vertices, (n, d), as face fields, (d, m, 3)."""
        faces = [carried_to_faces(self.surface, self.ends, z) for z in fields.T]
        return np.array(faces).reshape(-1, self.surface.n_faces, 3)

    @property
    def most(self) -> int:
        """Number of Killing fields that the surface has at most, for up to 20 components."""
        return MOST_FIELDS * min(self.surface.n_components, MOST_COMPONENTS)

    @property
    def _mass(self) -> Floats:
        """Area of the vertex of each real and imaginary part, (2n,)."""
        return np.repeat(self.surface.vertex_areas, 2)

    def gap(self, energies: Floats, error: float = 0.0) -> tuple[int, float]:
        """Return the number of Killing fields and the ratio of the energies across the largest relative gap.

        The number is 0 if the ratio is below 10, or the energies below the gap are too large for errors of this mesh.
        A connected surface has at most three such fields, so gaps beyond three for each component do not count.
        ``error``: a further error of the energies, times area.
        """
        area = float(self.surface.face_areas.sum())
        scaled = np.maximum(energies * area, ROUNDING)
        last = self.most
        ratios = scaled[1 : last + 1] / scaled[:last][: len(scaled) - 1]
        if not len(ratios):
            return 0, 1.0
        best = int(np.argmax(ratios))
        small = scaled[best] <= error + RESOLVED * self.surface.mean_edge_length**2 / area
        return (best + 1 if small and ratios[best] >= CLEAR else 0), float(ratios[best])


def _connection(surface: PolyhedralSurface) -> Connection:
    """The connection that is exact on a flat metric, else the more accurate one."""
    if not isinstance(surface, TriangleMesh):
        return "intrinsic"
    return "intrinsic" if surface.is_edge_manifold and np.abs(angle_defects(surface)).max() <= FLAT else "normals"
