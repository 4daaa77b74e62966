"""A picture from a description: panels in a row or a grid, each with a title, the mesh and a color bar."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.render import annotate
from geomhw.render.colors import shade
from geomhw.render.layers import LIGHT, Marker, Panel, Theme
from geomhw.render.scene import SUPERSAMPLING, Image, Stage
from geomhw.render.view import View, choose_view, visible

#: Width of a panel, and how tall and how flat its stage may get, in pixels.
PANEL_WIDTH = 600
STAGE_HEIGHT = (200, 640)
#: A mesh this much wider than tall has its panels one below the other.
WIDE = 3.0


@dataclass(frozen=True)
class Layout:
    """Pixels of one panel: a title, the stage, a color bar, and a note, from top to bottom."""

    width: int
    stage: int
    text: int
    title: int
    bar: int
    note: int

    @property
    def height(self) -> int:
        """The whole panel's."""
        return self.title + self.stage + self.bar + self.note


def draw(
    mesh: TriangleMesh,
    panels: Sequence[Panel],
    size: tuple[int, int] | None = None,
    columns: int | None = None,
    view: View | None = None,
    theme: Theme = LIGHT,
) -> Image:
    """The picture, (height, width, 3).

    size: of the whole picture, in pixels; None makes panels 600 wide and as tall as the mesh needs.
    columns: panels in a row; None puts all in one row, or wide meshes one below the other.
    """
    view = view or choose_view(mesh, [marker.vertex for panel in panels for marker in panel.markers])
    if columns is None:
        columns = 1 if view.aspect > WIDE else len(panels)
    rows = -(-len(panels) // columns)
    layout = _layout(panels, view, size and (size[0] // columns, size[1] // rows))
    width, height = size or (columns * layout.width, rows * layout.height)
    from PIL import Image as Pillow

    sheet = Pillow.new("RGB", (width, height), theme.background)
    with Stage(mesh, (layout.width, layout.stage), view, theme) as stage:
        for number, panel in enumerate(panels):
            row, column = divmod(number, columns)
            sheet.paste(_panel(stage, panel, layout), (column * layout.width, row * layout.height))
    return np.asarray(sheet)


def _layout(panels: Sequence[Panel], view: View, size: tuple[int, int] | None) -> Layout:
    single = view.aspect > WIDE
    width = size[0] if size else PANEL_WIDTH * (2 if single else 1)
    text = int(np.clip(width // 36, 9, 18))
    title = round(2.6 * text) if any(panel.title for panel in panels) else 0
    bar = round(3.4 * text) if any(panel.surface.values is not None and panel.surface.bar for panel in panels) else 0
    note = round(1.8 * text) if any(panel.note for panel in panels) else 0
    if size:
        stage = max(size[1] - title - bar - note, 16)
    else:
        stage = int(np.clip(width / view.aspect * 1.08, *STAGE_HEIGHT))
    return Layout(width, stage, text, title, bar, note)


def _panel(stage: Stage, panel: Panel, layout: Layout) -> Any:
    from PIL import Image as Pillow
    from PIL import ImageDraw

    shades = shade(panel.surface, stage.mesh)
    large = Pillow.fromarray(stage.photograph(panel.surface, shades, panel.arrows))
    _mark(ImageDraw.Draw(large), stage, panel.markers, layout)
    sheet = Pillow.new("RGB", (layout.width, layout.height), stage.theme.background)
    sheet.paste(large.resize(stage.size, Pillow.Resampling.BOX), (0, layout.title))
    pen = ImageDraw.Draw(sheet)
    if panel.title:
        annotate.title(pen, panel.title, (8, 0, layout.width - 8, layout.title), round(1.2 * layout.text), stage.theme)
    bottom = layout.title + layout.stage
    if shades is not None and not shades.rgb and panel.surface.bar:
        box = (0.16 * layout.width, bottom + 0.5 * layout.text, 0.84 * layout.width, bottom + layout.bar)
        annotate.color_bar(pen, shades, panel.surface.label, box, layout.text, stage.theme)
    if panel.note:
        box = (8, bottom + layout.bar, layout.width - 8, layout.height)
        annotate.title(pen, panel.note, box, layout.text, stage.theme)
    _label(sheet, stage, panel.markers, layout)
    return sheet


def _mark(pen: Any, stage: Stage, markers: Sequence[Marker], layout: Layout) -> None:
    """Discs, in the large picture, so that they are smoothed with it."""
    vertices = [marker.vertex for marker in markers]
    seen = visible(stage.mesh, stage.view, vertices)
    places = stage.pixels(stage.mesh.vertices[vertices]) * SUPERSAMPLING
    for marker, place, shown in zip(markers, places, seen, strict=True):
        annotate.disc(pen, place, 0.4 * layout.text * SUPERSAMPLING, marker.color, not shown)


def _label(sheet: Any, stage: Stage, markers: Sequence[Marker], layout: Layout) -> None:
    places = stage.pixels(stage.mesh.vertices[[marker.vertex for marker in markers]]) + [0, layout.title]
    texts = [(marker.label, marker.color, place) for marker, place in zip(markers, places, strict=True)]
    box = (4, layout.title, layout.width - 4, layout.title + layout.stage)
    annotate.labels(sheet, texts, box, round(1.05 * layout.text), stage.theme)
