"""A drawing as a list of images, texts and shapes, which becomes pixels by Pillow, or SVG or PDF by matplotlib."""

from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Box = tuple[float, float, float, float]  # left, top, right, bottom
Image = NDArray[np.uint8]
#: Samples along each side of a pixel at the edges of shapes.
_SAMPLES = 4


@dataclass(frozen=True)
class Text:
    """A text at a point; anchor: two letters of Pillow, such as "mm" for its middle. halo: color of its outline."""

    x: float
    y: float
    text: str
    size: float
    color: str
    anchor: str = "mm"
    bold: bool = False
    halo: str = ""


@dataclass(frozen=True)
class Shape:
    """A filled polygon, (k, 2)."""

    points: NDArray[np.float64]
    color: str


@dataclass(frozen=True)
class Picture:
    """Pixels of any resolution, (h, w, 3), or (h, w, 4) with opacity, that fill a box."""

    pixels: Image
    box: Box


@dataclass
class Canvas:
    """Items of a drawing of ``size`` pixels, from back to front; y points down.

    background: a color, or "" for a transparent one.
    """

    size: tuple[int, int]
    background: str
    items: list[Text | Shape | Picture] = field(default_factory=list)

    def text(self, x: float, y: float, text: str, size: float, color: str, **how: Any) -> None:
        """Add a text."""
        self.items.append(Text(x, y, text, size, color, **how))

    def polygon(self, points: ArrayLike, color: str) -> None:
        """Add a polygon."""
        self.items.append(Shape(np.asarray(points, dtype=float), color))

    def rectangle(self, box: Box, color: str) -> None:
        """Add a rectangle."""
        left, top, right, bottom = box
        self.polygon([(left, top), (right, top), (right, bottom), (left, bottom)], color)

    def disc(self, x: float, y: float, radius: float, color: str) -> None:
        """Add a disc."""
        angle = np.linspace(0, 2 * np.pi, 48, endpoint=False)
        self.polygon(np.stack([x + radius * np.cos(angle), y + radius * np.sin(angle)], axis=1), color)

    def image(self, pixels: Image, box: Box) -> None:
        """Add an image."""
        self.items.append(Picture(pixels, box))

    def paste(self, other: "Canvas", x: float, y: float) -> None:
        """Add the items of another canvas, moved."""
        for item in other.items:
            if isinstance(item, Text):
                self.text(**{**item.__dict__, "x": item.x + x, "y": item.y + y})
            elif isinstance(item, Shape):
                self.polygon(item.points + np.array([x, y]), item.color)
            else:
                left, top, right, bottom = item.box
                self.image(item.pixels, (left + x, top + y, right + x, bottom + y))

    def pixels(self) -> Image:
        """Return the drawing as pixels, (height, width, 3), or with opacity, (height, width, 4)."""
        from PIL import Image as Pillow
        from PIL import ImageDraw

        sheet = Pillow.new("RGB", self.size, self.background or "white")
        if not self.background:
            sheet.putalpha(0)
        pen = ImageDraw.Draw(sheet)
        for item in self.items:
            if isinstance(item, Text):
                stroke = {"stroke_width": max(2, round(item.size / 6)), "stroke_fill": item.halo} if item.halo else {}
                letters = font(round(item.size), item.bold)
                pen.text((item.x, item.y), item.text, fill=item.color, font=letters, anchor=item.anchor, **stroke)
            elif isinstance(item, Shape):
                _fill(sheet, item)
            else:
                left, top, right, bottom = (round(side) for side in item.box)
                size = (right - left, bottom - top)
                small = Pillow.fromarray(item.pixels).resize(size, Pillow.Resampling.BOX)
                if small.mode == sheet.mode == "RGBA":
                    sheet.alpha_composite(small, (left, top))
                else:
                    sheet.paste(small, (left, top))
        return np.asarray(sheet)

    def save(self, path: Path, dpi: float, description: str) -> None:
        """Write the drawing as SVG or PDF, with texts and shapes as vectors; ``dpi`` pixels are an inch."""
        import matplotlib
        from matplotlib.figure import Figure
        from matplotlib.patches import Polygon
        from matplotlib.patheffects import Stroke

        (width, height), points = self.size, 72 / dpi
        figure = Figure((width / dpi, height / dpi), facecolor=self.background or "none")
        axes: Any = figure.add_axes((0, 0, 1, 1))
        axes.set(xlim=(0, width), ylim=(height, 0))
        axes.axis("off")
        sides = {"l": "left", "m": "center", "r": "right"}, {"a": "top", "m": "center", "s": "baseline"}
        for order, item in enumerate(self.items):
            if isinstance(item, Text):
                look = {
                    "fontsize": item.size * points,
                    "fontweight": "bold" if item.bold else "normal",
                    "ha": sides[0][item.anchor[0]],
                    "va": sides[1][item.anchor[1]],
                    "zorder": order,
                    "parse_math": False,
                }
                if item.halo:  # a text with an outline becomes a path: the letters themselves follow as text
                    halo = axes.text(item.x, item.y, item.text, color=item.halo, **look)
                    halo.set_path_effects([Stroke(linewidth=item.size * points / 3, foreground=item.halo)])
                axes.text(item.x, item.y, item.text, color=item.color, **look)
            elif isinstance(item, Shape):
                axes.add_patch(Polygon(item.points, facecolor=item.color, edgecolor="none", zorder=order))
            else:
                left, top, right, bottom = item.box
                extent = (left, right, bottom, top)
                if len(item.pixels) == 1:  # a color bar
                    edges = np.linspace(left, right, item.pixels.shape[1] + 1)
                    axes.pcolormesh(edges, (top, bottom), item.pixels / 255, zorder=order)
                    continue
                axes.imshow(item.pixels, extent=extent, interpolation="none", aspect="auto", zorder=order)
        axes.set(xlim=(0, width), ylim=(height, 0))
        kind = path.suffix[1:].lower()
        dated = {"Date": None} if kind == "svg" else {"CreationDate": None}
        plain: Any = {
            "svg.fonttype": "none",
            "svg.hashsalt": "geomhw",
            "pdf.fonttype": 42,
            "font.family": "DejaVu Sans",
        }
        with matplotlib.rc_context(plain):
            title = {"Title" if kind == "svg" else "Subject": description}
            figure.savefig(path, format=kind, dpi=dpi, metadata={**dated, **title})


@cache
def font(size: int, bold: bool = False) -> Any:
    """Load DejaVu Sans, which matplotlib installs and which has mathematical symbols."""
    import matplotlib
    from PIL import ImageFont

    name = "DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf"
    return ImageFont.truetype(f"{matplotlib.get_data_path()}/fonts/ttf/{name}", size)


def text_width(text: str, size: float, bold: bool = False) -> float:
    """Return the width of a text in pixels."""
    return float(font(round(size), bold).getlength(text))


def arrow_outline(tail: ArrayLike, tip: ArrayLike, width: float) -> NDArray[np.float64]:
    """Return the outline, (7, 2), of an arrow whose shaft has the given width."""
    start, end = np.asarray(tail, dtype=float), np.asarray(tip, dtype=float)
    along = end - start
    length = float(np.hypot(*along)) or 1.0
    ahead = along / length
    side = np.array([-ahead[1], ahead[0]])
    neck = end - ahead * min(4 * width, 0.7 * length)
    shaft, head = 0.5 * width * side, 1.6 * width * side
    return np.stack([start + shaft, neck + shaft, neck + head, end, neck - head, neck - shaft, start - shaft])


def _fill(sheet: Any, shape: Shape) -> None:
    """Draw a polygon with smooth edges on a Pillow image."""
    from PIL import Image as Pillow
    from PIL import ImageDraw

    low = np.floor(shape.points.min(axis=0)).astype(int)
    size = np.ceil(shape.points.max(axis=0)).astype(int) - low + 1
    mask = Pillow.new("L", tuple((_SAMPLES * size).tolist()))
    corners = (_SAMPLES * (shape.points - low)).ravel().tolist()
    ImageDraw.Draw(mask).polygon(corners, fill=255)
    mask = mask.resize(tuple(size.tolist()), Pillow.Resampling.BOX)
    sheet.paste(shape.color, tuple(low.tolist()), mask)
