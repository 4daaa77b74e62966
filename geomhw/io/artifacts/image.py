"""PNG pictures."""

import io
import warnings
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geomhw.errors import FormatError
from geomhw.io.atomic import replacing
from geomhw.io.file_bytes import content

#: Bytes that deflate makes of one at most [RFC 1951].
_DEFLATED = 1032
#: Kinds of PNG with up to 8 bits a channel, as Pillow calls them.
_MODES = {"1", "L", "LA", "P", "RGB", "RGBA"}


def write_png(path: str | Path, image: NDArray[Any]) -> None:
    """Write an (h, w, 3) array of uint8; equal pictures give equal bytes."""
    if image.dtype != np.uint8 or image.ndim != 3 or image.shape[2] != 3 or not image.size:
        raise FormatError(f"a picture must be an (h, w, 3) array of uint8, not {image.shape} of {image.dtype}")
    from PIL import Image

    with replacing([path]) as (temporary,):
        Image.fromarray(np.ascontiguousarray(image)).save(temporary, format="PNG", compress_level=4)


def read_png(path: str | Path) -> NDArray[np.uint8]:
    """The picture, (h, w, 4): red, green, blue and opacity."""
    from PIL import Image

    path = Path(path)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", Image.DecompressionBombWarning)
            data = content(path)
            picture = Image.open(io.BytesIO(data), formats=["PNG"])
            if picture.width * picture.height // 8 > _DEFLATED * len(data):
                raise ValueError(f"{picture.width} x {picture.height} pixels do not fit into {len(data)} bytes")
            if picture.mode in _MODES:
                return np.asarray(picture.convert("RGBA"))
    except (OSError, SyntaxError, ValueError, Image.DecompressionBombError, Image.DecompressionBombWarning) as error:
        reason = "it is no PNG" if isinstance(error, Image.UnidentifiedImageError) else error
        raise FormatError(f"{path.name} cannot be read as a picture: {reason}") from None
    raise FormatError(f"{path.name} has more than 8 bits a channel, which is not read")
