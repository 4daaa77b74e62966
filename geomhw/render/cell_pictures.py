"""Pictures of Voronoi cells, pieces of a mesh and sample points."""

from collections.abc import Sequence

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.mesh.surface_points import SurfacePoints
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.render.layers import Curves, Panel, Surface
from geomhw.render.look import AUTOMATIC, Look
from geomhw.render.panels import Picture, draw
from geomhw.render.source_marks import SOURCE_COLOR, source_marks
from geomhw.render.view import choose_view
from geomhw.results import Result

#: Colors of cells, RGB from 0 to 255, and of faces without a site. Cells that share a border differ in color.
CELLS = np.array(
    [
        (166, 206, 227),
        (253, 191, 111),
        (178, 223, 138),
        (202, 178, 214),
        (251, 154, 153),
        (255, 237, 138),
        (199, 233, 228),
        (229, 196, 148),
    ]
)
NO_CELL = (184, 189, 196)
#: Color and width of borders.
BORDER = ("#14171c", 2.5)


def cells_picture(
    result: Result, pieces: Floats, piece_labels: Ints, borders: Floats, look: Look = AUTOMATIC
) -> Picture:
    """Draw Voronoi cells with their borders and sites, one color a cell.

    Parameters
    ----------
    result : Result
        Of `VoronoiCells`.
    pieces, piece_labels, borders : arrays
        As in `VoronoiCells`.
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
    mesh, sites = result.mesh, result.report["sites"]
    label = np.asarray(result["label"])[mesh.faces]
    whole = (label == label[:, :1]).all(axis=1) | (label < 0).any(axis=1)
    n, corners = mesh.n_vertices, pieces.reshape(-1, 3)
    faces = np.concatenate([mesh.faces[whole], n + np.arange(len(corners)).reshape(-1, 3)])
    owners = np.concatenate([label[whole, 0], piece_labels])
    divided = TriangleMesh(np.concatenate([mesh.vertices, corners]), faces)
    numbers = _colors(len(sites), result.report["dual_edges"])
    colors = np.where((owners >= 0)[:, None], CELLS[numbers[owners]], NO_CELL)
    markers, curves = source_marks(result, SOURCE_COLOR)
    panel = Panel(
        surface=Surface(colors.astype(np.uint8), "face"),
        markers=markers,
        curves=[Curves(borders, *BORDER), *curves],
    )
    return draw(divided, [panel], view=choose_view(mesh, [marker.vertex for marker in markers], look), look=look)


def pieces_picture(result: Result, look: Look = AUTOMATIC) -> Picture:
    """Draw the pieces of a mesh, the face array ``piece``, one color each, with their boundaries.

    Errors are those of `cells_picture`.
    """
    mesh = result.mesh
    colors = CELLS[np.asarray(result["piece"]) % len(CELLS)]
    borders = mesh.vertices[mesh.edges[mesh.edge_table.face_counts == 1]]
    panel = Panel(surface=Surface(colors.astype(np.uint8), "face"), curves=[Curves(borders, *BORDER)])
    return draw(mesh, [panel], look=look)


def samples_picture(mesh: TriangleMesh, points: SurfacePoints, look: Look = AUTOMATIC) -> Picture:
    """Draw sample points on a mesh; errors are those of `cells_picture`."""
    markers, curves = source_marks(Result(mesh, sources=points), SOURCE_COLOR)
    return draw(mesh, [Panel(markers=markers, curves=curves)], look=look)


def _colors(k: int, edges: Sequence[tuple[int, int]]) -> Ints:
    """Return the number of a color for each cell; cells joined by an edge differ while there are enough colors."""
    neighbors: list[list[int]] = [[] for _ in range(k)]
    for i, j in edges:
        neighbors[j].append(i)
    colors = np.zeros(k, dtype=np.int64)
    for i in range(k):
        used = np.bincount(colors[neighbors[i]], minlength=len(CELLS))
        # The first color that no neighbor has, from another start for each cell, so that all are in use.
        turn = (i + np.arange(len(CELLS))) % len(CELLS)
        colors[i] = turn[used[turn].argmin()]
    return colors
