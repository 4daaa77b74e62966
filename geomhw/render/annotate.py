"""Titles, color bars, arrow keys, markers and labels, drawn with Pillow over a picture."""

from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Floats
from geomhw.render import colors
from geomhw.render.colors import Shades
from geomhw.render.layers import Theme

Box = tuple[float, float, float, float]  # left, top, right, bottom


@cache
def font(size: int, bold: bool = False) -> Any:
    """Load DejaVu Sans, which matplotlib installs and which has mathematical symbols."""
    import matplotlib
    from PIL import ImageFont

    name = "DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf"
    return ImageFont.truetype(f"{matplotlib.get_data_path()}/fonts/ttf/{name}", size)


def title(pen: Any, text: str, box: Box, size: int, theme: Theme) -> None:
    """Draw a text in the middle of a box, smaller if it does not fit."""
    while size > 8 and pen.textlength(text, font=font(size)) > box[2] - box[0]:
        size -= 1
    middle = ((box[0] + box[2]) / 2, (box[1] + box[3]) / 2)
    pen.text(middle, text, fill=theme.ink, font=font(size), anchor="mm")


def color_bar(pen: Any, shades: Shades, label: str, box: Box, size: int, theme: Theme) -> None:
    """Draw a horizontal color bar with ticks; an end is pointed if data lie beyond it."""
    left, top, right, _ = (round(side) for side in box)
    height = round(0.85 * size)
    table = shades.table[:, :3]
    places = np.arange(left, right)
    index = ((places - left) * len(table) // (right - left)).tolist()
    for x, k in zip(places.tolist(), index, strict=True):  # a few hundred columns
        pen.line([(x, top), (x, top + height)], fill=tuple(table[k].tolist()))
    for beyond, x, way, color in (
        (shades.clipped[0], left, -1, table[0]),
        (shades.clipped[1], right - 1, 1, table[-1]),
    ):
        if beyond:
            tip = (x + way * 0.75 * height, top + height / 2)
            pen.polygon([(x, top), tip, (x, top + height)], fill=tuple(color.tolist()))
    low, high = shades.limits
    values = colors.ticks(low, high, whole=shades.log)
    if shades.log and not len(values):  # within one power of ten
        plain = colors.ticks(10.0**low, 10.0**high)
        values, (texts, power) = np.log10(plain), colors.tick_labels(plain)
    elif shades.log:
        texts, power = [f"10{colors.superscript(round(value))}" for value in values], ""
    else:
        texts, power = colors.tick_labels(values)
    for value, text in zip(values.tolist(), texts, strict=True):
        x = left + (value - low) / (high - low) * (right - 1 - left)
        pen.line([(x, top + height), (x, top + height + 0.3 * size)], fill=theme.ink)
        pen.text((x, top + height + 0.4 * size), text, fill=theme.ink, font=font(size), anchor="ma")
    suffix = " ".join(part for part in (power, label) if part)
    if suffix:
        pen.text((right + height, top + height / 2), suffix, fill=theme.ink, font=font(size), anchor="lm")


def arrow_key(pen: Any, length: float, text: str, box: Box, size: int, theme: Theme) -> None:
    """Draw an arrow of the given length and the magnitude it represents, in the middle of a box."""
    width = length + 0.5 * size + pen.textlength(text, font=font(size))
    x, y = (box[0] + box[2] - width) / 2, (box[1] + box[3]) / 2
    head = 0.35 * size
    pen.line([(x, y), (x + length - head, y)], fill=theme.ink, width=2)
    pen.polygon(
        [(x + length - 1.6 * head, y - head), (x + length, y), (x + length - 1.6 * head, y + head)], fill=theme.ink
    )
    pen.text((x + length + 0.5 * size, y), text, fill=theme.ink, font=font(size), anchor="lm")


def disc(pen: Any, place: Floats, radius: float, color: str, hidden: bool) -> None:
    """Draw a disc with a bright rim; a ring if the marked point is hidden by the surface."""
    x, y = place.tolist()

    def ellipse(r: float, **look: Any) -> None:
        pen.ellipse([x - r, y - r, x + r, y + r], **look)

    if hidden:
        ellipse(1.25 * radius, outline="#ffffff", width=round(1.05 * radius))
        ellipse(1.05 * radius, outline=color, width=round(0.6 * radius))
    else:
        ellipse(1.35 * radius, fill="#ffffff")
        ellipse(radius, fill=color)


def labels(sheet: Any, texts: Sequence[tuple[str, str, Floats]], box: Box, size: int, theme: Theme) -> None:
    """Draw texts, each with its color, next to their places: inside the box, apart from each other and off the mesh."""
    from PIL import ImageDraw

    pen = ImageDraw.Draw(sheet)
    empty = np.asarray(sheet.crop((0, 0, 1, 1)))[0, 0]
    ink = (np.asarray(sheet) != empty).any(axis=2)
    gap = 0.75 * size
    near = 0.6 * size
    taken: list[Box] = [(x - near, y - near, x + near, y + near) for _, _, (x, y) in texts]
    for text, color, place in texts:
        if not text:
            continue
        width, height = pen.textlength(text, font=font(size, bold=True)), 1.25 * size
        spots = [_inside(spot, box) for spot in _spots(place, width, height, gap)]
        covered = [
            10 * sum(_overlap(spot, other) for other in taken) / (width * height) + _filled(ink, spot) + 0.05 * number
            for number, spot in enumerate(spots)
        ]
        spot = spots[int(np.argmin(covered))]
        taken.append(spot)
        pen.text(
            ((spot[0] + spot[2]) / 2, (spot[1] + spot[3]) / 2),
            text,
            fill=color,
            font=font(size, bold=True),
            anchor="mm",
            stroke_width=max(2, round(size / 6)),
            stroke_fill=theme.background,
        )


def _filled(ink: NDArray[np.bool_], spot: Box) -> float:
    """Return the fraction of a box that is not background."""
    left, top, right, bottom = (max(0, round(side)) for side in spot)
    part = ink[top:bottom, left:right]
    return float(part.mean()) if part.size else 0.0


def _spots(place: Floats, width: float, height: float, gap: float) -> list[Box]:
    """Return candidate boxes around a place, the best first: right, left, above, below, diagonal."""
    x, y = place.tolist()
    corners = [
        (x + gap, y - height / 2),
        (x - gap - width, y - height / 2),
        (x - width / 2, y - gap - height),
        (x - width / 2, y + gap),
        (x + gap, y - gap - height),
        (x - gap - width, y - gap - height),
        (x + gap, y + gap),
        (x - gap - width, y + gap),
    ]
    return [(left, top, left + width, top + height) for left, top in corners]


def _inside(spot: Box, box: Box) -> Box:
    """Shift a box to lie inside another."""
    right = min(0.0, box[2] - spot[2]) + max(0.0, box[0] - spot[0])
    down = min(0.0, box[3] - spot[3]) + max(0.0, box[1] - spot[1])
    return (spot[0] + right, spot[1] + down, spot[2] + right, spot[3] + down)


def _overlap(a: Box, b: Box) -> float:
    """Return the area of the intersection of two boxes."""
    return max(0.0, min(a[2], b[2]) - max(a[0], b[0])) * max(0.0, min(a[3], b[3]) - max(a[1], b[1]))
