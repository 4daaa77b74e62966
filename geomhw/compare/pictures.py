"""Comparison of pictures by visible differences: other anti-aliasing of the same edges passes, lost detail does not.

The difference of a pixel is the ΔE*ab distance in CIELAB of its color from the range of colors in the other picture
within half a pixel, channel by channel [neighborhood clamping; Karis: High-Quality Temporal Supersampling, SIGGRAPH
2014]. The visibility of small details is contrast times area [Ricco 1877]. So connected pixels that differ form a spot,
whose weight is the sum of their ΔE*ab. CIELAB is under D65 [IEC 61966-2-1 (sRGB), CIE 15].
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Floats
from geomhw.compare.findings import Finding
from geomhw.compare.rules import HEAVIEST_SPOT

Image = NDArray[np.uint8]
Colors = NDArray[np.uint8]

#: Smallest visible ΔE*ab [Mahy, Van Eycken, Oosterlinck 1994].
NOTICEABLE = 2.3
#: Number of spots in a report, the heaviest first.
_LISTED = 10
_FADE = 0.35
_UNEQUAL, _NOTED, _SPOT = (175, 205, 240), (200, 0, 60), (240, 130, 0)
_SRGB = np.arange(256) / 255
_LINEAR = np.where(_SRGB <= 0.04045, _SRGB / 12.92, ((_SRGB + 0.055) / 1.055) ** 2.4)
_TO_XYZ = np.array(
    [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]]
)
_EPSILON, _KAPPA = 216 / 24389, 24389 / 27


@dataclass(frozen=True)
class Spot:
    """Connected pixels that visibly differ: first and last row and column, weight, number, and the worst pixel."""

    rows: tuple[int, int]
    columns: tuple[int, int]
    weight: float
    pixels: int
    worst: tuple[int, int]
    delta_e: float


class Difference:
    """The difference of two pictures of one size, (h, w, 4)."""

    def __init__(self, one: Image, other: Image) -> None:
        self.one, self.other = over_white(one), over_white(other)

    @cached_property
    def levels(self) -> Image:
        """Largest difference of a channel, (h, w), 0 to 255."""
        return np.abs(self.one.astype(np.int16) - self.other).max(axis=2).astype(np.uint8)

    @cached_property
    def delta_e(self) -> NDArray[np.float64]:
        """ΔE*ab to the closest color around in the other picture, the larger of both directions, (h, w)."""
        from scipy.ndimage import maximum_filter, minimum_filter

        unequal = self.levels > 0
        around = (3, 3, 1)
        found = np.zeros(unequal.shape)
        for p, q in ((self.one, self.other), (self.other, self.one)):
            here, there = p[unequal], q[unequal].astype(np.int16)
            lowest = (there + minimum_filter(q, around, mode="nearest")[unequal]) // 2  # halfway to the neighbors
            highest = (there + maximum_filter(q, around, mode="nearest")[unequal] + 1) // 2
            nearest = np.clip(here, lowest, highest).astype(np.uint8)
            found[unequal] = np.maximum(found[unequal], delta_e(here, nearest))
        return found

    @cached_property
    def spots(self) -> list[Spot]:
        """The spots, the heaviest first."""
        from scipy import ndimage

        labels, count = ndimage.label(self.delta_e > NOTICEABLE, np.ones((3, 3)))
        numbers = np.arange(1, count + 1)
        weights = ndimage.sum_labels(self.delta_e, labels, numbers)
        pixels = ndimage.sum_labels(np.ones(labels.shape), labels, numbers)
        boxes = ndimage.find_objects(labels)
        worst = ndimage.maximum_position(self.delta_e, labels, numbers)
        return [
            Spot(
                (boxes[i][0].start, boxes[i][0].stop - 1),
                (boxes[i][1].start, boxes[i][1].stop - 1),
                float(weights[i]),
                int(pixels[i]),
                (int(worst[i][0]), int(worst[i][1])),
                float(self.delta_e[worst[i]]),
            )
            for i in np.argsort(-weights, kind="stable")
        ]


def compare_pictures(one: Image, other: Image, heaviest: float = HEAVIEST_SPOT) -> Finding:
    """Compare two pictures, (h, w, 4): same if no spot weighs more than ``heaviest``. Size and index are (x, y)."""
    size = one.shape[:2]
    if size != other.shape[:2]:
        sizes = [f"{image.shape[1]} x {image.shape[0]}" for image in (one, other)]
        return Finding("pixels", "picture", False, note=f"{sizes[0]} in A, {sizes[1]} in B")
    difference = Difference(one, other)
    if not difference.levels.any():
        return Finding("pixels", "picture", True, size[::-1], tolerance=heaviest)
    spots = difference.spots
    row, column = spots[0].worst if spots else divmod(int(difference.levels.argmax()), size[1])
    beyond = sum(spot.weight > heaviest for spot in spots)
    return Finding(
        "pixels",
        "picture",
        not beyond,
        size[::-1],
        absolute=spots[0].weight if spots else 0.0,
        tolerance=heaviest,
        beyond=beyond,
        index=(column, row),
        values=(_hex(one[row, column]), _hex(other[row, column])),
        note=_sentence(difference, heaviest),
        details=_details(difference),
    )


def _details(difference: Difference) -> dict[str, Any]:
    """Return numbers and places of the pixels that differ, for a report."""
    spots = difference.spots
    return {
        "unequal_pixels": int(np.count_nonzero(difference.levels)),
        "largest_level_difference": int(difference.levels.max()),
        "noticeable_pixels": sum(spot.pixels for spot in spots),
        "largest_delta_e": float(difference.delta_e.max()),
        "spots": len(spots),
        "heaviest_spots": [
            {"x": spot.columns, "y": spot.rows, "weight": spot.weight, "pixels": spot.pixels, "delta_e": spot.delta_e}
            for spot in spots[:_LISTED]
        ],
    }


def difference_picture(one: Image, other: Image, heaviest: float = HEAVIEST_SPOT) -> Image:
    """Draw the difference, (h, w, 3), over the first picture in pale gray.

    Unequal pixels are blue, visibly different ones red. Orange frames mark the spots that do not pass. Parts that only
    one of two pictures of unequal size has are orange.
    """
    height, width = np.maximum(one.shape[:2], other.shape[:2])
    rows, columns = np.minimum(one.shape[:2], other.shape[:2])
    difference = Difference(one[:rows, :columns], other[:rows, :columns])
    picture = np.full((height, width, 3), _SPOT, dtype=np.uint8)
    gray = difference.one[..., :3].mean(axis=2, keepdims=True)
    shared = np.repeat(255 - _FADE * (255 - gray), 3, axis=2).astype(np.uint8)
    shared[difference.levels > 0] = _UNEQUAL
    shared[_frames(difference, heaviest)] = _SPOT  # first, so that no frame covers a pixel
    shared[difference.delta_e > NOTICEABLE] = _NOTED
    picture[:rows, :columns] = shared
    return picture


def _frames(difference: Difference, heaviest: float, gap: int = 6, width: int = 2) -> NDArray[np.bool_]:
    """Return the mask of the outlines around the spots that do not pass; overlapping boxes share an outline."""
    from scipy.ndimage import binary_erosion

    inside = np.zeros(difference.levels.shape, dtype=bool)
    for spot in difference.spots:
        if spot.weight > heaviest:
            (top, bottom), (left, right) = spot.rows, spot.columns
            inside[max(0, top - gap) : bottom + gap + 1, max(0, left - gap) : right + gap + 1] = True
    return np.asarray(inside & ~binary_erosion(inside, np.ones((3, 3)), iterations=width))


def _sentence(difference: Difference, heaviest: float) -> str:
    """Return the number of different pixels and the heaviest spot as text."""
    levels, spots = difference.levels, difference.spots
    unequal = np.count_nonzero(levels)
    parts = [f"{unequal} of {levels.size} pixels unequal, by up to {levels.max()} of 255 levels"]
    if spots:
        (top, bottom), (left, right) = spots[0].rows, spots[0].columns
        parts.append(f"{sum(spot.pixels for spot in spots)} noticeably, by up to dE {difference.delta_e.max():.1f}")
        where = f"x {left} to {right}, y {top} to {bottom}"
        parts.append(f"the heaviest spot weighs {spots[0].weight:.0f} ({heaviest:g} passes), at {where}")
        if (others := sum(spot.weight > heaviest for spot in spots) - 1) > 0:
            parts.append(f"{others} more {'is' if others == 1 else 'are'} too heavy")
    return "; ".join(parts)


def _hex(color: Image) -> str:
    return "#" + bytes(color[:3] if color[3] == 255 else color).hex()


def lab(rgb: Colors) -> Floats:
    """Convert sRGB colors, (k, 3), to L*, a*, b*.

    >>> lab(np.array([[255, 0, 0]], dtype=np.uint8)).round(1).tolist()
    [[53.2, 80.1, 67.2]]
    """
    xyz = _LINEAR[rgb] @ (_TO_XYZ / _TO_XYZ.sum(axis=1, keepdims=True)).T  # relative to white
    x, y, z = np.where(xyz > _EPSILON, np.cbrt(xyz), (_KAPPA * xyz + 16) / 116).T
    return np.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], axis=1)


def delta_e(one: Colors, other: Colors) -> Floats:
    """Return ΔE*ab of RGBA colors, (k, 4); transparent to opaque counts as much as black to white."""
    apart = lab(one[:, :3]) - lab(other[:, :3])
    clear = (one[:, 3].astype(float) - other[:, 3]) / 2.55
    return np.asarray(np.sqrt((apart**2).sum(axis=1) + clear**2))


def over_white(image: Colors) -> Colors:
    """Blend a picture, (h, w, 4), with a white background; its opacity is kept."""
    opacity = image[..., 3:]
    if (opacity == 255).all():
        return image
    blended = 255 - (255 - image[..., :3].astype(np.float64)) * (opacity / 255)
    return np.concatenate([np.rint(blended).astype(np.uint8), opacity], axis=2)
