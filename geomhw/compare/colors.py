"""How different colors look: CIELAB under D65, as of IEC 61966-2-1 (sRGB) and CIE 15."""

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Floats

Colors = NDArray[np.uint8]

_SRGB = np.arange(256) / 255
_LINEAR = np.where(_SRGB <= 0.04045, _SRGB / 12.92, ((_SRGB + 0.055) / 1.055) ** 2.4)
_TO_XYZ = np.array(
    [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]]
)
_EPSILON, _KAPPA = 216 / 24389, 24389 / 27


def lab(rgb: Colors) -> Floats:
    """L*, a*, b* of sRGB colors, (k, 3).

    >>> lab(np.array([[255, 0, 0]], dtype=np.uint8)).round(1).tolist()
    [[53.2, 80.1, 67.2]]
    """
    xyz = _LINEAR[rgb] @ (_TO_XYZ / _TO_XYZ.sum(axis=1, keepdims=True)).T  # relative to white
    x, y, z = np.where(xyz > _EPSILON, np.cbrt(xyz), (_KAPPA * xyz + 16) / 116).T
    return np.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], axis=1)


def delta_e(one: Colors, other: Colors) -> Floats:
    """ΔE*ab of colors with opacity, (k, 4); a change from clear to opaque counts as much as one from black to white."""
    apart = lab(one[:, :3]) - lab(other[:, :3])
    clear = (one[:, 3].astype(float) - other[:, 3]) / 2.55
    return np.asarray(np.sqrt((apart**2).sum(axis=1) + clear**2))


def over_white(image: Colors) -> Colors:
    """The picture, (h, w, 4), as it looks on white paper; the opacity is kept."""
    opacity = image[..., 3:]
    if (opacity == 255).all():
        return image
    paper = 255 - (255 - image[..., :3].astype(np.float64)) * (opacity / 255)
    return np.concatenate([np.rint(paper).astype(np.uint8), opacity], axis=2)
