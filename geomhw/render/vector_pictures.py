"""The picture of transported vectors: bright arrows on a dark surface, one panel a time."""

import numpy as np

from geomhw.mesh.arrays import Floats
from geomhw.render.layers import LIGHT, Arrows, Panel, Surface, Theme
from geomhw.render.panels import draw
from geomhw.render.scene import Image
from geomhw.results import Result

DARK_SURFACE = "#3a414d"
FIELD_COLOR = "#7fd4ff"
SOURCE_COLOR = "#ffb000"
#: Spacing of arrows, and length of the source's, as fractions of the panel.
SPACING = 0.042
SOURCE_LENGTH = 0.15
#: More panels than this go into several rows.
MOST_IN_A_ROW = 4


def transport_picture(result: Result, size: tuple[int, int] | None = None, theme: Theme = LIGHT) -> Image:
    """The transported field for each time, side by side, with the vectors at the sources large."""
    times = np.atleast_1d(np.asarray(result["dt"]))
    names = ["transported"] if len(times) == 1 else [f"transported_{k}" for k in range(len(times))]
    panels = []
    for name, step in zip(names, result.report["times"], strict=True):
        field = np.asarray(result[name])
        longest = float(np.linalg.norm(field, axis=1).max())
        panels.append(
            Panel(
                f"transported, dt = {step['t']:.4g} = {step['t_over_h2']:.3g} h²",
                Surface(color=DARK_SURFACE),
                arrows=[
                    Arrows(field, "vertex", FIELD_COLOR, scale=longest or 1.0, spacing=SPACING),
                    Arrows(_at_sources(result, field), "vertex", SOURCE_COLOR, spacing=SOURCE_LENGTH),
                ],
            )
        )
    columns = None if len(panels) <= MOST_IN_A_ROW else MOST_IN_A_ROW
    return draw(result.mesh, panels, size, columns, theme=theme)


def _at_sources(result: Result, field: Floats) -> Floats:
    """The field at the sources, zero elsewhere."""
    only = np.zeros_like(field)
    only[result.report["sources"]] = field[result.report["sources"]]
    return only
