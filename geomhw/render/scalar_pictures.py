"""Pictures of functions on vertices, with the gradient or marks of extrema."""

import numpy as np

from geomhw.render.layers import Arrows, Panel, Surface, arrow_scale
from geomhw.render.look import AUTOMATIC, Look
from geomhw.render.panels import Picture, draw
from geomhw.results import Result

#: Spacing of arrows as a fraction of the panel.
SPACING = 0.04


def scalar_picture(result: Result, look: Look = AUTOMATIC, size: tuple[int, int] | None = None) -> Picture:
    """Draw the first functions on vertices, one a panel, and the first vector field per face over the first one.

    Without a function, the length of the first vector field per vertex is drawn.

    Parameters
    ----------
    result : Result
        With a field per vertex.
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
    vectors = [np.asarray(field.values) for field in result.fields if field.location == "face"]
    panels: list[Panel] = []
    for field in result.fields:
        values = np.asarray(field.values)
        if field.location == "vertex" and values.ndim == 1 and len(panels) < 6:
            arrows = [Arrows(vectors[0], scale=arrow_scale(vectors[0]), spacing=SPACING)] if vectors else []
            panels.append(Panel(field.name, Surface(values.astype(float), label=field.name), arrows=arrows))
            vectors = []
    if not panels:
        field = next(field for field in result.fields if field.location == "vertex")
        length = np.linalg.norm(np.asarray(field.values), axis=1)
        panels.append(Panel(field.name, Surface(length, label=f"length of {field.name}")))
    return draw(result.mesh, panels, size, columns=min(3, len(panels)), look=look)
