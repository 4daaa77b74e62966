"""Tangent fields nearest to isometries: the smallest eigenpairs of the deformation energy."""

from typing import Any, get_args

import numpy as np
import scipy.sparse as sp

from geomhw.arrays import Complexes, Floats, Ints
from geomhw.errors import ArgumentError
from geomhw.flow.field_derivatives import FieldDerivatives
from geomhw.flow.helmholtz import HelmholtzDecomposition
from geomhw.flow.tangent_fields import energy
from geomhw.intrinsic.intrinsic_mesh import IntrinsicMesh
from geomhw.mesh.curvature import angle_defects
from geomhw.mesh.cut import cut_at_pinched_vertices
from geomhw.mesh.orientation import oriented
from geomhw.mesh.polyhedral import PolyhedralSurface
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.curl import quarter_turn
from geomhw.operators.deformation_energy import deformation_energy, field_unknowns
from geomhw.operators.edge_directions import carried_to_faces, edge_ends, plane_frames
from geomhw.operators.gradient import hat_gradients
from geomhw.operators.local_fit import LocalFit
from geomhw.options import Connection, FieldBasis, FieldBoundary
from geomhw.results import Field, Result
from geomhw.spectral.eigenpairs import Eigenpairs, smallest_eigenpairs
from geomhw.spectral.field_symmetry import commuting_fields, independent, real_parts
from geomhw.spectral.laplacian_spectrum import harmonic_fields, stream_functions
from geomhw.wording import counted

#: Angle defects below this, in radians, are errors of coordinates with six digits: the metric is flat.
FLAT = 1e-5
#: Energies times area below this are rounding.
ROUNDING = 1e-10
#: Least ratio of neighboring energies that is a gap, and largest energy, times area, of a Killing field, in h²/area.
CLEAR, RESOLVED = 10.0, 100.0
#: A connected surface has at most three independent Killing fields; gaps of so many components are looked for.
MOST_FIELDS, MOST_COMPONENTS = 3, 20
#: Fields among which those that commute with a map are searched, at most, over those wanted.
MOST_SEARCHED = 32
#: Eigenfields that the coexact basis takes, by default, and the error of their energies, times area: gradients of
#: piecewise linear functions have a strain of order 1 at the scale of the faces.
EIGENFIELDS, TRUNCATION = 60, 0.5


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
        last = MOST_FIELDS * min(self.surface.n_components, MOST_COMPONENTS)
        ratios = scaled[1 : last + 1] / scaled[:last][: len(scaled) - 1]
        if not len(ratios):
            return 0, 1.0
        best = int(np.argmax(ratios))
        small = scaled[best] <= error + RESOLVED * self.surface.mean_edge_length**2 / area
        return (best + 1 if small and ratios[best] >= CLEAR else 0), float(ratios[best])


def killing_fields(
    mesh: TriangleMesh,
    k: int = 6,
    boundary: FieldBoundary = "tangent",
    connection: Connection | None = None,
    basis: FieldBasis = "vertices",
    eigenfields: int = EIGENFIELDS,
    symmetric: Ints | None = None,
    antisymmetric: Ints | None = None,
    surface: IntrinsicMesh | None = None,
) -> Result:
    """Compute the tangent fields nearest to isometries, in order of their deformation energy.

    Parameters
    ----------
    mesh : an oriented manifold. It is cut open at pinched vertices.
    k : number of fields.
    boundary, connection : as in `KillingFields`.
    basis : ``vertices``, all fields that are given by a vector at each vertex; ``coexact``, combinations of
        ``eigenfields`` coexact fields n x ∇ψ and all harmonic ones. Killing fields are divergence-free and tangent to
        the boundary, and these fields span all such.
    symmetric, antisymmetric : a vertex map, (n,). Only fields whose operator commutes, or anticommutes, with it.
    surface : other edge lengths for the faces of the mesh, such as a flat metric.

    Returns
    -------
    Result
        Fields ``killing_0`` ..., per face, (m, 3), unit 1/length, with ∫|V|² = 1. Report: ``energies``, ascending, unit
        1/length²; ``relative_strains``, the root of energy times area, dimensionless; ``gap``: ``fields``
        and ``ratio`` as in `KillingFields.gap`; ``shares`` of the gradient, coexact and harmonic part of each field.

    Raises
    ------
    ArgumentError
        If options are unknown or exclude each other, or there are fewer than k fields.
    MeshError
        As `KillingFields`.

    Examples
    --------
    >>> from geomhw.mesh import torus
    >>> killing_fields(torus(24, 12), 3).report["gap"]["fields"]
    1
    """
    if basis not in get_args(FieldBasis):
        raise ArgumentError(f"there is no basis '{basis}'; choose from {', '.join(get_args(FieldBasis))}")
    if basis == "coexact" and (surface is not None or boundary == "free" or connection == "intrinsic"):
        raise ArgumentError("the coexact basis needs coordinates, the connection of normals and a tangent boundary")
    given, mesh = mesh, oriented(mesh)
    if surface is None:
        mesh = cut_at_pinched_vertices(mesh)[0]
    vertex_map = symmetric if symmetric is not None else antisymmetric
    if symmetric is not None and antisymmetric is not None:
        raise ArgumentError("fields are symmetric or antisymmetric, not both")
    if vertex_map is not None and (
        surface is not None or connection == "intrinsic" or mesh.n_vertices != given.n_vertices
    ):
        raise ArgumentError("a symmetry needs coordinates, the connection of normals and no pinched vertices")
    if special := basis == "coexact" or vertex_map is not None:
        connection = "normals"
    problem = KillingFields(surface or mesh, boundary, connection)
    wanted = max(k, MOST_FIELDS * min(mesh.n_components, MOST_COMPONENTS) + 1)
    if special:
        sign = 1.0 if antisymmetric is None else -1.0
        count = eigenfields if basis == "coexact" else 0
        energies, faces = _restricted(mesh, problem, wanted, count, vertex_map, sign)
    else:
        if k > (size := problem.unknowns.shape[1]):
            raise ArgumentError(f"this mesh has {counted(size, 'independent field')}; {k} cannot be computed")
        pairs = problem.pairs(min(wanted, size))
        energies, faces = pairs.values, problem.on_faces(pairs.vectors[:, :k])
    if len(faces) < k:
        found = counted(len(faces), "such field")
        raise ArgumentError(f"{found} found among those of least energy, not {k}; ask for fewer")
    count, ratio = problem.gap(energies, TRUNCATION if basis == "coexact" else 0.0)
    fields = [_onto(mesh, surface, V) if surface is not None else V for V in faces[:k]]
    fields = [V / np.sqrt(energy(mesh, V)) for V in fields]
    report: dict[str, Any] = {
        "energies": energies[:k].tolist(),
        "relative_strains": np.sqrt(energies[:k] * problem.surface.face_areas.sum()).tolist(),
        "gap": {"fields": count, "ratio": ratio},
        "boundary": boundary,
        "connection": problem.connection,
        "basis": basis,
    }
    if surface is None:
        report["shares"] = _shares(mesh, fields)
    return Result(given, [Field(f"killing_{i}", "face", V) for i, V in enumerate(fields)], report)


def _connection(surface: PolyhedralSurface) -> Connection:
    """The connection that is exact on a flat metric, else the more accurate one."""
    if not isinstance(surface, TriangleMesh):
        return "intrinsic"
    return "intrinsic" if surface.is_edge_manifold and np.abs(angle_defects(surface)).max() <= FLAT else "normals"


def _restricted(
    mesh: TriangleMesh,
    problem: KillingFields,
    wanted: int,
    eigenfields: int,
    vertex_map: Ints | None,
    sign: float,
) -> tuple[Floats, Floats]:
    """Energies, ascending, and face fields, (d, m, 3), that commute with a map, of coexact fields or of all.

    Of all fields those of least energy are searched, until enough of them commute.
    """
    assert problem.fit is not None
    unknowns = problem.unknowns.shape[1]
    count = min(4 * wanted, unknowns)
    while True:
        if eigenfields:
            faces = _coexact_fields(mesh, eigenfields)
            frames, derivatives = plane_frames(mesh, problem.fit.normals), FieldDerivatives(mesh)
            at_vertices = np.array([derivatives.at_vertices(V) for V in faces]).reshape(-1, mesh.n_vertices, 3)
            parts = np.einsum("iax,dix->aid", frames, at_vertices)
            z = parts[0] + 1j * parts[1]
        else:
            z = problem.pairs(count).vectors
            faces = problem.on_faces(z)
        turns = np.eye(z.shape[1])
        if vertex_map is not None:
            turns = commuting_fields(mesh, problem.fit, vertex_map, z, sign)
        if eigenfields or turns.shape[1] >= wanted or count >= min(unknowns, MOST_SEARCHED * wanted):
            break
        count = min(2 * count, unknowns)
    values, further = problem.stationary(z @ turns)
    return values, np.einsum("dfx,de->efx", faces, turns @ further)


def _coexact_fields(mesh: TriangleMesh, count: int) -> Floats:
    """Coexact eigenfields of the Hodge Laplacian and harmonic fields, (d, m, 3), orthonormal."""
    inner = mesh.n_vertices - len(np.union1d(mesh.boundary_vertices, mesh.unreferenced_vertices))
    pairs, G = stream_functions(mesh, min(count, max(inner - 1, 0)))
    fields = (G @ pairs.vectors / np.sqrt(pairs.values)).T.reshape(-1, mesh.n_faces, 3)
    return np.concatenate([quarter_turn(mesh, fields), harmonic_fields(mesh)])


def _onto(mesh: TriangleMesh, surface: IntrinsicMesh, field: Floats) -> Floats:
    """Vectors on the faces of a mesh, (m, 3), with the same change of barycentric coordinates as on other lengths."""
    change = np.einsum("fkx,fx->fk", hat_gradients(surface), field)
    return np.asarray(np.einsum("fk,fkx->fx", change, mesh.vertices[mesh.faces]))


def _shares(mesh: TriangleMesh, fields: list[Floats]) -> dict[str, list[float]]:
    """Shares of the gradient, coexact and harmonic part in the square integral of each field."""
    decomposition = HelmholtzDecomposition(mesh)
    shares = [decomposition(V).report["energy_shares"] for V in fields]
    names = {"gradient": "curl_free", "coexact": "coexact", "harmonic": "harmonic"}
    return {name: [float(item[part]) for item in shares] for name, part in names.items()}
