"""Pictures of curves on a mesh."""

from collections.abc import Sequence

import numpy as np

from geomhw.mesh.surface_points import SurfacePoints
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.render.layers import Curves, Panel
from geomhw.render.look import AUTOMATIC, Look
from geomhw.render.panels import Picture, draw
from geomhw.render.source_marks import source_marks
from geomhw.render.view import choose_view
from geomhw.results import Cloud, Result

START_COLOR, END_COLOR = "#c2185b", "#0b57d0"
#: Curves are dark with a lighter outline, a halo.
CURVE, HALO = ("#14171c", 3.0), ("#ffffff", 7.0)


def curve_picture(
    mesh: TriangleMesh,
    curves: Cloud,
    starts: SurfacePoints,
    ends: SurfacePoints | None = None,
    look: Look = AUTOMATIC,
) -> Picture:
    """Draw polylines on a mesh, with a disc at each start and end.

    Parameters
    ----------
    mesh : TriangleMesh
    curves : Cloud with polylines.
    starts, ends : SurfacePoints
    look : Look
        View and width.

    Returns
    -------
    (height, width, 3) array, uint8

    Raises
    ------
    RenderError
        If there is no OpenGL on this machine.
    """
    assert curves.lines is not None
    inner = np.setdiff1d(np.arange(len(curves.points) - 1), curves.lines[1:] - 1)
    segments = np.stack([curves.points[inner], curves.points[inner + 1]], axis=1)
    layers = [Curves(segments, *style) for style in (HALO, CURVE)]
    marks: Sequence[tuple[SurfacePoints | None, str]] = ((starts, START_COLOR), (ends, END_COLOR))
    found = [source_marks(Result(mesh, sources=points), color) for points, color in marks]
    markers = [marker for discs, _ in found for marker in discs]
    view = choose_view(mesh, mesh.faces[np.asarray(curves["face"]), 0].tolist(), look)
    panel = Panel(markers=markers, curves=[*layers, *(curve for _, more in found for curve in more)])
    return draw(mesh, [panel], view=view, look=look)
