"""Pictures of tangent fields: the bracket of two, the derivatives of one, and approximate Killing fields."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from geomhw.arrays import Floats
from geomhw.render.colors import plain_number
from geomhw.render.layers import Arrows, Panel, Surface, arrow_scale
from geomhw.render.look import AUTOMATIC, Look
from geomhw.render.panels import Picture, draw
from geomhw.results import Result

if TYPE_CHECKING:
    from geomhw.flow.streamline_polylines import Streamlines

#: Spacing of arrows as a fraction of the panel.
SPACING, KILLING_SPACING = 0.04, 0.045
#: Killing fields in a picture, at most.
SHOWN = 6


def bracket_picture(result: Result, look: Look = AUTOMATIC, size: tuple[int, int] | None = None) -> Picture:
    """Draw two fields and their bracket, over its length.

    Parameters
    ----------
    result : Result
        With the face fields ``first``, ``second`` and ``bracket``.
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
    length = np.linalg.norm(np.asarray(result["bracket"]), axis=1)
    over = Surface(length, "face", span=(0.25, 1.0), label="length of the bracket")
    panels = [
        _arrows(result, "field U", "first", Surface()),
        _arrows(result, "field V", "second", Surface()),
        _arrows(result, "bracket [U, V]", "bracket", over),
    ]
    return draw(result.mesh, panels, size, columns=3, look=look)


def derivative_picture(result: Result, look: Look = AUTOMATIC, size: tuple[int, int] | None = None) -> Picture:
    """Draw a field and its derivatives.

    Parameters
    ----------
    result : Result
        Of `geomhw.flow.derivatives_of`.
    look, size
        As in `geodesic_picture`.

    Returns
    -------
    (height, width, 3) array, uint8
        Six panels: the field, its covariant derivative, divergence, curl, length of the strain and Hodge Laplacian.

    Raises
    ------
    RenderError
        If there is no OpenGL on this machine.
    """
    stretch = np.linalg.norm(np.asarray(result["strain"]), axis=1)
    panels: Sequence[Panel] = [
        _arrows(result, "field V", "field", Surface()),
        _arrows(result, "covariant derivative along U", "covariant_derivative", Surface()),
        _arrows(result, "Hodge Laplacian", "hodge_laplacian", Surface()),
        Panel("divergence", Surface(result["divergence"], colormap="PiYG", symmetric=True, label="divergence")),
        Panel("curl", Surface(result["curl"], colormap="PuOr", symmetric=True, label="curl")),
        Panel("strain", Surface(stretch, "face", label="length of the strain tensor")),
    ]
    return draw(result.mesh, panels, size, columns=3, look=look)


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
        length = np.linalg.norm(np.asarray(field.values), axis=1)
        kind = "Killing field" if i < killing else "field"
        title = f"{kind} {i}, relative strain {plain_number(strain, 3)}"
        surface = Surface(length, "face", span=(0.25, 1.0), limits=(0.0, float(length.max())), label="length")
        panels.append(_arrows(result, title, field.name, surface, KILLING_SPACING))
    return draw(result.mesh, panels, size, columns=min(len(panels), 3), look=look)


def streamlines_picture(lines: "Streamlines", velocity: Floats, look: Look = AUTOMATIC) -> Picture:
    """Draw streamlines with heads, over the speed.

    Parameters
    ----------
    lines : Streamlines
    velocity : (m, 3) array
        The field that they follow.
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
    speed = np.linalg.norm(velocity, axis=1)
    surface = Surface(speed, "face", span=(0.25, 1.0), outliers=0.01, label="speed [mesh units/time]")
    arrows = Arrows(velocity, style="streamlines", lines=lines, spacing=SPACING)
    return draw(lines.mesh, [Panel(surface=surface, arrows=[arrows])], look=look)


def _arrows(result: Result, title: str, name: str, surface: Surface, spacing: float = SPACING) -> Panel:
    """Return a panel with one face field as arrows."""
    vectors = np.asarray(result[name])
    return Panel(title, surface, arrows=[Arrows(vectors, scale=arrow_scale(vectors), spacing=spacing)])
