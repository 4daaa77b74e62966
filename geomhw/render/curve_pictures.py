"""Pictures of curves and of polar coordinates on a mesh."""

from collections.abc import Sequence

import numpy as np

from geomhw.arrays import Floats
from geomhw.mesh.surface_points import SurfacePoints
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.render.layers import Curves, Panel, Surface
from geomhw.render.look import AUTOMATIC, Look
from geomhw.render.panels import Picture, draw
from geomhw.render.source_marks import FARTHEST_COLOR, SOURCE_COLOR, source_marks
from geomhw.render.view import choose_view
from geomhw.results import Cloud, Result

#: Curves are dark with a lighter outline, a halo.
CURVE, HALO = ("#14171c", 3.0), ("#ffffff", 7.0)
#: Meshes of at most this number of faces are subdivided for the checkerboard.
FEW_FACES = 50_000
#: Squares of the checkerboard from the source to the farthest vertex, and their colors, RGB from 0 to 1.
SQUARES = 12
DARK, LIGHT, UNKNOWN = (0.16, 0.35, 0.55), (0.93, 0.94, 0.96), (0.72, 0.74, 0.77)


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
    layers = [Curves(curves.segments, *style) for style in (HALO, CURVE)]
    marks: Sequence[tuple[SurfacePoints | None, str]] = ((starts, SOURCE_COLOR), (ends, FARTHEST_COLOR))
    found = [source_marks(Result(mesh, sources=points), color) for points, color in marks]
    markers = [marker for discs, _ in found for marker in discs]
    view = choose_view(mesh, mesh.faces[np.asarray(curves["face"]), 0].tolist(), look)
    panel = Panel(markers=markers, curves=[*layers, *(curve for _, more in found for curve in more)])
    return draw(mesh, [panel], view=view, look=look)


def log_picture(result: Result, look: Look = AUTOMATIC) -> Picture:
    """Draw a logarithmic map as a checkerboard, one color a face.

    Parameters
    ----------
    result : Result
        Of `LogarithmicMap`.
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
    mesh, log = _subdivided(result.mesh, np.asarray(result["log"]))
    centers = log[mesh.faces].mean(axis=1)
    known = np.isfinite(centers).all(axis=1)
    square = max(float(np.abs(log).max(initial=0.0, where=np.isfinite(log))) / SQUARES, np.finfo(float).tiny)
    dark = np.floor(centers[known] / square).sum(axis=1) % 2 == 1
    colors = np.full((len(centers), 3), UNKNOWN)
    colors[known] = np.where(dark[:, None], DARK, LIGHT)
    markers, _ = source_marks(Result(mesh, sources=result.sources), SOURCE_COLOR)
    return draw(mesh, [Panel(surface=Surface(colors, "face"), markers=markers)], look=look)


def _subdivided(mesh: TriangleMesh, values: Floats) -> tuple[TriangleMesh, Floats]:
    """Divide all faces in four while there are few; values in the middle of edges are means."""
    while mesh.n_faces <= FEW_FACES:
        n, edges, (a, b, c) = mesh.n_vertices, mesh.edges, mesh.faces.T
        # Edge k is opposite corner k.
        x, y, z = n + mesh.edge_table.of_faces.T
        faces = np.stack(
            [np.concatenate(corner) for corner in zip((a, z, y), (z, b, x), (y, x, c), (x, y, z), strict=True)], axis=1
        )
        values = np.concatenate([values, values[edges].mean(axis=1)])
        mesh = TriangleMesh(np.concatenate([mesh.vertices, mesh.vertices[edges].mean(axis=1)]), faces)
    return mesh, values
