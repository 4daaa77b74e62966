"""A window in which a result can be turned, by pyvista."""

import os
import sys
from collections.abc import Mapping
from itertools import pairwise

from geomhw.errors import GeomhwError
from geomhw.results import Cloud, Result


def show_window(result: Result, active: str | None = None, clouds: Mapping[str, Cloud] | None = None) -> None:
    """Open a window with a result, points and polylines, and wait until it is closed.

    Parameters
    ----------
    result
        The mesh and its fields.
    active
        Name of the field that gives the colors.
    clouds
        Points or polylines by name.

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
    for name, cloud in (clouds or {}).items():
        if cloud.lines is None:
            plotter.add_points(cloud.points, label=name, color="firebrick", render_points_as_spheres=True)
            continue
        for begin, end in pairwise(cloud.lines):
            plotter.add_lines(cloud.points[begin:end], label=name, color="firebrick", connected=True)
    plotter.show()
