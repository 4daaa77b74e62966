"""Helmholtz-Hodge decomposition of a face field into curl-free, divergence-free and harmonic parts.

V = ∇ζ + n x ∇ψ + H with ζ linear between vertices and ψ between edge midpoints, so that H has exactly two dimensions a
handle: Polthier, Preuss: Identifying vector field singularities using a discrete Hodge decomposition, 2003.
"""

from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp

from geomhw.arrays import Floats, Ints
from geomhw.flow.tangent_fields import energy, tangential
from geomhw.mesh.geometry import corner_sum
from geomhw.mesh.orientation import oriented
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.crouzeix_raviart import edge_components, edge_gradient, edges_to_vertices, loop_edges
from geomhw.operators.divergence import divergence
from geomhw.operators.gradient import gradient
from geomhw.operators.laplacian import stiffness
from geomhw.results import Field, Result
from geomhw.solvers.direct import DirectSolver
from geomhw.solvers.nullspace import balanced, free_unknowns


class HelmholtzDecomposition:
    """Decomposes fields on one mesh: each part is factored on first use, then answers any field.

    On a mesh with boundary, the curl-free part takes all flux through it: the rest flows along the boundary, with ψ
    constant on each loop. Faces that disagree on what is up are taken as `oriented`, which only the sign of ψ knows of.
    MeshError if a face has no area, an edge more than two faces, or the surface one side only.
    """

    def __init__(self, mesh: TriangleMesh) -> None:
        mesh.require_area()
        self._given, self.mesh = mesh, oriented(mesh)
        self.mesh.require_oriented("the decomposition")
        mesh = self.mesh
        self._gradient = gradient(mesh)
        self._divergence = divergence(mesh)

    @cached_property
    def _potential_solver(self) -> DirectSolver:
        mesh = self.mesh
        return DirectSolver(stiffness(mesh), free_unknowns(mesh.components, mesh.unreferenced_vertices))

    @cached_property
    def _stream(self) -> "_StreamSystem":
        return _StreamSystem(self.mesh)

    def potential(self, field: Floats) -> Floats:
        """ζ, (n,), units of V times length: Sζ = -Div V, zero mean on each component; ∇ζ is the curl-free part of V."""
        zeta = self._potential_solver(balanced(-(self._divergence @ field.ravel()), self.mesh.components))
        return _centered(zeta, self.mesh.vertex_areas, self.mesh.components)

    def coexact(self, field: Floats) -> tuple[Floats, Floats]:
        """ψ at edge midpoints, (e,), units of V times length, and n x ∇ψ, (m, 3), the closest such field to V."""
        return self._stream(field)

    def project(self, field: Floats) -> Floats:
        """The divergence-free rest V - ∇ζ of a tangent field, (m, 3): the pressure projection."""
        return np.asarray(field - self.gradient_of(self.potential(field)))

    def gradient_of(self, values: Floats) -> Floats:
        """∇u per face, (m, 3)."""
        return np.asarray((self._gradient @ values).reshape(-1, 3))

    def __call__(self, field: Floats) -> Result:
        """Decompose the tangential part of a face field, (m, 3).

        Fields, per face: ``field`` (the tangential part, which the others add up to), ``curl_free`` ∇ζ,
        ``divergence_free`` (= ``coexact`` + ``harmonic``), ``coexact`` n x ∇ψ, ``harmonic``. Per vertex: ``potential``
        ζ and ``stream_function`` ψ, averaged from the edge midpoints. The report has each part's share of the energy,
        the integral of |V|².
        """
        mesh = self.mesh
        V = tangential(mesh, field)
        zeta = self.potential(V)
        psi, coexact = self.coexact(V)
        curl_free = self.gradient_of(zeta)
        rest = V - curl_free
        harmonic = rest - coexact
        fields = [
            Field("field", "face", V),
            Field("curl_free", "face", curl_free),
            Field("divergence_free", "face", rest),
            Field("coexact", "face", coexact),
            Field("harmonic", "face", harmonic),
            Field("potential", "vertex", zeta),
            Field("stream_function", "vertex", edges_to_vertices(mesh, psi)),
        ]
        return Result(self._given, fields, self._report(np.asarray(field), V, fields[1:5]))

    def _report(self, given: Floats, V: Floats, parts: list[Field]) -> dict[str, Any]:
        total, kept = energy(self.mesh, given), energy(self.mesh, V)
        shares = {part.name: energy(self.mesh, np.asarray(part.values)) / kept if kept else 0.0 for part in parts}
        return {
            "energy": kept,
            "energy_shares": shares,
            "normal_part_removed": (total - kept) / total if total else 0.0,
        }


def _centered(values: Floats, weights: Floats, labels: Ints) -> Floats:
    """Less the weighted mean over each label; unchanged where a label has no weight."""
    totals = np.bincount(labels, weights=weights)
    sums = np.bincount(labels, weights=weights * values)
    means = np.divide(sums, totals, out=np.zeros_like(sums), where=totals > 0)
    return np.asarray(values - means[labels])


class _StreamSystem:
    """Least-squares fit of n x ∇ψ to a field, ψ at edge midpoints, one unknown a boundary loop."""

    def __init__(self, mesh: TriangleMesh) -> None:
        self._mesh = mesh
        self._labels = edge_components(mesh)
        group = np.arange(mesh.n_edges)
        for edges in loop_edges(mesh):
            group[edges] = edges[0]
        first, unknown = np.unique(group, return_index=True, return_inverse=True)[1:]
        every = np.arange(mesh.n_edges)
        self._collapse = sp.csr_array((np.ones(mesh.n_edges), (every, unknown)), shape=(mesh.n_edges, len(first)))
        self._gradient = edge_gradient(mesh) @ self._collapse
        self._weighted = (self._gradient.T * np.repeat(mesh.face_areas, 3)).tocsr()
        self._unknown_labels = self._labels[first]
        nothing = np.empty(0, dtype=int)
        self._solver = DirectSolver(
            (self._weighted @ self._gradient).tocsr(), free_unknowns(self._unknown_labels, nothing)
        )

    def __call__(self, field: Floats) -> tuple[Floats, Floats]:
        normals = self._mesh.face_normals
        rhs = -(self._weighted @ np.cross(normals, field).ravel())
        solution = self._solver(balanced(rhs, self._unknown_labels))
        coexact = np.cross(normals, (self._gradient @ solution).reshape(-1, 3))
        edge_areas = corner_sum(self._mesh.face_areas / 3, self._mesh.edge_table.of_faces, self._mesh.n_edges)
        return _centered(self._collapse @ solution, edge_areas, self._labels), coexact
