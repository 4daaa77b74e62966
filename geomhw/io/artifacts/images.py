"""PNG pictures."""

import io
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geomhw.errors import FormatError
from geomhw.io.atomic import replacing
from geomhw.io.file_content import read_bytes

#: Largest factor by which deflate compresses [RFC 1951].
_DEFLATED = 1032
#: Pillow's names of the kinds of PNG with up to 8 bits a channel.
_MODES = {"1", "L", "LA", "P", "RGB", "RGBA"}


def write_png(
    path: str | Path, image: NDArray[Any], dpi: float | None = None, texts: Mapping[str, str] | None = None
) -> None:
    """Write a PNG picture atomically; equal pictures give equal bytes.

    Parameters
    ----------
    path
        File to write.
    image
        Red, green and blue, (h, w, 3), or with opacity (h, w, 4), uint8.
    dpi
        Pixels per inch, kept in the file.
    texts
        Texts kept in the file, by keyword, such as ``Software``.

    Raises
    ------
    FormatError
        If the image has another shape or type, or the file cannot be written.
    """
    if image.dtype != np.uint8 or image.ndim != 3 or image.shape[2] not in (3, 4) or not image.size:
        raise FormatError(f"a picture must be an (h, w, 3) array of uint8, not {image.shape} of {image.dtype}")
    from PIL import Image
    from PIL.PngImagePlugin import PngInfo

    metadata = PngInfo()
    for keyword, text in (texts or {}).items():
        metadata.add_itxt(keyword, text.encode("utf-8", "backslashreplace").decode())
    size = {"dpi": (dpi, dpi)} if dpi else {}
    with replacing([path]) as (temporary,):
        picture = Image.fromarray(np.ascontiguousarray(image))
        picture.save(temporary, format="PNG", compress_level=4, pnginfo=metadata, **size)


def read_png(path: str | Path) -> NDArray[np.uint8]:
    """Read a PNG picture of up to 8 bits a channel.

    Returns
    -------
    Red, green, blue and opacity, (h, w, 4).

    Raises
    ------
    FormatError
        If the file cannot be read, is damaged, has more than 8 bits a channel, or is too small for its pixels.
    """
    from PIL import Image

    path = Path(path)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", Image.DecompressionBombWarning)
            data = read_bytes(path)
            picture = Image.open(io.BytesIO(data), formats=["PNG"])
            if picture.width * picture.height // 8 > _DEFLATED * len(data):
                raise ValueError(f"{picture.width} x {picture.height} pixels do not fit into {len(data)} bytes")
            if picture.mode in _MODES:
                return np.asarray(picture.convert("RGBA"))
    except (OSError, SyntaxError, ValueError, Image.DecompressionBombError, Image.DecompressionBombWarning) as error:
        reason = "it is no PNG" if isinstance(error, Image.UnidentifiedImageError) else error
        raise FormatError(f"{path.name} cannot be read as a picture: {reason}") from None
    raise FormatError(f"{path.name} has more than 8 bits a channel, which is not read")
