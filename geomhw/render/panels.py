"""Pictures of panels in a row or a grid, each with a title, the mesh and a color bar.

The one way to draw a mesh with values, lines and points is `draw`:

>>> from geomhw.mesh import icosphere
>>> from geomhw.render.layers import Curves, Marker, Panel, Surface
>>> ball = icosphere(2)
>>> surface = Surface(ball.vertices[:, 2], label="height [mesh units]", isolines=0.25)
>>> lines = Curves(ball.vertices[ball.edges[:9]])
>>> image = draw(ball, [Panel("height", surface, markers=[Marker(0, "start")], curves=[lines])], look=Look(width=200))
>>> image.shape[1:]
(200, 3)
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Floats
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.render import annotate
from geomhw.render.canvas import Box, Canvas, text_width
from geomhw.render.colors import Shades, plain_number, round_below, shade
from geomhw.render.flow_lines import styled
from geomhw.render.layers import Marker, Panel, Surface
from geomhw.render.layout import WIDE, layout_of, scaled_arrows
from geomhw.render.look import AUTOMATIC, Look
from geomhw.render.scene import SUPERSAMPLING, Stage
from geomhw.render.view import View, choose_view, landmarks


class Picture(np.ndarray[Any, np.dtype[np.uint8]]):
    """Pixels, (h, w, 3), or (h, w, 4) with opacity, and the canvas with their texts and shapes."""

    canvas: Canvas

    def __reduce__(self) -> Any:
        """Keep the canvas, which arrays do not pickle."""
        return _picture, (np.asarray(self), self.canvas)


def _picture(pixels: NDArray[np.uint8], canvas: Canvas) -> Picture:
    """Return pixels with their canvas."""
    picture = pixels.view(Picture)
    picture.canvas = canvas
    return picture


def save_vector(path: Path, picture: Picture, dpi: float = 100.0, description: str = "") -> None:
    """Write a picture as SVG or PDF: texts, color bars and marks as vectors over the rendered surface.

    Parameters
    ----------
    path : .svg or .pdf file
    picture : of `draw` or another function of this package.
    dpi : pixels per inch, which set the size on paper.
    description : text kept in the file.
    """
    picture.canvas.save(path, dpi, description)


class Drawing:
    """A sheet of panels with an open window, for the frames of a film.

    Parameters
    ----------
    mesh : TriangleMesh
    panels : those of the first frame; later frames have the same number.
    size : of the picture, in pixels; by default panels have the width of ``look`` and the height that the mesh needs.
    columns : number of panels in a row; by default all are in one row. Those of a wide mesh are stacked and twice as
        wide.
    view : by default chosen by ``look`` and from the mesh, with the sources in sight.
    look : choices of the user.
    sources : vertices that the view shows if possible; by default the vertex of largest y.
    shared : number of panels of a group, which repeats: their color bars and keys are drawn once, below all panels.

    >>> from geomhw.mesh import icosphere
    >>> from geomhw.render.layers import Panel, Surface
    >>> mesh = icosphere(2)
    >>> frames = [[Panel("height", Surface(k * mesh.vertices[:, 2]))] for k in (1, 2)]
    >>> with Drawing(mesh, frames[0], look=Look(width=120)) as drawing:
    ...     images = [drawing(panels) for panels in frames]
    """

    def __init__(
        self,
        mesh: TriangleMesh,
        panels: Sequence[Panel],
        size: tuple[int, int] | None = None,
        columns: int | None = None,
        view: View | None = None,
        look: Look = AUTOMATIC,
        sources: Sequence[int] = (),
        shared: int = 0,
    ) -> None:
        view = view or choose_view(mesh, landmarks(mesh, sources), look)
        panels = [styled(panel, look) for panel in panels]
        self.look, self.shared = look, shared
        self.columns = columns or (1 if view.aspect > WIDE else len(panels))
        rows = -(-len(panels) // self.columns)
        whole = layout_of(panels, view, size and (size[0] // self.columns, size[1] // rows), look.width)
        self.layout = replace(whole, bar=0, note=0) if shared else whole
        self.below = whole.bar + whole.note if shared else 0
        self.size = size or (self.columns * self.layout.width, rows * self.layout.height + self.below)
        self.stage = Stage(mesh, (self.layout.width, self.layout.stage), view, look.theme)

    def __call__(self, panels: Sequence[Panel]) -> Picture:
        """Draw the panels; return the picture, (height, width, 3)."""
        canvas = Canvas(self.size, "" if self.look.transparent else self.look.theme.background)
        layout, styled = self.layout, _styled(panels, self.look)
        shading = [shade(panel.surface, self.stage.mesh) for panel in styled]
        # Arrows need the depth of the surface, which the other panels leave.
        order = sorted(range(len(styled)), key=lambda number: bool(styled[number].arrows or styled[number].streaks))
        drawn = {number: self._panel(styled[number], shading[number]) for number in order}
        for number, (panel, shades) in enumerate(zip(styled, shading, strict=True)):
            row, column = divmod(number, self.columns)
            corner = (column * layout.width, row * layout.height)
            canvas.paste(drawn[number], *corner)
            if number < (self.shared or len(panels)):
                top = self.size[1] - self.below if self.shared else corner[1] + layout.title + layout.stage
                part = self.size[0] // self.shared if self.shared else layout.width
                left = part * number if self.shared else corner[0]
                self._legend(canvas, panel, shades, (left, top, left + part, top + 1))
        return _picture(canvas.pixels(), canvas)

    def __enter__(self) -> "Drawing":
        return self

    def __exit__(self, *reason: object) -> None:
        self.stage.__exit__(*reason)

    def _panel(self, panel: Panel, shades: Shades | None) -> Canvas:
        """Draw a panel without its legend."""
        stage, layout, theme = self.stage, self.layout, self.look.theme
        canvas = Canvas((layout.width, layout.height), theme.background)
        pixels = stage.photograph(panel.surface, panel.arrows, shades, panel.streaks, panel.curves)
        if self.look.transparent:
            shown = stage.covered | (pixels != list(bytes.fromhex(theme.background[1:]))).any(axis=2)
            pixels = np.dstack([pixels, np.where(shown, 255, 0).astype(np.uint8)])
        canvas.image(pixels, (0, layout.title, layout.width, layout.title + layout.stage))
        if panel.title:
            box = (8, 0, layout.width - 8, layout.title)
            annotate.title(canvas, panel.title, box, round(1.2 * layout.text), theme)
        self._mark(canvas, panel.markers)
        return canvas

    def _mark(self, canvas: Canvas, markers: Sequence[Marker]) -> None:
        """Draw markers, their vectors and their labels."""
        if not markers:
            return
        stage, layout, theme = self.stage, self.layout, self.look.theme
        points = np.array([marker.position(stage.mesh.vertices) for marker in markers])
        seen = stage.visible(points)
        places = stage.pixels(points) + np.array([0, layout.title])
        texts: list[tuple[str, str, Floats]] = []
        taken: list[Box] = []
        hinted = False
        for marker, place, shown in zip(markers, places, seen, strict=True):
            if not marker.disc:
                if shown:
                    self._text_at(canvas, marker, place, taken)
                continue
            radius = (0.3 if marker.vector is not None else 0.4) * layout.text
            annotate.disc(canvas, place, radius, marker.color, not shown, theme.halo)
            if marker.vector is not None:
                along = (stage.view.axes @ marker.vector)[:2] * [1, -1] * min(stage.size)
                annotate.vector(canvas, place, along, layout.text, marker.color, theme.halo)
                room = 0.5 * layout.text
                taken.append((*np.minimum(place, place + along) - room, *np.maximum(place, place + along) + room))
            label = marker.label
            if not shown and not hinted:
                label, hinted = f"{label} (behind)" if label else "behind", not label
            texts.append((label, marker.color, place))
        ink = np.zeros((layout.height, layout.width), dtype=bool)
        middle = SUPERSAMPLING // 2
        ink[layout.title : layout.title + layout.stage] = stage.covered[middle::SUPERSAMPLING, middle::SUPERSAMPLING]
        box = (4, layout.title, layout.width - 4, layout.title + layout.stage)
        annotate.labels(canvas, texts, ink, box, round(1.05 * layout.text), theme, taken)

    def _text_at(self, canvas: Canvas, marker: Marker, place: Floats, taken: list[Box]) -> None:
        """Draw the label of a marker centered at a place, unless another one is there."""
        size = float(self.layout.text)
        half = np.array([text_width(marker.label, size, bold=True) / 2, 0.6 * size])
        (left, top), (right, low) = (place - half).tolist(), (place + half).tolist()
        box: Box = (left, top, right, low)
        if not any(annotate.overlap(box, other) for other in taken):
            taken.append(box)
            x, y = place.tolist()
            canvas.text(x, y, marker.label, size, marker.color, bold=True, halo=self.look.theme.halo)

    def _legend(self, canvas: Canvas, panel: Panel, shades: Shades | None, box: Box) -> None:
        """Draw the color bar of a panel, and its note or the key of its arrows, below the top of a box."""
        left, top, right, _ = box
        text, theme, width = self.layout.text, self.look.theme, right - left
        if shades is not None and not shades.rgb and panel.surface.bar:
            bar = (left + 0.16 * width, top + 0.5 * text, right - 0.16 * width, top)
            annotate.color_bar(canvas, shades, _bar_label(panel.surface, shades), bar, text, theme)
        note = round(1.8 * text)
        low = top + (self.below or self.layout.bar + self.layout.note)
        room = (left + 8, low - note, right - 8, low)
        scaled = scaled_arrows(panel)
        if panel.note:
            annotate.title(canvas, panel.note, room, text, theme)
        elif scaled and scaled.scale:
            value = round_below(2 * scaled.scale)
            length = value / scaled.scale * scaled.spacing * min(self.stage.size)
            annotate.arrow_key(canvas, length, plain_number(value, 2), room, text, theme, scaled.color)


#: Draws panels, in a block.
Opened = AbstractContextManager[Callable[[Sequence[Panel]], Picture]]
_openers: list[Callable[..., Opened]] = [Drawing]


def draw(
    mesh: TriangleMesh,
    panels: Sequence[Panel],
    size: tuple[int, int] | None = None,
    columns: int | None = None,
    view: View | None = None,
    look: Look = AUTOMATIC,
    sources: Sequence[int] = (),
) -> Picture:
    """Draw one picture, (height, width, 3); the arguments are those of `Drawing`."""
    options: dict[str, Any] = {"size": size, "columns": columns, "view": view, "look": look, "sources": sources}
    with open_drawing(mesh, panels, **options) as drawing:
        return drawing(panels)


def open_drawing(mesh: TriangleMesh, panels: Sequence[Panel], **options: Any) -> Opened:
    """Open a drawing: a `Drawing`, whose arguments these are, or what stands for it within `drawn_by`."""
    return _openers[-1](mesh, panels, **options)


@contextmanager
def drawn_by(opener: Callable[..., Opened]) -> Iterator[None]:
    """Draw all pictures within the block by what a function opens, from the arguments of `Drawing`."""
    _openers.append(opener)
    try:
        yield
    finally:
        _openers.pop()


def _styled(panels: Sequence[Panel], look: Look) -> list[Panel]:
    """Apply the colors of a look to the main surfaces of panels, or to all if none is one."""
    main = any(panel.surface.main and panel.surface.values is not None for panel in panels)
    return [
        replace(panel, surface=look.apply(panel.surface)) if panel.surface.main or not main else panel
        for panel in (styled(panel, look) for panel in panels)
    ]


def _bar_label(surface: Surface, shades: Shades) -> str:
    """Return quantity, unit and spacing of isolines of a color bar."""
    parts = [surface.label] if surface.label else []
    if len(shades.levels) and shades.spacing:
        parts.append(f"isolines every {shades.spacing:.3g}")
    return ", ".join(parts)
