"""Smooth n-direction fields: the smoothest one, and the one that follows constraints."""

from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp

from geomhw.arrays import Complexes, Ints
from geomhw.directions.power_fields import direction_energy, directions_of, unit_power
from geomhw.directions.singularities import singularity_report
from geomhw.errors import ConvergenceError
from geomhw.mesh.cut import cut_at_pinched_vertices
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.mass import lumped_mass
from geomhw.results import Field, Result
from geomhw.solvers.direct import DirectSolver
from geomhw.spectral.eigenpairs import below, smallest_eigenpairs

#: Steps of relaxation, by default.
RELAXATION = 20
#: Negative eigenvalues above this, times area, are rounding.
ROUNDING = 1e-6
#: First shift that is tried to make an energy positive, over n 4π/area.
SHIFT = 1.0
#: Inverse iterations toward the smallest eigenvalue, and shares of the result, down to 0, at which it is bounded.
INVERSE_ITERATIONS, SHARES = 8, (0.02, 0.1, 0.3, 0.6, 1.0)


class DirectionFields:
    """Fields of n directions on one mesh: n unit vectors at each vertex, a full turn over n apart.

    A field is a complex number u = zⁿ at each vertex. Smooth fields minimize the energy uᴴAu of `direction_energy` for
    ∫|u|² = 1: a quadratic problem with a global optimum. Directions are those of u, whose length is then dropped.

    Parameters
    ----------
    mesh : an oriented manifold. It is cut open at pinched vertices, which have the directions of their first fan.
    n : 1 (vectors), 2 (lines), 4 (crosses) or 6.
    s : as in `direction_energy`.

    Attributes
    ----------
    mesh : the mesh that is cut open, with n_vertices vertices.
    energy, mass : (n_vertices, n_vertices) sparse arrays, of `direction_energy` and `lumped_mass`.
    nonnegative : whether negative cotan weights are replaced by 0, since the Dirichlet energy is not positive with
        them: on meshes with slivers the fields of least energy would be noise there.

    Raises
    ------
    ArgumentError, MeshError
        As `direction_energy`.

    References
    ----------
    Knöppel, Crane, Pinkall, Schröder: Globally Optimal Direction Fields. ACM Trans. Graph. 32(4), 2013.

    Examples
    --------
    >>> from geomhw.mesh import icosphere
    >>> fields = DirectionFields(icosphere(3), 4)
    >>> fields.result(fields.smoothest()).report["index_sum"]
    2.0
    """

    def __init__(self, mesh: TriangleMesh, n: int = 1, s: float = 0.0) -> None:
        mesh.require_oriented("a direction field")
        self.given, self.n, self.s = mesh, n, s
        self.mesh = cut_at_pinched_vertices(mesh)[0]
        self.mass = lumped_mass(self.mesh)
        used = np.flatnonzero(np.bincount(self.mesh.faces.ravel()))
        dirichlet, M = direction_energy(self.mesh, n)[used][:, used], self.mass[used][:, used]
        self.nonnegative = below(dirichlet, M, -ROUNDING / M.sum()) > 0
        self.energy = direction_energy(self.mesh, n, s, self.nonnegative)

    def smoothest(self) -> Complexes:
        """Compute the smoothest field, (n_vertices,) complex, with ∫|u|² = 1 on each component."""
        u = np.ones(self.mesh.n_vertices, dtype=complex)
        for rows in self._components:
            u[rows] = _smallest(self.energy[rows][:, rows], self.mass[rows][:, rows])
        return u

    def aligned(
        self,
        vertices: Ints | None = None,
        values: Complexes | None = None,
        target: Complexes | None = None,
        weight: float = 0.0,
    ) -> Complexes:
        """Compute the field of least energy with given values at some vertices, near a target at the others.

        It minimizes uᴴAu + w ∫|u - q|² with w = 4π weight/area, and q the target over its root mean square.

        Parameters
        ----------
        vertices, values : u at vertices, of length 1; the directions there are exact.
        target : q, (n_vertices,), such as `principal_target`.
        weight : of the target, dimensionless.

        Returns
        -------
        (n_vertices,) complex array; on components without constraints and target the `smoothest` field.

        Raises
        ------
        ConvergenceError
            If the system is singular.
        """
        mesh = self.mesh
        u = np.ones(mesh.n_vertices, dtype=complex)
        given = np.zeros(mesh.n_vertices, dtype=bool)
        if vertices is not None and values is not None:
            given[vertices] = True
            u[vertices] = values
        A, b = self._system(target, weight)
        for rows in self._components:
            inner, fixed = rows[~given[rows]], rows[given[rows]]
            if not len(fixed) and not b[rows].any():
                u[rows] = _smallest(self.energy[rows][:, rows], self.mass[rows][:, rows])
            elif len(inner):
                u[inner] = DirectSolver(sp.csr_array(A[inner][:, inner]))(b[inner] - A[inner][:, fixed] @ u[fixed])
        return u

    def relaxed(
        self,
        u: Complexes,
        vertices: Ints | None = None,
        target: Complexes | None = None,
        weight: float = 0.0,
        steps: int = RELAXATION,
    ) -> Complexes:
        """Lower the energy of the directions of u: diffuse for a time h², then set all lengths to 1, again and again.

        The field of least energy varies in length, and is short near singularities. Its directions alone are not
        optimal: on scans, twenty steps lower their energy by a third.

        Parameters
        ----------
        vertices : whose directions stay.
        target, weight : as in `aligned`.
        steps : number of steps.

        Returns
        -------
        (n_vertices,) complex array of length 1.

        References
        ----------
        Merriman, Bence, Osher: Motion of Multiple Junctions: A Level Set Approach, 1994.
        """
        u = unit_power(u)
        time = self.mesh.mean_edge_length**2
        A, b = self._system(target, weight)
        moving = np.bincount(self.mesh.faces.ravel(), minlength=self.mesh.n_vertices) > 0
        moving[vertices if vertices is not None else []] = False
        inner, fixed = np.flatnonzero(moving), np.flatnonzero(~moving)
        if not (steps and len(inner)):
            return u
        rows = sp.csr_array(self.mass + time * A)[inner]
        solve, given = DirectSolver(sp.csr_array(rows[:, inner])), rows[:, fixed] @ u[fixed] - time * b[inner]
        mass = self.mass.diagonal()[inner]
        for _ in range(steps):
            u[inner] = unit_power(solve(mass * u[inner] - given))
        return u

    def result(self, u: Complexes, relaxed: Complexes | None = None) -> Result:
        """Return the directions of u as vertex arrays, and its energy and singularities as a report.

        Parameters
        ----------
        relaxed : the field whose directions are meant, if u was `relaxed`.

        Returns
        -------
        Result
            Per vertex ``direction`` for n = 1, else ``direction_0`` ... counterclockwise, (n_vertices, 3), unit
            vectors; zero where u is. Report: ``energy`` of u over ∫|u|², ``unit_energy`` of its directions over the
            area, unit 1/length²; ``singularities`` with ``face`` or ``vertex``, ``position`` and ``index``;
            ``boundary_turns``, how often each boundary loop turns more than the field; ``index_sum`` of both;
            ``euler_characteristic``.
        """
        mesh, n, energy = self.mesh, self.n, self._quotient(u)
        u = u if relaxed is None else relaxed
        directions = directions_of(mesh, u, n)
        directions[:, u == 0] = directions[:, mesh.unreferenced_vertices] = 0.0
        names = ["direction"] if n == 1 else [f"direction_{k}" for k in range(n)]
        directions = directions[:, : self.given.n_vertices]
        fields = [Field(name, "vertex", values) for name, values in zip(names, directions, strict=True)]
        energies = {"energy": energy, "unit_energy": self._quotient(unit_power(u))}
        report: dict[str, Any] = {
            "directions": n,
            "s": self.s,
            "nonnegative_weights": self.nonnegative,
            **energies,
            **singularity_report(mesh, u, n),
        }
        return Result(self.given, fields, report)

    def _system(self, target: Complexes | None, weight: float) -> tuple[sp.csr_array, Complexes]:
        """Matrix and right-hand side of the condition for a minimum of uᴴAu + w ∫|u - q|²."""
        if target is None or not weight:
            return self.energy, np.zeros(self.mesh.n_vertices, dtype=complex)
        area = float(self.mesh.face_areas.sum())
        size = np.sqrt((self.mass @ np.abs(target) ** 2).sum() / area)
        M = (4 * np.pi * weight / area) * self.mass
        return self.energy + M, M @ (target / (size or 1.0))

    def _quotient(self, u: Complexes) -> float:
        """Energy over ∫|u|², unit 1/length²."""
        return float((np.conj(u) @ (self.energy @ u)).real / (np.conj(u) @ (self.mass @ u)).real)

    @cached_property
    def _components(self) -> list[Ints]:
        """Vertices of each component with faces."""
        order = np.argsort(self.mesh.components, kind="stable")
        parts = np.split(order, np.flatnonzero(np.diff(self.mesh.components[order])) + 1)
        return [part for part in parts if len(part) > 1]


def _smallest(A: sp.csr_array, M: sp.csr_array) -> Complexes:
    """Eigenvector of the smallest eigenvalue of A u = λ M u, where A may be indefinite."""
    shift = 0.0
    while below(A, M, -shift - ROUNDING / M.sum()):
        shift = max(2 * shift, SHIFT * 4 * np.pi / M.sum())
    try:
        return _shifted(A, M, shift)
    except ConvergenceError:
        # The small eigenvalues are close to each other, compared to their size: shift to below the smallest.
        return _shifted(A, M, -_lower_bound(A, M, shift))


def _shifted(A: sp.csr_array, M: sp.csr_array, shift: float) -> Complexes:
    return np.asarray(smallest_eigenpairs(sp.csr_array(A + shift * M), sp.csr_array(M), 1).vectors[:, 0])


def _lower_bound(A: sp.csr_array, M: sp.csr_array, shift: float) -> float:
    """A number a little below the smallest eigenvalue, from a few inverse iterations and counts of eigenvalues."""
    solve, u = DirectSolver(sp.csr_array(A + (shift + 1 / M.sum()) * M)), np.ones(A.shape[0], dtype=complex)
    for _ in range(INVERSE_ITERATIONS):
        u = solve(M @ u)
        u /= np.abs(u).max()
    upper = float((np.conj(u) @ (A @ u)).real / (np.conj(u) @ (M @ u)).real)
    return next(bound for part in SHARES if not below(A, M, bound := upper - part * (upper + shift)))
