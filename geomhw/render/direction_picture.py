"""Picture of a direction field: arrows, lines or crosses, and its singularities by sign."""

import numpy as np

from geomhw.arrays import Floats
from geomhw.render.glyphs import spread
from geomhw.render.layers import Arrows, Curves, Marker, Panel, Surface
from geomhw.render.look import AUTOMATIC, Look
from geomhw.render.panels import Picture, draw
from geomhw.results import Result

#: Colors of singularities of positive and negative index, and of the directions.
POSITIVE, NEGATIVE, DIRECTIONS = "#d62728", "#0b57d0", "#14171c"
#: Distance of crosses, and their arms, as fractions of the diagonal of the bounding box.
SPACING, ARM = 0.03, 0.012


def direction_picture(result: Result, look: Look = AUTOMATIC, size: tuple[int, int] | None = None) -> Picture:
    """Draw a direction field with its singularities: red for a positive index, blue for a negative one.

    Parameters
    ----------
    result : Result
        Of `geomhw.directions.DirectionFields`.
    look, size
        As in `geodesic_picture`.

    Returns
    -------
    (height, width, 3) array, uint8

    Raises
    ------
    RenderError
        If there is no OpenGL on this machine.
    """
    count, found = result.report["directions"], result.report["singularities"]
    markers = []
    for item in found:
        vertex = item.get("vertex", -1)
        nearest = vertex if vertex >= 0 else int(result.mesh.faces[item["face"], 0])
        point = None if vertex >= 0 else np.array(item["position"])
        markers.append(Marker(nearest, "", POSITIVE if item["index"] > 0 else NEGATIVE, point))
    numbers = sorted({item["index"] for item in found}, reverse=True)
    totals = [f"{sum(item['index'] == number for item in found)} of index {number:+g}" for number in numbers]
    note = f"red +, blue -: {', '.join(totals)}" if totals else "no singularities"
    title = "direction field" if count == 1 else f"field of {count} directions"
    names = ["direction"] if count == 1 else [f"direction_{k}" for k in range(count)]
    directions = np.stack([np.asarray(result[name]) for name in names])
    arrows = [Arrows(directions[0], "vertex", DIRECTIONS, spacing=SPACING)] if count == 1 else []
    curves = [] if count == 1 else [Curves(_crosses(result, directions), DIRECTIONS, 1.6)]
    panel = Panel(title, Surface(), arrows=arrows, curves=curves, markers=markers, note=note)
    return draw(result.mesh, [panel], size, look=look)


def _crosses(result: Result, directions: Floats) -> Floats:
    """Segments, (s, 2, 3), from thinned vertices along each of the directions, (n, n_vertices, 3)."""
    mesh = result.mesh
    diagonal = float(np.linalg.norm(np.ptp(mesh.vertices[mesh.faces].reshape(-1, 3), axis=0)))
    used = np.flatnonzero(directions[0].any(axis=1))
    kept = used[spread(mesh.vertices[used], SPACING * diagonal)]
    arms = ARM * diagonal * directions[:, kept]
    starts = np.broadcast_to(mesh.vertices[kept], arms.shape)
    return np.stack([starts, starts + arms], axis=2).reshape(-1, 2, 3)
