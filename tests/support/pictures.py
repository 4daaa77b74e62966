"""Whether OpenGL is available, pixels of a color, and drawn test pictures with antialiasing."""

import numpy as np
import pytest
from PIL import Image, ImageDraw

from geomhw.render import offscreen
from geomhw.render.canvas import font

SIZE = (240, 160)
ARROWS = 12


def drawing(sampling: int = 4, without: int | None = None, text: str = "distance −0.05", shift: float = 0.0):
    """Return a picture of a disc with arrows, thin lines and a label, at a number of samples per pixel and axis."""
    width, height = SIZE
    offsets = (np.arange(sampling) + 0.5) / sampling
    x = (np.arange(width)[:, None] + offsets).ravel()[None, :]
    y = (np.arange(height)[:, None] + offsets).ravel()[:, None]
    shade = 80 + 100 * x / width + 0 * y
    samples = np.stack([shade, 0.6 * shade, 220 - shade], axis=2)
    samples[np.hypot(x - 80, y - 70) > 60] = 255
    for k in range(ARROWS):
        if k != without:
            turn = np.array([[np.cos(k), np.sin(k)], [-np.sin(k), np.cos(k)]])
            ends = np.array([[-6, 0], [6, 0], [2, 2.2], [2, -2.2]]) @ turn + [
                50 + 20 * (k % 4) + shift,
                45 + 24 * (k // 4),
            ]
            for tail in (0, 2, 3):
                samples[_stroke(x, y, ends[tail], ends[1], 0.7)] = (20, 23, 28)
    for k in range(4):
        samples[_stroke(x, y, (160 + shift, 20 + 9 * k), (230 + shift, 14 + 13 * k), 0.5)] = 0
    mean = samples.reshape(height, sampling, width, sampling, 3).mean(axis=(1, 3))
    image = Image.fromarray(np.rint(mean).astype(np.uint8))
    ImageDraw.Draw(image).text((150, 135), text, fill="#1b1f24", font=font(11))
    return np.asarray(image.convert("RGBA"))


def _stroke(x, y, begin, end, radius: float):
    """Return the samples within a radius of a segment."""
    (a, b), (c, d) = begin, end
    along = np.clip(((x - a) * (c - a) + (y - b) * (d - b)) / ((c - a) ** 2 + (d - b) ** 2), 0, 1)
    return np.hypot(x - a - along * (c - a), y - b - along * (d - b)) < radius


PLAIN = drawing()


# -- the command and its picture ---------------------------------------------------------------------------------


def save(name: str, image) -> None:
    Image.fromarray(image).save(name)


MISSING = offscreen.missing_opengl()
needs_opengl = pytest.mark.skipif(MISSING is not None, reason=str(MISSING))


def ink(image: np.ndarray, color: str, tolerance: int = 30) -> np.ndarray:
    """Return the mask of pixels whose three channels are all within the tolerance of a color."""
    rgb = [int(color[k : k + 2], 16) for k in (1, 3, 5)]
    return np.abs(np.asarray(image).astype(int) - rgb).max(axis=2) <= tolerance


def count(image: np.ndarray, color: str, tolerance: int = 12) -> int:
    """Count the pixels of a color."""
    return int(ink(image, color, tolerance).sum())
