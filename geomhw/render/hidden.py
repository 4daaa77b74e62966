"""Faces that need not be drawn: those turned away, on a closed surface, where a look at depth confirms it.

A line of sight enters a closed surface through a face turned our way, and leaves through one turned away, which is
therefore hidden, unless the surface crosses itself so as to turn inside out, or is given inside out. Coordinates are
those of the stage.
"""

from functools import reduce

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Floats
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.render import glyphs


def turned_away(mesh: TriangleMesh, toward: Floats) -> NDArray[np.bool_]:
    """Faces of a closed surface that do not look towards the viewer, (m,); none of any other."""
    if not (mesh.is_closed and mesh.is_oriented):
        return np.zeros(mesh.n_faces, dtype=bool)
    return np.asarray(mesh.face_normals @ toward <= 0)


def in_sight(points: Floats, faces: NDArray[np.int32], nearest: Floats) -> bool:
    """Whether the middle of some face, (k, 3), which was not drawn, lies before all that was drawn about it.

    points: (n, 3). nearest: the z at each pixel, (h, w), from the bottom row up. What is drawn up to a pixel off, or no
    deeper than a pixel below, counts as before.
    """
    height, width = nearest.shape
    middles = glyphs.middles(points, faces)
    places = np.floor(middles[:, :2] * height / 2 + [width / 2, height / 2]).astype(np.int64)
    column, row = np.clip(places, 0, [width - 1, height - 1]).T
    steps = [(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1)]
    round_it = (nearest[np.clip(row + i, 0, height - 1), np.clip(column + j, 0, width - 1)] for i, j in steps)
    near = reduce(np.maximum, round_it)
    return bool(np.any(middles[:, 2] > near + 2 / height))
