"""A window in which a result can be turned, by pyvista."""

import os
import sys
from collections.abc import Mapping

from geomhw.arrays import Floats
from geomhw.errors import GeomhwError
from geomhw.results import Result


def show_window(result: Result, active: str | None = None, points: Mapping[str, Floats] | None = None) -> None:
    """Open a window with a result and points, and wait until it is closed.

    Parameters
    ----------
    result
        The mesh and its fields.
    active
        Name of the field that gives the colors.
    points
        Points by name, (k, 3).

    Raises
    ------
    GeomhwError
        If there is no display.
    """
    if sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        raise GeomhwError("there is no display for a window; give -o page.html for a page")
    import pyvista

    plotter = pyvista.Plotter()
    plotter.add_mesh(result.to_pyvista(), scalars=active)
    for name, positions in (points or {}).items():
        plotter.add_points(positions, label=name, color="firebrick", render_points_as_spheres=True)
    plotter.show()
