"""Picture of transported vectors: bright arrows on a dark surface, one panel per diffusion time."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from geomhw.arrays import Floats
from geomhw.mesh.surface_points import SurfacePoints
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.options import PANEL_WIDTH
from geomhw.render.colors import plain_number
from geomhw.render.layers import LIGHT, Arrows, Panel, Surface, Theme
from geomhw.render.panels import draw
from geomhw.render.scene import Image
from geomhw.render.source_marks import MOST_DISCS, source_marks
from geomhw.render.view import View, choose_view
from geomhw.results import Result

DARK_SURFACE = "#3a414d"
FIELD_COLOR = "#7fd4ff"
SOURCE_COLOR = "#ffb000"
#: Spacing of arrows, and length of the arrows at sources, as fractions of the panel.
SPACING = 0.042
SOURCE_LENGTH = 0.13
#: Margin around the mesh, a fraction of its larger extent: the arrow of a source on the rim sticks out.
ROOM = 0.8 * SOURCE_LENGTH
#: Largest number of panels in a row.
MOST_IN_A_ROW = 4


def transport_picture(
    result: Result, size: tuple[int, int] | None = None, theme: Theme = LIGHT, width: int = PANEL_WIDTH
) -> Image:
    """Draw the transported field, one panel per diffusion time, with marked sources and large arrows at them.

    Parameters
    ----------
    result : Result
        Of `VectorHeat` or `transport_over_times`.
    size, theme, width
        As in `geodesic_picture`.

    Returns
    -------
    (height, width, 3) array, uint8
        A ring marks a hidden source. Many sources are drawn as curves, with thinned arrows.

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
    marks, curves = source_marks(result, SOURCE_COLOR)
    panels = []
    for name, step in zip(names, steps, strict=True):
        field = np.asarray(result[name])
        longest = float(np.linalg.norm(field, axis=1).max()) or 1.0
        large = _large_arrows(result, longest)
        panels.append(
            Panel(
                f"transported, dt = {plain_number(step['t'], 4)} = {plain_number(step['t_over_h2'], 3)} h²",
                Surface(color=DARK_SURFACE),
                arrows=[Arrows(field, "vertex", FIELD_COLOR, scale=longest, spacing=SPACING), *large],
                markers=marks,
                curves=curves,
            )
        )
    columns = None if len(panels) <= MOST_IN_A_ROW else MOST_IN_A_ROW
    view = _roomy_view(result.mesh, [mark.vertex for mark in marks])
    return draw(result.mesh, panels, size, columns, view, theme, width)


def _roomy_view(mesh: TriangleMesh, sources: Sequence[int]) -> View:
    """Choose the view that shows most sources, with a margin for their arrows."""
    view = choose_view(mesh, sources)
    return replace(view, extent=view.extent + ROOM * view.extent.max())


def _large_arrows(result: Result, longest: float) -> list[Arrows]:
    """Return the arrows at sources, one layer per source if they are few, since each layer is thinned."""
    sources, vectors = result.sources, result.source_vectors
    if sources is None or vectors is None:
        return []
    every = np.arange(len(sources))
    batches = every[:, None] if len(every) <= MOST_DISCS else every[None]
    layers = []
    for batch in batches:
        for inside in (False, True):
            which = batch[(sources.faces[batch] >= 0) == inside]
            if len(which):
                layers.append(_layer(result.mesh, sources[which], vectors[which], inside, longest))
    return layers


def _layer(mesh: TriangleMesh, sources: SurfacePoints, vectors: Floats, inside: bool, longest: float) -> Arrows:
    """Return arrows at sources that are all vertices or all in faces."""
    rows = sources.faces if inside else sources.corners[:, 0]
    places = np.array(mesh.face_centers if inside else mesh.vertices)
    arrows = np.zeros_like(places)
    arrows[rows], places[rows] = vectors, sources.positions(mesh)
    return Arrows(arrows, "face" if inside else "vertex", SOURCE_COLOR, longest, SOURCE_LENGTH, places)
