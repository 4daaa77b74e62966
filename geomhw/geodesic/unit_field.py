"""The unit field X = -∇u/|∇u| of the heat method, and its divergence [GIH, algorithm 1, step II]."""

import numpy as np

from geomhw.arrays import Floats, Ints, pieces
from geomhw.mesh.geometry import at_corners, lengths, unit
from geomhw.mesh.polyhedral import PolyhedralSurface
from geomhw.operators.gradient import corner_gradients
from geomhw.solvers.log_scaled import LogValues

#: Where u, scaled to a maximum of one, has |∇u| √A below this on a face of area A, it is constant up to rounding.
LEVEL = 1e-9


def unit_field(surface: PolyhedralSurface, heat: LogValues, sources: Ints) -> tuple[Floats, Floats]:
    """Compute ∇u and X = -∇u/|∇u| per face; u is scaled to order one on each face, since only the direction matters.

    Parameters
    ----------
    heat : u at vertices.
    sources : source vertices.

    Returns
    -------
    gradient : (m, 3) array
        ∇u, which underflows far from the sources.
    X : (m, 3) array
        Unit vectors; zero where u is constant up to rounding, and on faces with three source vertices.
    """
    is_source = np.zeros(surface.n_vertices, dtype=bool)
    is_source[sources] = True
    gradients, X = np.empty((2, 3, surface.n_faces)).transpose(0, 2, 1)
    for faces in pieces(surface.n_faces):
        scaled, scale = _scaled_gradients(surface, faces, heat)
        np.multiply(scaled, np.exp(scale)[:, None], out=gradients[faces])
        constant = lengths(scaled) * np.sqrt(surface.face_areas[faces]) < LEVEL
        scaled[constant | at_corners(is_source, surface.faces[faces]).all(axis=1)] = 0.0
        X[faces] = unit(np.negative(scaled, out=scaled))
    return gradients, X


def _scaled_gradients(surface: PolyhedralSurface, faces: slice, heat: LogValues) -> tuple[Floats, Floats]:
    """exp(-s) ∇u on the faces of a slice, (k, 3), and s, (k,), the largest log|u| at the corners."""
    corners = at_corners(heat.log, surface.faces[faces])
    a, b, c = corners.T
    largest = np.maximum(np.maximum(a, b), c)
    warm = np.isfinite(largest)
    if not warm.all():
        corners[~warm], largest[~warm] = -np.inf, 0.0
    corners -= largest[:, None]
    relative = np.exp(corners, out=corners)
    relative *= at_corners(heat.sign, surface.faces[faces])
    return corner_gradients(surface, faces, relative), largest
