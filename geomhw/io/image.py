"""PNG pictures."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geomhw.errors import FormatError
from geomhw.io.atomic import replacing


def write_png(path: str | Path, image: NDArray[Any]) -> None:
    """Write an (h, w, 3) array of uint8; equal pictures give equal bytes."""
    if image.dtype != np.uint8 or image.ndim != 3 or image.shape[2] != 3 or not image.size:
        raise FormatError(f"a picture must be an (h, w, 3) array of uint8, not {image.shape} of {image.dtype}")
    from PIL import Image

    with replacing([path]) as (temporary,):
        Image.fromarray(np.ascontiguousarray(image)).save(temporary, format="PNG", compress_level=6)
