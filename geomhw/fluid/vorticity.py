"""Vorticity on a mesh: the stream function and velocity it makes, and how the flow moves it.

q_i is the integral of w φ_i. V = n x ∇ψ + Σ c_k h_k with Sψ = -q and harmonic h_k; with J_ij = Σ_f (A_f/3) V_f·∇φ_j,
dq/dt = -J w. For such V, J is antisymmetric: the Jacobian of Arakawa (1966) on triangles, and M D_V of the operator
approach [OATVF, eq. 7]. Energy, enstrophy and circulation are kept by dq/dt = -J B q for any symmetric w = B q.
"""

import numpy as np
import scipy.sparse as sp

from geomhw.arrays import Floats
from geomhw.errors import ConvergenceError
from geomhw.flow.harmonic import harmonic_basis
from geomhw.flow.stream_function import LoopPoisson
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.curl import curl_of, quarter_turn
from geomhw.operators.directional_derivative import DirectionalDerivative, filled
from geomhw.operators.divergence import divergence
from geomhw.operators.gradient import gradient
from geomhw.operators.laplacian import backward_euler, stiffness
from geomhw.operators.mass import consistent_mass
from geomhw.solvers.direct import DirectSolver
from geomhw.solvers.expm import SERIES_STEP, substeps

#: Terms of the series M_c⁻¹ = (I + R + R² + ...) M⁻¹, R = I - M⁻¹M_c, that w = B q takes: lumped mass alone lets waves
#: lag; each term takes half of the lag away, or more.
MASS_CORRECTIONS = 2


class VorticityModel:
    """All that a flow needs of one mesh: one factorization, fixed patterns, the harmonic basis.

    The mesh is an oriented manifold, of any genus, in any number of components, with or without boundary; on a boundary
    loop ψ is constant, so that nothing flows through, and the circulation round it stays what it was. MeshError else.
    """

    def __init__(self, mesh: TriangleMesh) -> None:
        mesh.require_oriented("a flow")
        self.mesh = mesh
        self.gradient = gradient(mesh)
        self._divergence = divergence(mesh)
        self.areas = mesh.vertex_areas
        self.inverse_areas = np.divide(1.0, self.areas, out=np.zeros_like(self.areas), where=self.areas > 0)
        self.mass = consistent_mass(mesh)
        self._rough = (sp.eye_array(mesh.n_vertices) - sp.diags_array(self.inverse_areas) @ self.mass).tocsr()
        self._poisson = LoopPoisson(mesh)
        self._on_loop = np.zeros(mesh.n_vertices, dtype=bool)
        self._on_loop[mesh.boundary_vertices] = True
        self.loops = np.unique(self._poisson.unknown_of[mesh.boundary_vertices])
        self.harmonic = harmonic_basis(mesh, self._poisson)
        self._derivative = DirectionalDerivative(mesh)
        self._harmonic_data = np.array([self._derivative.weak(h).data for h in self.harmonic])
        self._ahead, self._behind, self._pattern = self._jacobian_pattern()

    @property
    def n_unknowns(self) -> int:
        """How many unknowns ψ has: one an inner vertex and one a boundary loop."""
        return self._poisson.n_unknowns

    # -- states --------------------------------------------------------------------------------------------------

    def from_velocity(self, V: Floats) -> tuple[Floats, Floats, Floats]:
        """q (n,), loop circulations (k,) and harmonic coefficients c (2g,) of the divergence-free part of V, (m, 3).

        Inside, q_i = Σ_f A_f ∇φ_i·(n x V_f). At a boundary vertex that sum lacks the circulation along the boundary;
        there the vorticity is taken from the nearest inner ones, and what remains is the loop's circulation.
        """
        q = curl_of(self.mesh, V, self._divergence)
        around = np.zeros(self.n_unknowns)
        if self._on_loop.any():
            inside = np.where(self._on_loop, 0.0, 1.0)
            ring = self.mass @ np.where(self._on_loop, 0.0, q * self.inverse_areas)
            weight = self.mass @ inside
            w = np.divide(ring, weight, out=np.zeros_like(ring), where=weight > 0)
            guess = np.where(self._on_loop, w * self.areas, q)
            around = self._poisson.gathered(np.where(self._on_loop, guess - q, 0.0))
            q = guess
        c = np.einsum("gfx,fx,f->g", self.harmonic, V, self.mesh.face_areas)
        return q, around, c

    def from_vorticity(self, w: Floats) -> Floats:
        """q = M_c w, (n,), less its mean on each component: a closed surface has no net vorticity."""
        return self.centered(self.mass @ w)

    def stream_function(self, q: Floats, around: Floats) -> Floats:
        """ψ, (n,), with Sψ = -q inside, constant on each loop with that circulation; zero at one vertex a component."""
        return self._poisson(around - self._poisson.gathered(q))

    def velocity(self, psi: Floats, c: Floats) -> Floats:
        """n x ∇ψ + Σ c_k h_k, (m, 3)."""
        V = quarter_turn(self.mesh, (self.gradient @ psi).reshape(-1, 3))
        return np.asarray(V + np.tensordot(c, self.harmonic, axes=1)) if len(c) else V

    # -- vorticity and its transport -----------------------------------------------------------------------------

    def vorticity(self, q: Floats) -> Floats:
        """w = B q, (n,), 1/time: the truncated series of M_c⁻¹, symmetric, without a solve."""
        return self.sharpened(self.inverse_areas * q)

    def sharpened(self, density: Floats, corrections: int = MASS_CORRECTIONS) -> Floats:
        """B M d, (n,) or (n, k), for a density d = M⁻¹q: d with the lag of the lumped mass made up for."""
        w = density
        for _ in range(corrections):
            w = density + self._rough @ w
        return np.asarray(w)

    def roughness(self, w: Floats, alpha: Floats) -> Floats:
        """M⁻¹D w, (n,) or (n, k), with D = K M⁻¹ √α K √α M⁻¹ K, K = M - M_c: D is symmetric, semidefinite, D 1 = 0.

        On a wave of length L it is about (h/L)⁶ of what it is on the finest.
        """
        root = np.sqrt(alpha)
        return np.asarray(self._rough @ (root * (self._rough @ (root * (self._rough @ w)))))

    def centered(self, q: Floats) -> Floats:
        """q less its mean density on each component, (n,), so that it sums to zero there."""
        if self.mesh.n_components == 1:
            return np.asarray(q - self.areas * (q.sum() / self.areas.sum()))
        labels = self.mesh.components
        totals, areas = np.bincount(labels, weights=q), np.bincount(labels, weights=self.areas)
        density = np.divide(totals, areas, out=np.zeros_like(totals), where=areas > 0)
        return np.asarray(q - self.areas * density[labels])

    def jacobian(self, psi: Floats, c: Floats) -> sp.csr_array:
        """J_V, (n, n), antisymmetric: row i is the integral of φ_i V·∇, weak; V as in `velocity`."""
        sixth = psi / 6
        data = sixth[self._ahead] - sixth[self._behind]
        if len(c):
            data += c @ self._harmonic_data
        return filled(self._pattern, data)

    def derivative(self, J: sp.csr_array) -> sp.csr_array:
        """D_V = M⁻¹J, (n, n), strong."""
        return filled(self._pattern, J.data * self.inverse_areas[self._rows])

    def diffusion(self, nu_dt: float) -> DirectSolver:
        """(M + ν dt S)⁻¹, from q to the diffused w."""
        surface = np.ones(self.mesh.n_vertices, dtype=bool)
        surface[self.mesh.unreferenced_vertices] = False
        return DirectSolver(backward_euler(self.areas, stiffness(self.mesh), nu_dt), surface)

    def series_parts(self, J: sp.csr_array, dt: float) -> int:
        """Substeps in which the series for exp(-dt J B) stays short."""
        return substeps(float(self.rates(J).max()), dt, SERIES_STEP)

    def rates(self, J: sp.csr_array) -> Floats:
        """Absolute row sums of M⁻¹J, (n,), 1/time: some 1.5 |V|/h, how often the flow crosses an edge."""
        rates = np.bincount(self._rows, np.abs(J.data), J.shape[0]) * self.inverse_areas
        if not np.isfinite(rates).all():
            raise ConvergenceError("the flow is no longer finite; take a shorter time step or a weaker force")
        return np.asarray(rates)

    def harmonic_rate(self, w: Floats, V: Floats) -> Floats:
        """dc_k/dt = -Σ_f A_f w_f (n x V_f)·h_k, (2g,), w_f the mean of the corners."""
        if not len(self.harmonic):
            return np.zeros(0)
        lift = quarter_turn(self.mesh, V) * (self.mesh.face_areas * w[self.mesh.faces].mean(axis=1))[:, None]
        return np.asarray(-np.einsum("gfx,fx->g", self.harmonic, lift))

    def _jacobian_pattern(self) -> tuple[Floats, Floats, sp.csr_array]:
        """For each entry (i, j), the vertices l and k beyond the edge: J_ij = (ψ_l - ψ_k)/6 [Arakawa 1966].

        Face (i, j, k) holds the edge from i to j, face (j, i, l) the one from j to i. On the boundary the missing
        vertex is i itself, whose ψ is the loop's; on the diagonal both are.
        """
        mesh = self.mesh
        pattern = self._derivative.weak(np.zeros((mesh.n_faces, 3)))
        rows = self._rows = np.repeat(np.arange(mesh.n_vertices), np.diff(pattern.indptr))
        keys = rows * np.int64(mesh.n_vertices) + pattern.indices
        order = np.argsort(keys)
        sides = []
        for ahead in (True, False):
            i, j = np.roll(mesh.faces, -1, axis=1), np.roll(mesh.faces, -2, axis=1)  # edge i -> j, opposite corner k
            i, j = (i, j) if not ahead else (j, i)
            at = order[np.searchsorted(keys, (i * np.int64(mesh.n_vertices) + j).ravel(), sorter=order)]
            beyond = rows.copy()
            beyond[at] = mesh.faces.ravel()
            sides.append(beyond)
        return sides[0], sides[1], pattern
