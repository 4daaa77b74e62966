"""Pictures of curves and of polar coordinates on a mesh."""

from collections.abc import Sequence

import numpy as np

from geomhw.arrays import Floats
from geomhw.mesh.surface_points import SurfacePoints
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.render.colors import plain_number, round_spacing
from geomhw.render.layers import Curves, Marker, Panel, Surface
from geomhw.render.look import AUTOMATIC, Look
from geomhw.render.panels import Picture, draw
from geomhw.render.source_marks import FARTHEST_COLOR, SOURCE_COLOR, source_marks
from geomhw.render.view import View, choose_view, landmarks
from geomhw.results import Cloud, Result

#: Curves are dark with a lighter outline, a halo.
CURVE, HALO = ("#14171c", 3.0), ("#ffffff", 7.0)
#: Isolines of signed distance, at most.
SIGNED_ISOLINES = 20
#: Isolines are thinner.
ISOLINE = ("#14171c", 1.8)
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


def isoline_picture(mesh: TriangleMesh, values: Floats, curves: Cloud, name: str, look: Look = AUTOMATIC) -> Picture:
    """Draw isolines, each level with its value, on a surface colored by the function.

    Parameters
    ----------
    mesh : TriangleMesh
    values : (n,) array
    curves : Cloud
        Of `Isolines`.
    name : str
        Of the function, under the color bar.
    look : Look
        View, width and colors.

    Returns
    -------
    (height, width, 3) array, uint8

    Raises
    ------
    RenderError
        If there is no OpenGL on this machine.
    """
    view = choose_view(mesh, landmarks(mesh, ()), look)
    lines = Curves(curves.segments, *ISOLINE)
    surface = Surface(values, label=name)
    panel = Panel(surface=surface, curves=[lines], markers=_level_labels(mesh, curves, view))
    return draw(mesh, [panel], view=view, look=look)


def _level_labels(mesh: TriangleMesh, curves: Cloud, view: View) -> list[Marker]:
    """Return a label for each level: on its longest line, where the surface faces the viewer most."""
    levels, lengths = np.asarray(curves["level"]), np.asarray(curves["length"])
    path, face = np.asarray(curves["path"]), np.asarray(curves["face"])
    toward = mesh.face_normals[face] @ view.axes[2]
    markers = []
    for level in np.unique(levels):
        longest = np.flatnonzero(levels == level)[lengths[levels == level].argmax()]
        points = np.flatnonzero(path == longest)
        best = points[toward[points].argmax()]
        text = plain_number(float(level), 4)
        markers.append(Marker(int(mesh.faces[face[best], 0]), text, CURVE[0], curves.points[best], disc=False))
    return markers


def signed_picture(result: Result, look: Look = AUTOMATIC) -> Picture:
    """Draw signed distance in diverging colors, white at zero, with isolines and the curve on top.

    Parameters
    ----------
    result : Result
        Of `signed_distance`.
    look : Look
        View, width, colors and isolines.

    Returns
    -------
    (height, width, 3) array, uint8

    Raises
    ------
    RenderError
        If there is no OpenGL on this machine.
    """
    mesh, values, sources = result.mesh, np.asarray(result["signed_distance"]), result.sources
    known = np.abs(values[np.isfinite(values)])
    largest = float(known.max(initial=0.0))
    spacing = round_spacing(2 * largest, SIGNED_ISOLINES) if largest > 0 else 0
    surface = Surface(values, colormap="RdBu_r", symmetric=True, isolines=spacing, label="signed distance [mesh units]")
    curves = []
    if sources is not None:
        segments = sources.positions(mesh)[sources.segments[:, :2]]
        curves = [Curves(segments, *style) for style in (HALO, CURVE)]
    corners = [] if sources is None else mesh.faces[sources.segments[:, 2], 0].tolist()
    panel = Panel(surface=surface, curves=curves)
    return draw(mesh, [panel], view=choose_view(mesh, corners, look), look=look)


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
    view = choose_view(result.mesh, landmarks(result.mesh, [marker.vertex for marker in markers]), look)
    return draw(mesh, [Panel(surface=Surface(colors, "face"), markers=markers)], view=view, look=look)


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
