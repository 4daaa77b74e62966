"""Images of windows on the other two sides of a triangle, by straight lines through the window.

Mitchell, Mount, Papadimitriou: The Discrete Geodesic Problem. SIAM J. Comput. 16(4), 1987.
"""

from typing import Any

from geomhw.arrays import Ints
from geomhw.compiled import compiled_in_place
from geomhw.geodesic.windows import allocate

#: Windows of one origin whose points agree up to this share are pieces of one.
SAME = 1e-13
#: A point lies on a line if its distance from it is below this share of the lengths along the line.
ON_LINE = 4e-15


@compiled_in_place
def images(
    windows: Any, counts: Ints, i: int, base: float, side: float, cos: float, sin: float, mirrored: bool, flipped: bool
) -> int:
    """Return the list of the images on one side of the triangle, in the order of its points, of list i on the base.

    The side starts at the lower end of the base, or at the higher if mirrored, at an angle. flipped: whether the apex
    is the lower vertex of the side.
    """
    first = last = 0
    while i > 0:
        w = windows[i]
        left, right, x, y, split, offset = w.left, w.right, w.x, w.y, w.split, w.offset
        parallel = y < 0
        if mirrored:
            left, right, split = base - right, base - left, base - split
            x, offset = (-x, offset + base * x) if parallel else (base - x, offset)
        if not w.passed and (left < split or y == 0):
            foot, height = x * cos - y * sin, x * sin + y * cos
            if not parallel:
                height = above_line(height, foot, side)
            if parallel and height > -ON_LINE:
                low = high = 0.0
            elif parallel:
                low = _image(left, -y, -height, 0.0, side)
                high = side if right >= split else _image(right, -y, -height, 0.0, side)
            elif y > 0:
                low = _image(left, y, height, sin, side)
                high = side if right >= split else _image(right, y, height, sin, side)
            elif cos > 0 and side * sin <= ON_LINE * base:  # point, base and side are on one line
                low, high = min(left, side), min(right, side)
            else:  # all lines pass x
                low, high = 0.0, side if left - ON_LINE * base <= x <= right + ON_LINE * base else 0.0
            if low < high and (height != 0 or 0 < foot < side):
                j = allocate(windows, counts, i)
                if flipped:
                    low, high = side - high, side - low
                    foot, offset = (-foot, offset + side * foot) if parallel else (side - foot, offset)
                child = windows[j]
                child.left, child.right, child.x, child.y, child.next = low, high, foot, height, 0
                child.offset, child.crossed = offset, w.crossed + 1
                if first == 0:
                    first = j
                elif flipped != mirrored:
                    child.next, first = first, j
                else:
                    windows[last].next = j
                if child.next == 0:
                    last = j
        i = w.next
    return first


@compiled_in_place
def _image(t: float, y: float, height: float, sin: float, side: float) -> float:
    """Place on a side of the triangle that the ray through t on the base reaches, at most its length."""
    ahead = height - t * sin
    return min(t * y / ahead, side) if ahead > 0 else (side if t > 0 else 0.0)


@compiled_in_place
def crossing_to(x: float, y: float, apex_x: float, apex_y: float) -> float:
    """Place where the line from (x, -y), or the parallel line, to the apex crosses the base."""
    if y < 0:
        return apex_x + apex_y * x / y
    return x + (apex_x - x) * y / (y + apex_y) if y + apex_y > 0 else apex_x


@compiled_in_place
def above_line(y: float, x: float, base: float) -> float:
    """Height y of a point over a line; 0 if it lies on the line up to rounding."""
    return y if y > ON_LINE * (base + abs(x)) else 0.0


@compiled_in_place
def continues(a: Any, b: Any, base: float) -> bool:
    """Whether window b continues window a from the same point, as on both sides of a flat vertex."""
    far, apart = abs(a.x) + a.y, abs(a.x - b.x) + abs(a.y - b.y)
    return (
        apart <= SAME * far
        and apart * far <= 1e-6 * (b.right - b.left) * a.y
        and a.origin == b.origin
        and a.offset == b.offset
        and a.passed == b.passed
        and b.left - a.right <= SAME * base
    )
