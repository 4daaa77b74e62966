"""Tangent fields nearest to isometries, in all fields or some, as face fields with a report."""

from typing import Any, get_args

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.errors import ArgumentError
from geomhw.flow.field_derivatives import FieldDerivatives
from geomhw.flow.helmholtz import HelmholtzDecomposition
from geomhw.flow.tangent_fields import energy
from geomhw.intrinsic.intrinsic_mesh import IntrinsicMesh
from geomhw.mesh.cut import cut_at_pinched_vertices
from geomhw.mesh.orientation import oriented
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.curl import quarter_turn
from geomhw.operators.edge_directions import plane_frames
from geomhw.operators.gradient import hat_gradients
from geomhw.options import Connection, FieldBasis, FieldBoundary
from geomhw.results import Field, Result
from geomhw.spectral.field_symmetry import commuting_fields
from geomhw.spectral.killing_problem import KillingFields
from geomhw.spectral.laplacian_spectrum import harmonic_fields, stream_functions
from geomhw.wording import counted

#: Fields among which those that commute with a map are searched, at most, over those wanted.
MOST_SEARCHED = 32
#: Eigenfields that the coexact basis takes, by default, and the error of their energies, times area: gradients of
#: piecewise linear functions have a strain of order 1 at the scale of the faces.
EIGENFIELDS, TRUNCATION = 60, 0.5


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
    if basis == "coexact" or vertex_map is not None:
        connection = "normals"
    problem = KillingFields(surface or mesh, boundary, connection)
    wanted, sign = max(k, problem.most + 1), 1.0 if antisymmetric is None else -1.0
    if basis == "coexact":
        energies, faces = _of_coexact_fields(mesh, problem, eigenfields, vertex_map, sign)
    elif vertex_map is not None:
        energies, faces = _that_commute(mesh, problem, wanted, vertex_map, sign)
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


def _that_commute(
    mesh: TriangleMesh, problem: KillingFields, wanted: int, vertex_map: Ints, sign: float
) -> tuple[Floats, Floats]:
    """Energies, ascending, and face fields, (d, m, 3), that commute with a map, among those of least energy.

    The number of these is doubled until enough of them commute.
    """
    assert problem.fit is not None
    unknowns = problem.unknowns.shape[1]
    count, most = min(4 * wanted, unknowns), min(MOST_SEARCHED * wanted, unknowns)
    while True:
        z = problem.pairs(count).vectors
        turns = commuting_fields(mesh, problem.fit, vertex_map, z, sign)
        if turns.shape[1] >= wanted or count >= most:
            break
        count = min(2 * count, most)
    kept = np.asarray(z @ turns, dtype=complex)
    values, further = problem.stationary(kept)
    return values, problem.on_faces(np.asarray(kept @ further, dtype=complex))


def _of_coexact_fields(
    mesh: TriangleMesh, problem: KillingFields, count: int, vertex_map: Ints | None, sign: float
) -> tuple[Floats, Floats]:
    """Energies, ascending, and face fields, (d, m, 3), in the space of coexact and harmonic fields."""
    assert problem.fit is not None
    faces, derivatives = _coexact_fields(mesh, count), FieldDerivatives(mesh)
    at_vertices = np.array([derivatives.at_vertices(V) for V in faces]).reshape(-1, mesh.n_vertices, 3)
    parts = np.einsum("iax,dix->aid", plane_frames(mesh, problem.fit.normals), at_vertices)
    z, turns = parts[0] + 1j * parts[1], np.eye(len(faces))
    if vertex_map is not None:
        turns = commuting_fields(mesh, problem.fit, vertex_map, z, sign)
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
