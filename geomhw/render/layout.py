"""Sizes of the parts of a panel: title, stage, color bar and note."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from geomhw.render import annotate
from geomhw.render.layers import Arrows, Panel
from geomhw.render.view import View

#: How flat and how tall the stage of a panel may get, in widths.
STAGE_HEIGHT = (1 / 3, 16 / 15)
#: Aspect ratio of a mesh above which panels are stacked.
WIDE = 3.0


@dataclass(frozen=True)
class Layout:
    """Heights in pixels of the parts of a panel, from top to bottom: title, stage, color bar, note."""

    width: int
    stage: int
    text: int
    title: int
    bar: int
    note: int

    @property
    def height(self) -> int:
        """Height of the panel."""
        return self.title + self.stage + self.bar + self.note


def layout_of(panels: Sequence[Panel], view: View, size: tuple[int, int] | None, width: int) -> Layout:
    """Choose the heights of the parts of a panel."""
    single = view.aspect > WIDE
    flattest, tallest = (round(share * width) for share in STAGE_HEIGHT)
    width = size[0] if size else width * (2 if single else 1)
    text = max(width // 36, annotate.SMALLEST)
    title = round(2.6 * text) if any(panel.title for panel in panels) else 0
    bars = [panel.surface for panel in panels if panel.surface.values is not None and panel.surface.bar]
    bars = [surface for surface in bars if np.ndim(np.asarray(surface.values)) == 1]
    bar = round(4.6 * text) if bars else 0
    noted = any(panel.note or scaled_arrows(panel) for panel in panels)
    note = round(1.8 * text) if noted else 0
    fitting = int(np.clip(width / view.aspect * 1.08, flattest, tallest))
    stage = max(size[1] - title - bar - note, 16) if size else fitting
    return Layout(width, stage, text, title, bar, note)


def scaled_arrows(panel: Panel) -> Arrows | None:
    """Return the arrows drawn to scale, whose key replaces the note."""
    return next((arrows for arrows in panel.arrows if arrows.scale is not None and arrows.style == "arrows"), None)
