"""Descriptors of vertices and distances between them, from eigenfunctions."""

from typing import get_args

import numpy as np

from geomhw.arrays import Floats
from geomhw.errors import ArgumentError
from geomhw.options import SignatureName, SpectralDistanceName

#: Width of the bands of the wave kernel, over their spacing [Aubry, Schlickewei, Cremers 2011].
_BAND = 7.0
#: Ends of the times of the heat kernel, over 1/λ [Sun, Ovsjanikov, Guibas 2009].
_DECAY = 4 * np.log(10)


def signature(name: SignatureName, values: Floats, functions: Floats, count: int = 16) -> Floats:
    """Return the heat or wave kernel signature at each vertex.

    Parameters
    ----------
    name : ``hks``, Σ exp(-λt) φ² at ``count`` times, in a geometric sequence from 4 ln 10 / λ_k to 4 ln 10 / λ_1; or
        ``wks``, Σ exp(-(e - ln λ)²/2σ²) φ² at ``count`` energies e, over Σ exp(-(e - ln λ)²/2σ²).
    values : (k,) array, eigenvalues, ascending.
    functions : (n, k) array, eigenfunctions in columns.

    Returns
    -------
    (n, count) array, unit 1/length².

    Raises
    ------
    ArgumentError
        If the name is unknown, or fewer than two eigenvalues are positive.

    References
    ----------
    Sun, Ovsjanikov, Guibas: A Concise and Provably Informative Multi-Scale Signature Based on Heat Diffusion, 2009.
    Aubry, Schlickewei, Cremers: The Wave Kernel Signature, 2011.
    """
    if name not in get_args(SignatureName):
        raise ArgumentError(f"there is no signature '{name}'; choose from {', '.join(get_args(SignatureName))}")
    positive = _positive(values)
    low, high = np.log(values[positive][0]), np.log(values[-1])
    if name == "hks":
        times = np.geomspace(_DECAY / values[-1], _DECAY / values[positive][0], count)
        return np.asarray(functions**2 @ np.exp(-np.outer(values, times)))
    spacing = (high - low) / (count + 2 * _BAND) if high > low else 1.0
    energies = np.linspace(low + 2 * spacing, high - 2 * spacing, count)
    width = _BAND * spacing
    weights = np.exp(-((energies - np.log(values[positive])[:, None]) ** 2) / (2 * width**2))
    return np.asarray(functions[:, positive] ** 2 @ (weights / weights.sum(axis=0)))


def spectral_distance(
    name: SpectralDistanceName, values: Floats, functions: Floats, vertex: int, time: float | None = None
) -> Floats:
    """Return the biharmonic or diffusion distance from a vertex to all vertices.

    Parameters
    ----------
    name : ``biharmonic``, d² = Σ (φ(x) - φ(y))²/λ², or ``diffusion``, d² = Σ exp(-2λt) (φ(x) - φ(y))², over the
        eigenpairs with positive λ.
    values, functions : as in `signature`.
    vertex : the vertex x.
    time : t of the diffusion distance, unit length²; by default 1/λ_1.

    Returns
    -------
    (n,) array; unit length for ``biharmonic``, 1/length for ``diffusion``.

    Raises
    ------
    ArgumentError
        If the name is unknown, or fewer than two eigenvalues are positive.

    References
    ----------
    Lipman, Rustamov, Funkhouser: Biharmonic Distance, 2010.
    Coifman, Lafon: Diffusion Maps, 2006.
    """
    if name not in get_args(SpectralDistanceName):
        choices = ", ".join(get_args(SpectralDistanceName))
        raise ArgumentError(f"there is no spectral distance '{name}'; choose from {choices}")
    positive = _positive(values)
    known = values[positive]
    weights = 1 / known if name == "biharmonic" else np.exp(-known * (time or 1 / known[0]))
    placed = functions[:, positive] * weights
    return np.asarray(np.linalg.norm(placed - placed[vertex], axis=1))


def _positive(values: Floats) -> Floats:
    """Mask of the eigenvalues that are not zero up to rounding."""
    positive = np.asarray(values > 1e-9 * values[-1])
    if positive.sum() < 2:
        raise ArgumentError("fewer than two of the eigenvalues are positive; ask for more")
    return positive
