"""Spectra of the Laplacian on functions, the connection Laplacian on vectors, the Hodge Laplacian on fields."""

from typing import Any, get_args

import numpy as np
import scipy.sparse as sp

from geomhw.arrays import Floats
from geomhw.errors import ArgumentError, MeshError
from geomhw.flow.harmonic import harmonic_basis, orthonormal
from geomhw.mesh.cut import cut_at_pinched_vertices
from geomhw.mesh.polyhedral import PolyhedralSurface
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.connection_laplacian import complex_connection_stiffness
from geomhw.operators.crouzeix_raviart import crouzeix_raviart_gradient
from geomhw.operators.curl import quarter_turn
from geomhw.operators.gradient import gradient
from geomhw.operators.laplacian import stiffness
from geomhw.operators.mass import lumped_mass
from geomhw.operators.mass import mean_mass as mean_mass
from geomhw.operators.parallel_transport import from_complex
from geomhw.options import Connection, EndCondition
from geomhw.results import Field, Result
from geomhw.solvers.direct import DirectSolver
from geomhw.spectral.eigenpairs import Eigenpairs, smallest_eigenpairs


def laplacian_spectrum(
    mesh: TriangleMesh, k: int, boundary: EndCondition = "neumann", surface: PolyhedralSurface | None = None
) -> Result:
    """Compute the smallest eigenpairs of the Laplacian on functions, -Δφ = λφ.

    Parameters
    ----------
    mesh : the mesh.
    k : number of pairs.
    boundary : ``neumann``, no flux through the boundary, or ``dirichlet``, φ = 0 there.
    surface : a triangulation of the same vertices to assemble on, such as the intrinsic Delaunay one.

    Returns
    -------
    Result
        Fields ``eigenfunction_0`` ..., per vertex, unit 1/length, with ∫φ² = 1; report ``eigenvalues``, ascending, unit
        1/length², and ``residuals``, as in `Eigenpairs`. Functions are zero at vertices without faces.

    Raises
    ------
    ArgumentError
        If k exceeds the number of free vertices, or the boundary condition is unknown.
    MeshError
        If a face has zero area.

    Examples
    --------
    >>> from geomhw.mesh import icosphere
    >>> laplacian_spectrum(icosphere(3), 4).report["eigenvalues"][1].__round__(2)
    2.01
    """
    if boundary not in get_args(EndCondition):
        choices = ", ".join(get_args(EndCondition))
        raise ArgumentError(f"there is no boundary condition '{boundary}'; choose from {choices}")
    free = _inner(mesh)
    free[mesh.boundary_vertices] = boundary == "neumann"
    S, M = stiffness(surface or mesh), mean_mass(surface or mesh)
    pairs = smallest_eigenpairs(S[free][:, free], M[free][:, free], k)
    functions = np.zeros((mesh.n_vertices, k))
    functions[free] = pairs.vectors
    return _result(mesh, pairs, "vertex", list(functions.T), {"boundary": boundary})


def connection_spectrum(mesh: TriangleMesh, k: int, connection: Connection = "normals") -> Result:
    """Compute the smallest eigenpairs of the connection Laplacian on tangent vectors at vertices.

    Each pair is one of complex numbers in the tangent planes: it stands for a field and its quarter turn, which have
    the same eigenvalue.

    Parameters
    ----------
    mesh : an oriented mesh.
    k : number of pairs.
    connection : as in `geomhw.operators.edge_transport`.

    Returns
    -------
    Result
        Fields ``eigenfunction_0`` ..., per vertex, (n, 3), tangential, unit 1/length, with ∫|V|² = 1; report as in
        `laplacian_spectrum`.

    Raises
    ------
    ArgumentError
        If k exceeds the number of vertices.
    MeshError
        As `geomhw.operators.complex_connection_stiffness`; for ``normals``, if the faces round a vertex cancel.
    """
    used = np.ones(mesh.n_vertices, dtype=bool)
    used[mesh.unreferenced_vertices] = False
    if connection == "normals" and len(bare := mesh.vertices_without_normal):
        raise MeshError(f"vertex {bare[0]} has no normal: the faces round it cancel; move it, or cut the mesh there")
    K, M = complex_connection_stiffness(mesh, connection), lumped_mass(mesh)
    pairs = smallest_eigenpairs(K[used][:, used], M[used][:, used], k)
    z = np.zeros((mesh.n_vertices, k), dtype=complex)
    z[used] = pairs.vectors
    return _result(mesh, pairs, "vertex", [from_complex(mesh, column) for column in z.T], {"connection": connection})


def hodge_spectrum(mesh: TriangleMesh, k: int) -> Result:
    """Compute the smallest eigenpairs of the Hodge Laplacian on tangent fields, curl curl - grad div.

    The eigenfields are gradients of Crouzeix-Raviart eigenfunctions, turned gradients n x ∇ψ of eigenfunctions ψ at
    vertices that are zero on the boundary, and harmonic fields, with eigenvalue zero. These three kinds are orthogonal
    to each other. No field crosses the boundary.

    Parameters
    ----------
    mesh : an oriented manifold. It is cut open at pinched vertices.
    k : number of pairs.

    Returns
    -------
    Result
        Fields ``eigenfunction_0`` ..., per face, (m, 3), unit 1/length, with ∫|V|² = 1; report as in
        `laplacian_spectrum`, with ``kinds``: ``gradient``, ``coexact`` or ``harmonic``.

    Raises
    ------
    ArgumentError
        If k exceeds the number of eigenfields.
    MeshError
        If the mesh is not an oriented manifold, or a face has zero area.

    References
    ----------
    Wardetzky: Discrete Differential Operators on Polyhedral Surfaces. PhD thesis, FU Berlin, 2006.
    """
    given, mesh = mesh, cut_at_pinched_vertices(mesh)[0]
    fields = list(harmonic_fields(mesh))
    kinds, values, residuals = ["harmonic"] * len(fields), [0.0] * len(fields), [0.0] * len(fields)
    for kind, pairs, G in (("gradient", *_potentials(mesh, k)), ("coexact", *stream_functions(mesh, k))):
        for value, residual, function in zip(pairs.values, pairs.residuals, pairs.vectors.T, strict=True):
            field = (G @ function).reshape(-1, 3) / np.sqrt(value)
            kinds.append(kind)
            values.append(value)
            residuals.append(residual)
            fields.append(quarter_turn(mesh, field) if kind == "coexact" else field)
    order = np.argsort(values, kind="stable")[:k]
    if len(order) < k:
        raise ArgumentError(f"there are {len(order)} eigenfields; {k} cannot be computed")
    pairs = Eigenpairs(np.array(values)[order], np.empty((0, k)), np.array(residuals)[order])
    return _result(given, pairs, "face", [fields[i] for i in order], {"kinds": [kinds[i] for i in order]})


def _potentials(mesh: TriangleMesh, k: int) -> tuple[Eigenpairs, sp.csr_array]:
    """Eigenpairs of Crouzeix-Raviart functions without the constants on components, and their gradient."""
    G = crouzeix_raviart_gradient(mesh)
    A = sp.csr_array(G.T @ sp.diags_array(np.repeat(mesh.face_areas, 3)) @ G)
    thirds = np.bincount(mesh.edge_table.of_faces.ravel(), np.repeat(mesh.face_areas / 3, 3), mesh.n_edges)
    constants = len(np.unique(mesh.components[mesh.faces[:, 0]]))
    pairs = smallest_eigenpairs(A, sp.diags_array(thirds, format="csr"), min(k + constants, mesh.n_edges))
    rest = slice(constants, None)
    return Eigenpairs(pairs.values[rest], pairs.vectors[:, rest], pairs.residuals[rest]), G


def stream_functions(mesh: TriangleMesh, k: int) -> tuple[Eigenpairs, sp.csr_array]:
    """Eigenpairs of functions at vertices that are zero on the boundary, without constants, and their gradient."""
    free = _inner(mesh)
    closed = np.setdiff1d(mesh.components[mesh.faces[:, 0]], mesh.components[mesh.boundary_vertices])
    wanted = min(k + len(closed), int(free.sum()))
    if not wanted:
        return Eigenpairs(np.empty(0), np.empty((0, 0)), np.empty(0)), sp.csr_array((3 * mesh.n_faces, 0))
    pairs = smallest_eigenpairs(stiffness(mesh)[free][:, free], mean_mass(mesh)[free][:, free], wanted)
    rest = slice(len(closed), None)
    return Eigenpairs(pairs.values[rest], pairs.vectors[:, rest], pairs.residuals[rest]), gradient(mesh)[:, free]


def harmonic_fields(mesh: TriangleMesh) -> Floats:
    """An orthonormal basis, (2g + b - c, m, 3): two fields a handle, and one for each loop after a component's first.

    The latter is n x ∇ψ for the harmonic function ψ that is 1 on the loop and 0 on the others.
    """
    component = [mesh.components[loop[0]] for loop in mesh.boundary_loops]
    later = [k for k in range(len(component)) if component[k] in component[:k]]
    psi = np.zeros((mesh.n_vertices, len(later)))
    for column, k in enumerate(later):
        psi[mesh.boundary_loops[k], column] = 1.0
    S = stiffness(mesh)
    psi -= DirectSolver(S, _inner(mesh))(S @ psi) if len(later) else 0.0
    flows = [quarter_turn(mesh, (gradient(mesh) @ column).reshape(-1, 3)) for column in psi.T]
    return orthonormal(mesh, np.concatenate([harmonic_basis(mesh), np.array(flows).reshape(-1, mesh.n_faces, 3)]))


def _inner(mesh: TriangleMesh) -> Any:
    """Mask of the vertices that have faces and are not on the boundary, (n,)."""
    inner = np.ones(mesh.n_vertices, dtype=bool)
    inner[mesh.unreferenced_vertices] = False
    inner[mesh.boundary_vertices] = False
    return inner


def _result(
    mesh: TriangleMesh, pairs: Eigenpairs, location: Any, functions: list[Floats], settings: dict[str, Any]
) -> Result:
    report = {"eigenvalues": pairs.values.tolist(), "residuals": pairs.residuals.tolist(), **settings}
    fields = [Field(f"eigenfunction_{i}", location, function) for i, function in enumerate(functions)]
    return Result(mesh, fields, report)
