"""The vorticity equation on a mesh: stream function, velocity, Jacobian and harmonic coefficients.

With q_i the integral of w φ_i: Sψ = -q, V = n x ∇ψ + Σ c_k h_k, w = B q and dq/dt = -J_V w, where h_k are the harmonic
fields, J_ij = Σ_f (A_f/3) V_f·∇φ_j, and B approximates the inverse of the consistent mass. For such V, J is
antisymmetric. It is the Jacobian of Arakawa (1966) on triangles, and M D_V of [OATVF, eq. 7]. Energy, enstrophy and
circulation are conserved for any symmetric B.
"""

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from geomhw.arrays import Floats
from geomhw.errors import ConvergenceError, FieldError
from geomhw.flow.harmonic import harmonic_basis
from geomhw.flow.mass_correction import MassCorrection
from geomhw.flow.stream_function import StreamFunctionSolver
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.curl import curl_of, quarter_turn
from geomhw.operators.directional_derivative import DirectionalDerivative, filled
from geomhw.operators.divergence import divergence
from geomhw.operators.gradient import gradient
from geomhw.operators.laplacian import backward_euler, stiffness
from geomhw.solvers.direct import DirectSolver
from geomhw.solvers.nullspace import without_mean


class VorticityModel(MassCorrection):
    """The operators of the vorticity equation on one mesh, with one factorization for all steps.

    Parameters
    ----------
    mesh : an oriented manifold of any genus, with any number of components. On each boundary loop ψ is constant: no
        flow crosses the boundary, and the circulation along it is conserved.

    Attributes
    ----------
    harmonic : (2g, m, 3) array, the orthonormal harmonic fields h_k.
    loops : the unknowns of ψ that belong to boundary loops.

    Raises
    ------
    MeshError
        If the mesh is not such a manifold, or a face has zero area.
    """

    def __init__(self, mesh: TriangleMesh) -> None:
        mesh.require_oriented("a flow")
        super().__init__(mesh)
        self._gradient, self._divergence = gradient(mesh), divergence(mesh)
        self._poisson = StreamFunctionSolver(mesh)
        self.loops = self._poisson.loops
        self.harmonic = harmonic_basis(mesh, self._poisson)
        self._derivative = DirectionalDerivative(mesh)
        self._harmonic_jacobians = np.array([self._derivative.weak(h).data for h in self.harmonic])
        self._left, self._right, self._pattern = self._jacobian_pattern()

    # -- unknowns ------------------------------------------------------------------------------------------------

    def from_velocity(self, V: Floats) -> tuple[Floats, Floats, Floats]:
        """Return q, (n,), boundary circulations, (k,), and c, (2g,), of the divergence-free part of V, (m, 3).

        At a boundary vertex the weak curl lacks the circulation along the boundary. There the vorticity is extrapolated
        from adjacent vertices; the sum of the differences over a loop is its circulation.
        """
        curl = curl_of(self.mesh, V, self._divergence)
        q = self._extrapolated_to_boundary(curl)
        c = np.einsum("gfx,fx,f->g", self.harmonic, V, self.mesh.face_areas)
        return q, self._poisson.gather(q - curl), c

    def from_vorticity(
        self, w: ArrayLike, circulations: ArrayLike | None = None, harmonic: ArrayLike | None = None
    ) -> tuple[Floats, Floats, Floats]:
        """Return q, boundary circulations and c as in `from_velocity`, from w, (n,), circulations, (l,), and c, (2g,).

        By default circulations and c are zero. The mean of w is changed on each component, so that q sums to the
        circulation along its boundary [Stokes].
        """
        values = _checked(w, len(self.areas), "a vorticity")
        along, at_vertices = np.zeros(self._poisson.n_unknowns), np.zeros_like(values)
        along[self.loops] = _checked(circulations, len(self.loops), "the circulation along boundary loops")
        at_vertices[np.unique(self._poisson.unknown_of, return_index=True)[1]] = along
        q = self.without_mean(self._mass @ values - at_vertices) + at_vertices
        return q, along, _checked(harmonic, len(self.harmonic), "a harmonic flow")

    def stream_function(self, q: Floats, circulations: Floats) -> Floats:
        """Solve Sψ = -q, (n,), with ψ constant on each loop and these circulations; zero at a vertex per component."""
        return self._poisson(circulations - self._poisson.gather(q))

    def velocity(self, psi: Floats, c: Floats) -> Floats:
        """Return V = n x ∇ψ + Σ c_k h_k, (m, 3)."""
        V = quarter_turn(self.mesh, (self._gradient @ psi).reshape(-1, 3))
        return np.asarray(V + np.tensordot(c, self.harmonic, axes=1)) if len(c) else V

    def induced_velocity(self, q: Floats) -> Floats:
        """Return the velocity, (m, 3), of an integrated vorticity without boundary circulations or harmonic part."""
        psi = self.stream_function(q, np.zeros(self._poisson.n_unknowns))
        return self.velocity(psi, np.zeros(len(self.harmonic)))

    def without_mean(self, q: Floats) -> Floats:
        """Subtract the mean vorticity of each component: q then sums to zero there."""
        return without_mean(q, self.mesh.components, self.areas, integrated=True)

    # -- vorticity and its transport -----------------------------------------------------------------------------

    def vorticity(self, q: Floats) -> Floats:
        """Return w = B q, (n,), units 1/time."""
        return self.mass_corrected(self.inverse_areas * q)

    def jacobian(self, psi: Floats, c: Floats) -> sp.csr_array:
        """Assemble J_V, (n, n), antisymmetric, weak: row i is the integral of φ_i V·∇, V as in `velocity`."""
        sixth = psi / 6
        data = sixth[self._left] - sixth[self._right]
        if len(c):
            data += c @ self._harmonic_jacobians
        return filled(self._pattern, data)

    def derivative(self, J: sp.csr_array) -> sp.csr_array:
        """Return D_V = M⁻¹J, (n, n), strong."""
        return filled(self._pattern, J.data * self.inverse_areas[self._rows])

    def rates(self, J: sp.csr_array) -> Floats:
        """Return the absolute row sums of M⁻¹J, (n,), about 1.5 |V|/h: how often per time the flow crosses an edge."""
        rates = np.bincount(self._rows, np.abs(J.data), J.shape[0]) * self.inverse_areas
        if not np.isfinite(rates).all():
            raise ConvergenceError("the flow is no longer finite; take a shorter time step or a weaker force")
        return np.asarray(rates)

    def harmonic_rate(self, w: Floats, psi: Floats, c: Floats) -> Floats:
        """Return dc_k/dt = -Σ_f A_f w_f (n x V_f)·h_k, (2g,), w_f the mean of the corners."""
        if not len(c):
            return np.zeros(0)
        weights = self.mesh.face_areas * w[self.mesh.faces].mean(axis=1)
        force = quarter_turn(self.mesh, self.velocity(psi, c)) * weights[:, None]
        return np.asarray(-np.einsum("gfx,fx->g", self.harmonic, force))

    def diffusion(self, nu_dt: float) -> DirectSolver:
        """Factor M + ν dt S, which maps the diffused w to q."""
        return DirectSolver(backward_euler(self.areas, stiffness(self.mesh), nu_dt), self.areas > 0)

    def _extrapolated_to_boundary(self, q: Floats) -> Floats:
        """q with the vorticity at boundary vertices replaced by the mass-weighted mean of adjacent inner vertices."""
        boundary = self.mesh.boundary_vertices
        if not len(boundary):
            return q
        inner = np.ones_like(q)
        inner[boundary] = 0.0
        sums, weights = self._mass @ (inner * (q * self.inverse_areas)), self._mass @ inner
        w = np.divide(sums, weights, out=np.zeros_like(sums), where=weights > 0)
        return np.where(inner > 0, q, w * self.areas)

    def _jacobian_pattern(self) -> tuple[Floats, Floats, sp.csr_array]:
        """For each entry (i, j), the vertices l and k beyond the edge: J_ij = (ψ_l - ψ_k)/6 [Arakawa 1966].

        Face (i, j, k) holds the edge from i to j, face (j, i, l) the one from j to i. On the boundary the missing
        vertex is replaced by i, whose ψ is that of the loop; on the diagonal both are.
        """
        mesh, n = self.mesh, np.int64(self.mesh.n_vertices)
        pattern = self._derivative.weak(np.zeros((mesh.n_faces, 3)))
        rows = self._rows = np.repeat(np.arange(n), np.diff(pattern.indptr))
        keys = rows * n + pattern.indices  # ascending
        sides = []
        i, j = np.roll(mesh.faces, -1, axis=1), np.roll(mesh.faces, -2, axis=1)  # edge i -> j, opposite corner k
        for start, end in ((j, i), (i, j)):
            beyond = rows.copy()
            beyond[np.searchsorted(keys, (start * n + end).ravel())] = mesh.faces.ravel()
            sides.append(beyond)
        return sides[0], sides[1], pattern


def _checked(given: ArrayLike | None, count: int, name: str) -> Floats:
    """Values as an array, (count,), zeros for None; FieldError if they have another shape or are not finite."""
    values = np.zeros(count) if given is None else np.asarray(given, dtype=float)
    if values.shape != (count,) or not np.isfinite(values).all():
        raise FieldError(f"{name} has {count} finite values on this mesh, not an array of shape {values.shape}")
    return values
