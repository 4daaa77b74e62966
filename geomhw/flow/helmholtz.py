"""Helmholtz-Hodge decomposition of a face field into curl-free, coexact and harmonic parts.

V = ∇ζ + n x ∇ψ + H with ζ linear between vertices and ψ linear between edge midpoints (Crouzeix-Raviart), so that the
harmonic fields H have exactly two dimensions a handle.
"""

from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp

from geomhw.arrays import Floats, dot
from geomhw.errors import ConvergenceError
from geomhw.flow.tangent_fields import energy, tangential
from geomhw.mesh.cut import cut_at_pinched_vertices
from geomhw.mesh.geometry import corner_sum
from geomhw.mesh.orientation import oriented
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.crouzeix_raviart import (
    boundary_loop_edges,
    crouzeix_raviart_gradient,
    edge_components,
    edges_to_vertices,
)
from geomhw.operators.curl import curl_of, quarter_turn
from geomhw.operators.divergence import divergence
from geomhw.operators.gradient import gradient
from geomhw.operators.laplacian import stiffness
from geomhw.results import Field, Result
from geomhw.solvers.direct import DirectSolver
from geomhw.solvers.nullspace import free_unknowns, without_mean

#: Largest inner product of a part and the rest of the field, as a share of the energy; and most solves to reach it.
ORTHOGONAL = 1e-11
MOST_REFINEMENTS = 20


class HelmholtzDecomposition:
    """Decompose face fields on one mesh; each Laplacian is factored on first use.

    On a mesh with boundary, the curl-free part takes all flux through it. The rest flows along the boundary, with ψ
    constant on each boundary loop.

    Parameters
    ----------
    mesh : need not be consistently oriented: the faces are oriented first, which affects the sign of ψ only. It is cut
        open at pinched vertices, so that the parts do not depend on the numbering of vertices and faces.

    Attributes
    ----------
    mesh : the mesh that is decomposed, oriented and cut open, with n' vertices.

    Raises
    ------
    MeshError
        If a face has zero area, an edge has more than two faces, or the surface is not orientable.
    ConvergenceError
        If the faces are so thin that rounding spoils the parts.

    References
    ----------
    Polthier, Preuss: Identifying vector field singularities using a discrete Hodge decomposition, 2003.

    Examples
    --------
    A rigid rotation of the sphere is a turned gradient.

    >>> import numpy as np
    >>> from geomhw.mesh import icosphere
    >>> mesh = icosphere(3)
    >>> parts = HelmholtzDecomposition(mesh)(np.cross([0, 0, 1], mesh.face_centers))
    >>> parts.report["energy_shares"]["coexact"] > 0.999
    True
    """

    def __init__(self, mesh: TriangleMesh) -> None:
        mesh.require_area()
        self._given = mesh
        self.mesh, self._original = cut_at_pinched_vertices(oriented(mesh))
        self.mesh.require_oriented("the decomposition")
        self._gradient, self._divergence = gradient(self.mesh), divergence(self.mesh)

    def __call__(self, field: Floats) -> Result:
        """Decompose the tangential part of a face field, (m, 3).

        Returns
        -------
        Result. Per face: ``field`` (the tangential part, the sum of the others), ``curl_free`` ∇ζ, ``divergence_free``
        (= ``coexact`` + ``harmonic``), ``coexact`` n x ∇ψ, ``harmonic``. Per vertex: ``potential`` ζ and
        ``stream_function`` ψ, averaged from the edge midpoints; at a pinched vertex, the mean over its copies. The
        report has each part's share of the energy, the integral of |V|², and the number of pinched vertices.
        """
        V = tangential(self.mesh, field)
        zeta, curl_free = self._closest(self._gradient_part, V)
        divergence_free = V - curl_free
        psi, coexact = self._closest(self.coexact, V)
        harmonic = divergence_free - coexact
        parts = {"curl_free": curl_free, "divergence_free": divergence_free, "coexact": coexact, "harmonic": harmonic}
        functions = {"potential": zeta, "stream_function": edges_to_vertices(self.mesh, psi)}
        fields = [Field(name, "face", values) for name, values in ({"field": V} | parts).items()]
        fields += [Field(name, "vertex", self._at_given(values)) for name, values in functions.items()]
        report = _energy_report(self.mesh, np.asarray(field), V, parts)
        if pinched := len(np.unique(self._original[self._given.n_vertices :])):
            report["pinched_vertices"] = pinched
        return Result(self._given, fields, report)

    def _gradient_part(self, field: Floats) -> tuple[Floats, Floats]:
        """Return ζ, (n',), and ∇ζ, (m, 3), the closest to V."""
        zeta = self.potential(field)
        return zeta, self.gradient_of(zeta)

    def _closest(self, solve: Callable[[Floats], tuple[Floats, Floats]], V: Floats) -> tuple[Floats, Floats]:
        """Refine a function and its field until the field is orthogonal to the rest of V: on slivers rounding grows."""
        function, part = solve(V)
        areas, total = self.mesh.face_areas, energy(self.mesh, V)
        for _ in range(MOST_REFINEMENTS):
            if not abs(dot(areas, np.einsum("fx,fx->f", part, V - part))) > ORTHOGONAL * total:
                return function, part
            more, correction = solve(V - part)
            function, part = function + more, part + correction
        raise ConvergenceError("the parts do not become orthogonal: slivers of the mesh are too thin; remove them")

    def _at_given(self, values: Floats) -> Floats:
        """Mean over the copies of each vertex of the given mesh, (n,), of values, (n',)."""
        return np.asarray(np.bincount(self._original, values) / np.bincount(self._original))

    def potential(self, field: Floats) -> Floats:
        """Solve Sζ = -Div V for ζ, (n',), units of V times length, with zero mean on each component."""
        components = self.mesh.components
        zeta = self._potential_solver(without_mean(-(self._divergence @ field.ravel()), components))
        return without_mean(zeta, components, self.mesh.vertex_areas)

    def coexact(self, field: Floats) -> tuple[Floats, Floats]:
        """Return ψ at edge midpoints, (e,), units of V times length, and n x ∇ψ, (m, 3), the closest to V."""
        return self._stream_function(field)

    def project(self, field: Floats) -> Floats:
        """Return the divergence-free part V - ∇ζ of a tangent field, (m, 3): the pressure projection."""
        return np.asarray(field - self.gradient_of(self.potential(field)))

    def gradient_of(self, values: Floats) -> Floats:
        """Return ∇u per face, (m, 3), for u, (n',)."""
        return np.asarray((self._gradient @ values).reshape(-1, 3))

    @cached_property
    def _potential_solver(self) -> DirectSolver:
        mesh = self.mesh
        return DirectSolver(stiffness(mesh), free_unknowns(mesh.components, mesh.unreferenced_vertices))

    @cached_property
    def _stream_function(self) -> "_EdgeStreamFunction":
        return _EdgeStreamFunction(self.mesh)


class _EdgeStreamFunction:
    """Least-squares fit of n x ∇ψ to a field, ψ at edge midpoints and constant on each boundary loop."""

    def __init__(self, mesh: TriangleMesh) -> None:
        self._mesh, self._components = mesh, edge_components(mesh)
        group = np.arange(mesh.n_edges)
        for edges in boundary_loop_edges(mesh):
            group[edges] = edges[0]
        first, unknown = np.unique(group, return_index=True, return_inverse=True)[1:]
        entries = (np.ones(mesh.n_edges), (np.arange(mesh.n_edges), unknown))
        self._prolongation = sp.csr_array(entries, shape=(mesh.n_edges, len(first)))
        self._unknown_components = self._components[first]
        self._gradient = crouzeix_raviart_gradient(mesh) @ self._prolongation
        self._divergence = (self._gradient.T * -np.repeat(mesh.face_areas, 3)).tocsr()
        S = -(self._divergence @ self._gradient).tocsr()
        self._solver = DirectSolver(S, free_unknowns(self._unknown_components, np.empty(0, dtype=int)))

    def __call__(self, field: Floats) -> tuple[Floats, Floats]:
        """Solve Sψ = -Curl V: ψ, (e,), with zero mean on each component, and n x ∇ψ, (m, 3)."""
        mesh = self._mesh
        circulation = curl_of(mesh, field, self._divergence)
        psi = self._solver(without_mean(-circulation, self._unknown_components))
        turned = quarter_turn(mesh, (self._gradient @ psi).reshape(-1, 3))
        edge_areas = corner_sum(mesh.face_areas / 3, mesh.edge_table.of_faces, mesh.n_edges)
        return without_mean(self._prolongation @ psi, self._components, edge_areas), turned


def _energy_report(mesh: TriangleMesh, given: Floats, V: Floats, parts: dict[str, Floats]) -> dict[str, Any]:
    """Energy of the tangential field, the share of each part, and the share of the normal part that was removed."""
    total, kept = energy(mesh, given), energy(mesh, V)
    shares = {name: energy(mesh, part) / kept if kept else 0.0 for name, part in parts.items()}
    removed = (total - kept) / total if total else 0.0
    return {"energy": kept, "energy_shares": shares, "normal_part_removed": removed}
