"""Picture of approximate Killing fields: arrows, one panel per field, over its length."""

import numpy as np

from geomhw.render.colors import plain_number
from geomhw.render.layers import Arrows, Panel, Surface, arrow_scale
from geomhw.render.look import AUTOMATIC, Look
from geomhw.render.panels import Picture, draw
from geomhw.results import Result

#: Fields in a picture, at most, and the spacing of arrows as a fraction of the panel.
SHOWN, SPACING = 6, 0.045


def killing_picture(result: Result, look: Look = AUTOMATIC, size: tuple[int, int] | None = None) -> Picture:
    """Draw the first fields of least deformation, at most six.

    Parameters
    ----------
    result : Result
        Of `geomhw.spectral.killing_fields`.
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
    killing = result.report["gap"]["fields"]
    panels = []
    for i, (field, strain) in enumerate(zip(result.fields[:SHOWN], result.report["relative_strains"], strict=False)):
        vectors = np.asarray(field.values)
        length = np.linalg.norm(vectors, axis=1)
        kind = "Killing field" if i < killing else "field"
        title = f"{kind} {i}, relative strain {plain_number(strain, 3)}"
        surface = Surface(length, "face", span=(0.25, 1.0), limits=(0.0, float(length.max())), label="length")
        panels.append(Panel(title, surface, arrows=[Arrows(vectors, scale=arrow_scale(vectors), spacing=SPACING)]))
    return draw(result.mesh, panels, size, columns=min(len(panels), 3), look=look)
