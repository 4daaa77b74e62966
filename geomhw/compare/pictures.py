"""Two pictures, compared as an eye compares them: other anti-aliasing of the same edges passes, what is lost does not.

A pixel differs by as much as its color lies outside of those that the other picture takes on within half a pixel around
it, channel by channel, so that an edge may be sampled elsewhere in its pixel [neighborhood clamping, as of Karis:
High-Quality Temporal Supersampling, SIGGRAPH 2014]. How much that is says ΔE*ab, the distance in CIELAB. Of small
things the eye sees contrast times area [Ricco 1877], so connected pixels that differ make a spot, which weighs the sum
of their ΔE*ab.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geomhw.compare.colors import delta_e, over_white
from geomhw.compare.findings import Finding

Image = NDArray[np.uint8]

#: The least ΔE*ab that is noticed [Mahy, Van Eycken, Oosterlinck 1994].
NOTICEABLE = 2.3
#: The heaviest spot that passes: two pixels of black in place of white. Between one scene anti-aliased with 4, 9 and 16
#: samples a pixel, spots weigh up to 170; an 8 in place of a 3 in a label 11 pixels high weighs 260, a lost decimal
#: point 280, a minus sign 380, an arrow 900 and more.
HEAVIEST_SPOT = 200.0
#: Spots that a report lists, the heaviest first.
_LISTED = 10
_FADE = 0.35
_UNEQUAL, _NOTED, _SPOT = (175, 205, 240), (200, 0, 60), (240, 130, 0)


@dataclass(frozen=True)
class Spot:
    """Connected pixels that noticeably differ: their rows and columns, weight, number, and the worst of them."""

    rows: tuple[int, int]
    columns: tuple[int, int]
    weight: float
    pixels: int
    worst: tuple[int, int]
    delta_e: float


class Difference:
    """What differs between two pictures of one size, (h, w, 4)."""

    def __init__(self, one: Image, other: Image) -> None:
        self.one, self.other = over_white(one), over_white(other)

    @cached_property
    def levels(self) -> Image:
        """The largest difference of the channels, (h, w)."""
        return np.abs(self.one.astype(np.int16) - self.other).max(axis=2).astype(np.uint8)

    @cached_property
    def delta_e(self) -> NDArray[np.float64]:
        """ΔE*ab to the nearest color that the other picture has around, the larger of both ways, (h, w)."""
        from scipy.ndimage import maximum_filter, minimum_filter

        unequal = self.levels > 0
        around = (3, 3, 1)
        found = np.zeros(unequal.shape)
        for p, q in ((self.one, self.other), (self.other, self.one)):
            here, there = p[unequal], q[unequal].astype(np.int16)
            lowest = (there + minimum_filter(q, around, mode="nearest")[unequal]) // 2  # half way to the neighbors
            highest = (there + maximum_filter(q, around, mode="nearest")[unequal] + 1) // 2
            nearest = np.clip(here, lowest, highest).astype(np.uint8)
            found[unequal] = np.maximum(found[unequal], delta_e(here, nearest))
        return found

    @cached_property
    def spots(self) -> list[Spot]:
        """Spots, the heaviest first."""
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
    """Same if no spot weighs more than ``heaviest``; pictures are (h, w, 4). Size and index are x, y."""
    size = one.shape[:2]
    if size != other.shape[:2]:
        sizes = [f"{image.shape[1]} x {image.shape[0]}" for image in (one, other)]
        return Finding("pixels", "picture", False, note=f"{sizes[0]} in A, {sizes[1]} in B")
    difference = Difference(one, other)
    if not difference.levels.any():
        return Finding("pixels", "picture", True, size[::-1], tolerance=heaviest)
    spots = difference.spots
    row, column = spots[0].worst if spots else _place(int(difference.levels.argmax()), size)
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
    """How many pixels differ, by how much, and where, for a report."""
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
    """The first picture in pale gray, (h, w, 3): unequal pixels blue, noticeable ones red, spots that count framed.

    Frames are orange; so is, of pictures of two sizes, what only one of them has.
    """
    height, width = np.maximum(one.shape[:2], other.shape[:2])
    rows, columns = np.minimum(one.shape[:2], other.shape[:2])
    difference = Difference(one[:rows, :columns], other[:rows, :columns])
    picture = np.full((height, width, 3), _SPOT, dtype=np.uint8)
    gray = difference.one[..., :3].mean(axis=2, keepdims=True)
    shared = np.repeat(255 - _FADE * (255 - gray), 3, axis=2).astype(np.uint8)
    shared[difference.levels > 0] = _UNEQUAL
    shared[_frames(difference, heaviest)] = _SPOT  # before the pixels, which must not be lost under a neighbor's frame
    shared[difference.delta_e > NOTICEABLE] = _NOTED
    picture[:rows, :columns] = shared
    return picture


def _frames(difference: Difference, heaviest: float, gap: int = 6, width: int = 2) -> NDArray[np.bool_]:
    """Where the outline runs round the boxes of the spots that count; boxes that meet have one outline."""
    from scipy.ndimage import binary_erosion

    inside = np.zeros(difference.levels.shape, dtype=bool)
    for spot in difference.spots:
        if spot.weight > heaviest:
            (top, bottom), (left, right) = spot.rows, spot.columns
            inside[max(0, top - gap) : bottom + gap + 1, max(0, left - gap) : right + gap + 1] = True
    return np.asarray(inside & ~binary_erosion(inside, np.ones((3, 3)), iterations=width))


def _sentence(difference: Difference, heaviest: float) -> str:
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


def _place(flat: int, shape: tuple[int, int]) -> tuple[int, int]:
    return flat // shape[1], flat % shape[1]


def _hex(color: Image) -> str:
    return "#" + bytes(color[:3] if color[3] == 255 else color).hex()
