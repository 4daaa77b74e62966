"""Picture of transported vectors: arrows on a light surface, one panel per diffusion time."""

from dataclasses import replace

import numpy as np

from geomhw.arrays import Floats
from geomhw.render.colors import plain_number
from geomhw.render.layers import Arrows, Panel, Surface
from geomhw.render.look import AUTOMATIC, Look
from geomhw.render.panels import Picture, draw
from geomhw.render.source_marks import source_marks
from geomhw.render.view import choose_view, landmarks
from geomhw.results import Result

FIELD_COLOR = "#1e5aa8"
SOURCE_COLOR = "#d9480f"
#: Spacing of arrows, and length of the longest one, as fractions of the panel.
SPACING, LENGTH = 0.042, 0.06
#: Margin around the mesh, a fraction of its larger extent: the arrow of a source on the rim sticks out.
ROOM = 2 * LENGTH
#: Largest number of panels in a row.
MOST_IN_A_ROW = 4


def transport_picture(result: Result, look: Look = AUTOMATIC, size: tuple[int, int] | None = None) -> Picture:
    """Draw the transported field, one panel per diffusion time, with the sources and their vectors.

    Parameters
    ----------
    result : Result
        Of `VectorHeat` or `transport_over_times`.
    look, size
        As in `geodesic_picture`.

    Returns
    -------
    (height, width, 3) array, uint8
        All arrows have one scale. A ring marks a source that the surface hides. Many sources are drawn as curves, with
        thinned arrows.

    Raises
    ------
    RenderError
        If there is no OpenGL on this machine.

    Examples
    --------
    >>> from geomhw.mesh import icosphere
    >>> from geomhw.transport import VectorHeat
    >>> result = VectorHeat(icosphere(3), "h2").from_vertices([0], [[1, 0, 0]])
    >>> picture = transport_picture(result)
    """
    steps = result.report.get("times") or [result.report["time"]]
    names = ["transported"] if len(steps) == 1 else [f"transported_{k}" for k in range(len(steps))]
    marks, curves = source_marks(result, SOURCE_COLOR, labels=True)
    vectors = np.zeros((0, 3)) if result.source_vectors is None else np.asarray(result.source_vectors)
    panels = []
    for name, step in zip(names, steps, strict=True):
        field = np.asarray(result[name])
        lengths = np.linalg.norm(np.concatenate([field, vectors]), axis=1)
        longest = float(lengths.max()) or 1.0
        scale = longest * SPACING / LENGTH
        arrows = [Arrows(field, "vertex", FIELD_COLOR, scale=scale, spacing=SPACING)]
        marked = marks
        if len(marks) == len(vectors):
            marked = [
                replace(mark, vector=LENGTH / longest * v, label=_label(mark.label, v))
                for mark, v in zip(marks, vectors, strict=True)
            ]
        elif result.sources is not None:
            arrows.append(_at_sources(result, scale))
        title = f"transported, dt = {plain_number(step['t'], 4)} = {plain_number(step['t_over_h2'], 3)} h²"
        panels.append(Panel(title, Surface(), arrows=arrows, markers=marked, curves=curves))
    columns = None if len(panels) <= MOST_IN_A_ROW else MOST_IN_A_ROW
    sources = [mark.vertex for mark in marks]
    view = choose_view(result.mesh, landmarks(result.mesh, sources), look)
    view = replace(view, extent=view.extent + ROOM * view.extent.max())
    return draw(result.mesh, panels, size, columns, view, look)


def _label(label: str, vector: Floats) -> str:
    """Return the label of a source with the length of its vector."""
    return f"{label}, |v| = {plain_number(float(np.linalg.norm(vector)), 3)}" if label else ""


def _at_sources(result: Result, scale: float) -> Arrows:
    """Return the vectors of many sources as thinned arrows."""
    assert result.sources is not None
    rows = result.sources.corners[np.arange(len(result.sources)), result.sources.weights.argmax(axis=1)]
    places, arrows = np.array(result.mesh.vertices), np.zeros((result.mesh.n_vertices, 3))
    arrows[rows], places[rows] = result.source_vectors, result.sources.positions(result.mesh)
    return Arrows(arrows, "vertex", SOURCE_COLOR, scale, SPACING, places)
