"""Smoothing of functions along the surface by heat flow, which makes a point a Gaussian of a given width."""

import math

import numpy as np
import scipy.sparse as sp

from geomhw.arrays import Floats
from geomhw.errors import ArgumentError
from geomhw.mesh.polyhedral import PolyhedralSurface
from geomhw.operators.laplacian import stiffness
from geomhw.operators.mass import mean_mass
from geomhw.solvers.auto import LaplaceSolver

#: Steps of the heat flow: 4 or 32 change a point that has become a Gaussian of 6 edges by 2 or 0.1 %.
STEPS = 12
#: Root 1 - 1/√2 of the denominator of a step, for which it is L-stable and of second order [Hairer, Wanner 1996, IV.6].
GAMMA = 1 - math.sqrt(0.5)


def diffusion_time(fwhm: float) -> float:
    """Return the time after which heat from a point of the plane is a Gaussian of a full width at half maximum.

    Parameters
    ----------
    fwhm
        Width, units length: 2 √(2 ln 2) standard deviations, with variance 2t in each direction.

    Returns
    -------
    fwhm² / (16 ln 2), units length².

    Raises
    ------
    ArgumentError
        If the width is not a positive number.

    Examples
    --------
    >>> round(diffusion_time(6.0), 6)
    3.246064
    """
    if not 0 < fwhm < math.inf:
        raise ArgumentError(f"the full width at half maximum must be a positive number, not {fwhm:g}")
    return fwhm**2 / (16 * math.log(2))


class HeatSmoothing:
    """Smooth functions by heat flow; nothing flows through the boundary.

    M du/dt = -S u is solved by equal steps of an L-stable method of second order: two backward Euler solutions
    w = (M + γτS)⁻¹ M u and w' of w give (1 + √2) w' - √2 w. Each keeps the integral of u and constants. M is the mean
    of the lumped and the consistent mass: at a width of three edges, a point is off by 1 % in the mean square, with the
    lumped mass by 10 %. Values below the smallest remain possible, by 3e-4 of the range at a width of two edges.

    Parameters
    ----------
    mesh
        The surface; vertices without faces keep their values.
    fwhm
        Full width at half maximum of the Gaussian that a point becomes, units length.
    surface
        A triangulation of the same vertices to assemble on, such as the intrinsic Delaunay one.

    Raises
    ------
    ArgumentError
        If the width is not a positive number.
    MeshError
        If a face has zero area.
    ConvergenceError
        If the linear system has no finite solution.

    Examples
    --------
    >>> from geomhw.mesh import grid
    >>> mesh = grid(20, 20)
    >>> point = np.eye(1, mesh.n_vertices, 220)[0]
    >>> smoothed = HeatSmoothing(mesh, 0.3)(point)
    >>> bool(abs(mesh.vertex_areas @ (smoothed - point)) < 1e-15)
    True
    """

    def __init__(self, mesh: PolyhedralSurface, fwhm: float, surface: PolyhedralSurface | None = None) -> None:
        surface = surface or mesh
        self.time = diffusion_time(fwhm)
        self._areas = surface.vertex_areas
        self._mass = mean_mass(surface)
        self._free = self._areas > 0
        self._components = mesh.components
        heat = sp.csr_array(self._mass + GAMMA * self.time / STEPS * stiffness(surface))
        self._solve = LaplaceSolver(heat, self._free, solves=2 * STEPS)

    def __call__(self, values: Floats) -> Floats:
        """Return smoothed values, of one function, (n,), or of several, (n, k)."""
        start = np.asarray(values, dtype=float)
        scale = np.abs(start[self._free]).max(initial=0)
        if not scale:
            return start.copy()
        u = start / scale
        for _ in range(STEPS):
            once = self._solve(self._mass @ u)
            u = (1 + math.sqrt(2)) * self._solve(self._mass @ once) - math.sqrt(2) * once
        free = self._free if start.ndim == 1 else self._free[:, None]
        u += self._lost(start / scale - u)[self._components]
        return np.where(free, scale * u, start)

    def _lost(self, change: Floats) -> Floats:
        """The mean change on each component: rounding of the solutions, since the flow keeps the integral."""
        total = np.bincount(self._components, self._areas)
        columns = (self._areas * change.reshape(len(change), -1).T).T
        sums = np.stack([np.bincount(self._components, column) for column in columns.T], axis=1)
        means = np.divide(sums, total[:, None], out=np.zeros_like(sums), where=total[:, None] > 0)
        return means.reshape(len(total), *change.shape[1:])


def smooth(mesh: PolyhedralSurface, values: Floats, fwhm: float) -> Floats:
    """Smooth one function, (n,), or several, (n, k); arguments and errors are those of `HeatSmoothing`.

    Examples
    --------
    >>> from geomhw.mesh import icosphere
    >>> ball = icosphere(3)
    >>> smooth(ball, ball.vertices[:, 2], 0.5).max().round(2)  # exp(-2t) with t = 0.0225
    np.float64(0.96)
    """
    return HeatSmoothing(mesh, fwhm)(values)
