"""Structured grids of legacy VTK: their points, and the quads of a grid that is one point thick along one axis."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Floats
from geomhw.errors import FormatError
from geomhw.io.formats.vtk_cells import POLYGON, Cells

_AXES = ("X_COORDINATES", "Y_COORDINATES", "Z_COORDINATES")


def grid_points(axes: Mapping[str, NDArray[np.floating]], size: NDArray[np.int64]) -> Floats:
    """Return the points of a grid, x as the fastest index: by the coordinates of its axes, or origin and spacing."""
    if all(axis in axes for axis in _AXES):
        x, y, z = (axes[axis] for axis in _AXES)
    else:
        origin, spacing = axes.get("ORIGIN", np.zeros(3)), axes.get("SPACING", np.ones(3))
        with np.errstate(all="ignore"):  # a spacing that is not finite; the points are checked later
            x, y, z = (origin[k] + spacing[k] * np.arange(size[k]) for k in range(3))
    return np.stack(np.meshgrid(z, y, x, indexing="ij")[::-1], axis=-1).reshape(-1, 3)


def grid_quads(name: str, size: NDArray[np.int64], points: Floats | None) -> Cells:
    """Return the quads of a grid of a surface; FormatError for grids of lines or volume cells."""
    if points is None:
        raise FormatError(f"{name} has no dimensions")
    if size.prod() != len(points):
        raise FormatError(f"{name} has {len(points)} points, which is not the product of its dimensions")
    if (size > 1).sum() != 2:
        kind = "volume cells; extract its surface first" if (size > 1).all() else "points or lines and no faces"
        raise FormatError(f"{name} holds {kind}")
    width, height = size[size > 1]
    first = (np.arange(height - 1)[:, None] * width + np.arange(width - 1)).ravel()
    corners = first[:, None] + np.array([0, 1, width + 1, width])
    return Cells(corners.ravel(), np.full(len(first), 4), np.full(len(first), POLYGON))
