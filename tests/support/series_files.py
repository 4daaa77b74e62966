"""Frames, point clouds and pictures for series and films."""

import numpy as np

from geomhw.mesh.primitives import icosphere
from geomhw.results import Cloud, Field, Result

BALL = icosphere(0)
#: Numbers that need all their digits, and short ones.
DOUBLES = [0.1, 1 / 3, 0.1 + 0.2, 5e-324, -1.7976931348623157e308, 1e22, 0.0, -0.0, 3.0]


def frame(value: float) -> Result:
    """Return a result with one value everywhere."""
    return Result(BALL, [Field("u", "vertex", np.full(12, value))])


def points(value: float) -> Cloud:
    """Return three points with arrays of all kinds."""
    fields = [
        Field("u", "vertex", np.full(3, value)),
        Field("id", "vertex", np.arange(3, dtype=np.int32)),
        Field("past", "vertex", np.arange(180, dtype=np.float32).reshape(3, 60)),
        Field("times", "mesh", np.array(DOUBLES)),
    ]
    return Cloud(np.array([[0.1, 1 / 3, -0.0], [1e300, 5e-324, 2.0], [0.0, value, 0.0]]), fields)


# -- films -------------------------------------------------------------------------------------------------------


def pictures(count: int = 4, size: tuple[int, int] = (41, 63)) -> list[np.ndarray]:
    """Return pictures of a white bar that moves over red and blue."""
    images = []
    for k in range(count):
        image = np.zeros((*size, 3), dtype=np.uint8)
        image[: size[0] // 2, :, 0] = image[size[0] // 2 :, :, 2] = 200
        image[:, 10 * k : 10 * k + 10] = 255
        images.append(image)
    return images
