"""Pictures of panels in a row or a grid, each with a title, the mesh and a color bar."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from geomhw.arrays import Floats
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.options import PANEL_WIDTH
from geomhw.render import annotate
from geomhw.render.colors import shade
from geomhw.render.layers import LIGHT, Arrows, Marker, Panel, Theme
from geomhw.render.scene import SUPERSAMPLING, Image, Stage
from geomhw.render.view import View, choose_view, visible

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


class Drawing:
    """A sheet of panels with an open window, for the frames of a film.

    panels: those of the first frame; later frames have the same number. size: of the picture, in pixels; by default
    panels have the given ``width`` and the height that the mesh needs. columns: number of panels in a row; by default
    all are in one row, and those of a wide mesh are stacked and twice as wide.

    >>> from geomhw.mesh import icosphere
    >>> from geomhw.render.layers import Panel, Surface
    >>> mesh = icosphere(2)
    >>> frames = [[Panel("height", Surface(k * mesh.vertices[:, 2]))] for k in (1, 2)]
    >>> with Drawing(mesh, frames[0], width=120) as drawing:
    ...     images = [drawing(panels) for panels in frames]
    """

    def __init__(
        self,
        mesh: TriangleMesh,
        panels: Sequence[Panel],
        size: tuple[int, int] | None = None,
        columns: int | None = None,
        view: View | None = None,
        theme: Theme = LIGHT,
        width: int = PANEL_WIDTH,
    ) -> None:
        view = view or choose_view(mesh, [marker.vertex for panel in panels for marker in panel.markers])
        self.columns = columns or (1 if view.aspect > WIDE else len(panels))
        rows = -(-len(panels) // self.columns)
        self.layout = _layout(panels, view, size and (size[0] // self.columns, size[1] // rows), width)
        self.size = size or (self.columns * self.layout.width, rows * self.layout.height)
        self.stage = Stage(mesh, (self.layout.width, self.layout.stage), view, theme)

    def __call__(self, panels: Sequence[Panel]) -> Image:
        """Draw the panels; return the picture, (height, width, 3)."""
        from PIL import Image as Pillow

        sheet = Pillow.new("RGB", self.size, self.stage.theme.background)
        for number, panel in enumerate(panels):
            row, column = divmod(number, self.columns)
            corner = (column * self.layout.width, row * self.layout.height)
            sheet.paste(_panel(self.stage, panel, self.layout), corner)
        return np.asarray(sheet)

    def __enter__(self) -> "Drawing":
        return self

    def __exit__(self, *reason: object) -> None:
        self.stage.__exit__(*reason)


def draw(
    mesh: TriangleMesh,
    panels: Sequence[Panel],
    size: tuple[int, int] | None = None,
    columns: int | None = None,
    view: View | None = None,
    theme: Theme = LIGHT,
    width: int = PANEL_WIDTH,
) -> Image:
    """Draw one picture, (height, width, 3); the arguments are those of `Drawing`."""
    with Drawing(mesh, panels, size, columns, view, theme, width) as drawing:
        return drawing(panels)


def _layout(panels: Sequence[Panel], view: View, size: tuple[int, int] | None, width: int) -> Layout:
    """Choose the heights of the parts of a panel."""
    single = view.aspect > WIDE
    flattest, tallest = (round(share * width) for share in STAGE_HEIGHT)
    width = size[0] if size else width * (2 if single else 1)
    text = int(np.clip(width // 36, 9, 18))
    title = round(2.6 * text) if any(panel.title for panel in panels) else 0
    bar = round(3.4 * text) if any(panel.surface.values is not None and panel.surface.bar for panel in panels) else 0
    noted = any(panel.note or _scaled(panel) for panel in panels)
    note = round(1.8 * text) if noted else 0
    fitting = int(np.clip(width / view.aspect * 1.08, flattest, tallest))
    stage = max(size[1] - title - bar - note, 16) if size else fitting
    return Layout(width, stage, text, title, bar, note)


def _panel(stage: Stage, panel: Panel, layout: Layout) -> Any:
    """Draw a panel as a Pillow image."""
    from PIL import Image as Pillow
    from PIL import ImageDraw

    shades = shade(panel.surface, stage.mesh)
    large = Pillow.fromarray(stage.photograph(panel.surface, panel.arrows, shades, panel.streaks, panel.curves))
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
    box = (8, bottom + layout.bar, layout.width - 8, layout.height)
    if panel.note:
        annotate.title(pen, panel.note, box, layout.text, stage.theme)
    elif scaled := _scaled(panel):
        length = 2 * scaled.spacing * min(stage.size)
        annotate.arrow_key(pen, length, f"{2 * (scaled.scale or 0):.3g}", box, layout.text, stage.theme)
    _label(sheet, stage, panel.markers, layout)
    return sheet


def _scaled(panel: Panel) -> Arrows | None:
    """Return the arrows drawn to scale, whose key replaces the note."""
    return next((arrows for arrows in panel.arrows if arrows.scale is not None), None)


def _mark(pen: Any, stage: Stage, markers: Sequence[Marker], layout: Layout) -> None:
    """Draw markers in the supersampled picture."""
    points = _positions(stage, markers)
    seen = visible(stage.mesh, stage.view, [marker.vertex for marker in markers], points)
    places = stage.pixels(points) * SUPERSAMPLING
    for marker, place, shown in zip(markers, places, seen, strict=True):
        annotate.disc(pen, place, 0.4 * layout.text * SUPERSAMPLING, marker.color, not shown)


def _positions(stage: Stage, markers: Sequence[Marker]) -> Floats:
    """Return the positions of markers, (k, 3)."""
    return np.array([marker.position(stage.mesh.vertices) for marker in markers]).reshape(-1, 3)


def _label(sheet: Any, stage: Stage, markers: Sequence[Marker], layout: Layout) -> None:
    """Draw the labels of markers."""
    places = stage.pixels(_positions(stage, markers))
    places[:, 1] += layout.title
    texts = [(marker.label, marker.color, place) for marker, place in zip(markers, places, strict=True)]
    box = (4, layout.title, layout.width - 4, layout.title + layout.stage)
    annotate.labels(sheet, texts, box, round(1.05 * layout.text), stage.theme)
