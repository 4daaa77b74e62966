"""The picture of transported vectors: bright arrows on a dark surface, one panel a time."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from geomhw.mesh.arrays import Floats
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.render.layers import LIGHT, Arrows, Marker, Panel, Surface, Theme
from geomhw.render.panels import draw
from geomhw.render.scene import Image
from geomhw.render.view import View, choose_view
from geomhw.results import Result

DARK_SURFACE = "#3a414d"
FIELD_COLOR = "#7fd4ff"
SOURCE_COLOR = "#ffb000"
#: Spacing of arrows, and length of the source's, as fractions of the panel.
SPACING = 0.042
SOURCE_LENGTH = 0.13
#: Room round the mesh, a share of its larger extent: half a source's arrow sticks out where the source is on the rim.
ROOM = 0.8 * SOURCE_LENGTH
#: More panels than this go into several rows.
MOST_IN_A_ROW = 4


def transport_picture(result: Result, size: tuple[int, int] | None = None, theme: Theme = LIGHT) -> Image:
    """The transported field for each time, side by side, with the sources marked and the vectors there large.

    The view shows as many sources as it can; one that lies behind is a ring.
    """
    times = np.atleast_1d(np.asarray(result["dt"]))
    names = ["transported"] if len(times) == 1 else [f"transported_{k}" for k in range(len(times))]
    sources = [int(source) for source in result.report["sources"]]
    panels = []
    for name, step in zip(names, result.report["times"], strict=True):
        field = np.asarray(result[name])
        longest = float(np.linalg.norm(field, axis=1).max()) or 1.0
        # A layer each, since arrows of one layer that come too close are thinned out.
        large = [
            Arrows(_only(field, source), "vertex", SOURCE_COLOR, scale=longest, spacing=SOURCE_LENGTH)
            for source in sources
        ]
        panels.append(
            Panel(
                f"transported, dt = {step['t']:.4g} = {step['t_over_h2']:.3g} h²",
                Surface(color=DARK_SURFACE),
                arrows=[Arrows(field, "vertex", FIELD_COLOR, scale=longest, spacing=SPACING), *large],
                markers=[Marker(source, color=SOURCE_COLOR) for source in sources],
            )
        )
    columns = None if len(panels) <= MOST_IN_A_ROW else MOST_IN_A_ROW
    return draw(result.mesh, panels, size, columns, _roomy_view(result.mesh, sources), theme)


def _roomy_view(mesh: TriangleMesh, sources: Sequence[int]) -> View:
    """The view that shows most of the sources, from a little farther away."""
    view = choose_view(mesh, sources)
    return replace(view, extent=view.extent + ROOM * view.extent.max())


def _only(field: Floats, vertex: int) -> Floats:
    """The field at one vertex, zero elsewhere."""
    only = np.zeros_like(field)
    only[vertex] = field[vertex]
    return only
