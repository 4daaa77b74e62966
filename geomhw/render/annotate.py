"""Titles, color bars, arrow keys, markers and labels of a panel, added to a canvas."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Floats
from geomhw.render import colors
from geomhw.render.canvas import Box, Canvas, arrow_outline, text_width
from geomhw.render.colors import Shades
from geomhw.render.layers import Theme

#: Smallest size of a text, in pixels.
SMALLEST = 10


def title(canvas: Canvas, text: str, box: Box, size: float, theme: Theme) -> None:
    """Draw a text in the middle of a box, smaller if it does not fit."""
    room = box[2] - box[0]
    while size > SMALLEST and text_width(text, size) > room:
        size -= 1
    while len(text) > 1 and text_width(text, size) > room:
        text = text.removesuffix("…")[:-1] + "…"
    canvas.text((box[0] + box[2]) / 2, (box[1] + box[3]) / 2, text, size, theme.ink)


def color_bar(canvas: Canvas, shades: Shades, label: str, box: Box, size: float, theme: Theme) -> None:
    """Draw a horizontal color bar with ticks and a label below; an end is pointed if data lie beyond it."""
    left, top, right, _ = (round(side) for side in box)
    height = round(0.85 * size)
    table = shades.table[:, :3]
    canvas.image(np.ascontiguousarray(table[None]), (left, top, right, top + height))
    for beyond, x, way, color in (
        (shades.clipped[0], left, -1, table[0]),
        (shades.clipped[1], right, 1, table[-1]),
    ):
        if beyond:
            tip = (x + way * 0.75 * height, top + height / 2)
            canvas.polygon([(x, top), tip, (x, top + height)], f"#{bytes(color.tolist()).hex()}")
    low, high = shades.limits
    values = colors.ticks(low, high, whole=shades.log)
    if shades.log and not len(values):  # within one power of ten
        plain = colors.ticks(10.0**low, 10.0**high)
        values, (texts, power) = np.log10(plain), colors.tick_labels(plain)
    elif shades.log:
        texts, power = [f"10{colors.superscript(round(value))}" for value in values], ""
    else:
        texts, power = colors.tick_labels(values)
    thick = max(1.0, size / 14)
    for value, text in zip(values.tolist(), texts, strict=True):
        x = left + (value - low) / (high - low) * (right - left)
        canvas.rectangle((x - thick / 2, top + height, x + thick / 2, top + height + 0.3 * size), theme.ink)
        canvas.text(x, top + height + 0.4 * size, text, size, theme.ink, anchor="ma")
    if power:
        canvas.text(right + height, top + height / 2, power, size, theme.ink, anchor="lm")
    if label:
        room = (0, top + height + 1.6 * size, left + right, top + height + 3.0 * size)
        title(canvas, label, room, size, theme)


def arrow_key(canvas: Canvas, length: float, text: str, box: Box, size: float, theme: Theme, color: str) -> None:
    """Draw an arrow of the given length and the magnitude it represents, in the middle of a box."""
    width = length + 0.5 * size + text_width(text, size)
    x, y = (box[0] + box[2] - width) / 2, (box[1] + box[3]) / 2
    canvas.polygon(arrow_outline((x, y), (x + length, y), max(2.0, 0.1 * length)), color)
    canvas.text(x + length + 0.5 * size, y, text, size, theme.ink, anchor="lm")


def disc(canvas: Canvas, place: Floats, radius: float, color: str, hidden: bool, halo: str) -> None:
    """Draw a disc with a bright rim; a ring if the marked point is hidden by the surface."""
    x, y = place.tolist()
    if not hidden:
        canvas.disc(x, y, 1.35 * radius, halo)
        canvas.disc(x, y, radius, color)
        return
    for inner, outer, shade in ((0.2, 1.25, halo), (0.45, 1.05, color)):
        angle = np.linspace(0, 2 * np.pi, 49)
        ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        canvas.polygon(np.concatenate([outer * ring, inner * ring[::-1]]) * radius + [x, y], shade)


def vector(canvas: Canvas, place: Floats, along: Floats, size: float, color: str, halo: str) -> None:
    """Draw an arrow with a bright outline from a place, (2,), along a vector, (2,), in pixels."""
    if np.hypot(*along) < 1:
        return
    ahead = along / np.hypot(*along)
    thick = 0.24 * size
    canvas.polygon(arrow_outline(place - ahead, place + along + 1.8 * ahead, 1.8 * thick), halo)
    canvas.polygon(arrow_outline(place, place + along, thick), color)


def labels(
    canvas: Canvas,
    texts: Sequence[tuple[str, str, Floats]],
    ink: NDArray[np.bool_],
    box: Box,
    size: float,
    theme: Theme,
    taken: Sequence[Box] = (),
) -> None:
    """Draw texts, each with its color, next to their places: inside the box, apart from each other and off the mesh.

    ink: mask of the pixels of the mesh on the canvas. taken: boxes to keep free.
    """
    gap = 0.75 * size
    near = 0.6 * size
    full: list[Box] = [*taken, *((x - near, y - near, x + near, y + near) for _, _, (x, y) in texts)]
    for text, color, place in texts:
        if not text:
            continue
        width, height = text_width(text, size, bold=True), 1.25 * size
        spots = [_inside(spot, box) for spot in _spots(place, width, height, gap)]
        covered = [
            10 * sum(overlap(spot, other) for other in full) / (width * height) + _filled(ink, spot) + 0.05 * number
            for number, spot in enumerate(spots)
        ]
        spot = spots[int(np.argmin(covered))]
        full.append(spot)
        middle = (spot[0] + spot[2]) / 2, (spot[1] + spot[3]) / 2
        canvas.text(*middle, text, size, color, bold=True, halo=theme.halo)


def _filled(ink: NDArray[np.bool_], spot: Box) -> float:
    """Return the fraction of a box that is not background."""
    left, top, right, bottom = (max(0, round(side)) for side in spot)
    part = ink[top:bottom, left:right]
    return float(part.mean()) if part.size else 0.0


def _spots(place: Floats, width: float, height: float, gap: float) -> list[Box]:
    """Return candidate boxes around a place, the best first: right, left, above, below, diagonal, and farther away."""
    x, y = place.tolist()
    corners = []
    for far in (gap, 3 * gap):
        right, left, above, below = x + far, x - far - width, y - far - height, y + far
        middle, level = x - width / 2, y - height / 2
        corners += [(right, level), (left, level), (middle, above), (middle, below)]
        corners += [(right, above), (left, above), (right, below), (left, below)]
    return [(left, top, left + width, top + height) for left, top in corners]


def _inside(spot: Box, box: Box) -> Box:
    """Shift a box to lie inside another."""
    right = min(0.0, box[2] - spot[2]) + max(0.0, box[0] - spot[0])
    down = min(0.0, box[3] - spot[3]) + max(0.0, box[1] - spot[1])
    return (spot[0] + right, spot[1] + down, spot[2] + right, spot[3] + down)


def overlap(a: Box, b: Box) -> float:
    """Return the area of the intersection of two boxes."""
    return max(0.0, min(a[2], b[2]) - max(a[0], b[0])) * max(0.0, min(a[3], b[3]) - max(a[1], b[1]))
