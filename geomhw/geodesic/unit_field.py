"""The unit field X = -∇u/|∇u| of the heat method, and its divergence [GIH, algorithm 1, step II]."""

import numpy as np

from geomhw.arrays import Floats, Ints, pieces
from geomhw.mesh.geometry import at_corners, lengths, unit
from geomhw.mesh.polyhedral import PolyhedralSurface
from geomhw.operators.gradient import corner_gradients
from geomhw.solvers.log_scaled import LogValues

#: Heat that differs by less than this share of itself over a face has no direction there: the rest is rounding.
LEVEL = 1e-9


def unit_field(surface: PolyhedralSurface, heat: LogValues, sources: Ints) -> tuple[Floats, Floats]:
    """Return ∇u and X = -∇u/|∇u| per face, (m, 3) each, from heat at vertices in logarithms.

    Since only the direction of ∇u matters, u is scaled face by face to order one. X is zero where u is constant up to
    rounding, and on faces whose three corners are source vertices.
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
    """exp(-s) ∇u on the faces of a slice, (k, 3), and s, (k,): the largest logarithm of u at the corners."""
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
