"""Films from pictures: GIF by Pillow, MP4 by ffmpeg where imageio-ffmpeg brings it."""

import contextlib
import math
import subprocess
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geomhw.errors import FormatError, RenderError
from geomhw.io.atomic import replacing

Images = Iterable[NDArray[np.uint8]]

#: The colors of a GIF's frame are found in about so many of its pixels.
SAMPLE = 60_000


def require_mp4() -> None:
    """RenderError where no MP4 can be written here."""
    try:
        import imageio_ffmpeg

        imageio_ffmpeg.get_ffmpeg_exe()
    except (ImportError, RuntimeError):  # the package may be there without the program
        raise RenderError("no MP4 can be written here: pip install imageio-ffmpeg, or ask for a GIF") from None


def write_gif(path: str | Path, images: Images, fps: float = 12.0) -> None:
    """An endless GIF of (h, w, 3) pictures; each frame has its own palette of 255 colors."""
    from PIL import Image

    pictures = [_in_few_colors(Image.fromarray(image)) for image in images]
    if not pictures:
        raise FormatError(f"cannot write {path}: the film has no frames")
    with replacing([path]) as (temporary,):
        pictures[0].save(
            temporary,
            format="GIF",
            save_all=True,
            append_images=pictures[1:],
            duration=round(1000 / fps),
            loop=0,
            optimize=False,
        )


def _in_few_colors(picture: Any) -> Any:
    """A picture in 255 colors of its own, dithered.

    They are found by maximum coverage, for median cut gives away the few pixels of a strong color, a color bar's ends
    say; then moved to where most pixels are. A sample of the pixels tells them.
    """
    from PIL import Image

    stride = math.isqrt(max(picture.width * picture.height // SAMPLE, 1))
    sample = Image.fromarray(np.asarray(picture)[::stride, ::stride])
    palette = sample.quantize(255, Image.Quantize.MAXCOVERAGE, kmeans=1, dither=Image.Dither.NONE)
    return picture.quantize(palette=palette, dither=Image.Dither.FLOYDSTEINBERG)


def write_mp4(path: str | Path, images: Images, fps: float = 24.0) -> None:
    """An MP4 (H.264) of (h, w, 3) pictures; sides are made even by a row or column of the last color."""
    require_mp4()
    with replacing([path]) as (temporary,):
        encoder: subprocess.Popen[bytes] | None = None
        try:
            for image in images:
                even = np.pad(image, [(0, image.shape[0] % 2), (0, image.shape[1] % 2), (0, 0)], mode="edge")
                encoder = encoder or _encoder(temporary, even.shape[1], even.shape[0], fps)
                assert encoder.stdin
                try:
                    encoder.stdin.write(even.tobytes())
                except BrokenPipeError:  # ffmpeg has ended; why, it says below
                    break
            told = encoder.communicate()[1] if encoder else b""
        finally:  # ffmpeg must have ended before its file is renamed or removed
            if encoder:
                _end(encoder)
        if encoder is None:
            raise FormatError(f"cannot write {path}: the film has no frames")
        if encoder.returncode:
            raise FormatError(f"cannot write {path}: {_reason(told)}")


def _encoder(path: Path, width: int, height: int, fps: float) -> "subprocess.Popen[bytes]":
    """ffmpeg, which takes RGB pictures on its standard input."""
    import imageio_ffmpeg

    given = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}", "-r", f"{fps:g}", "-i", "-"]
    # One thread: with several, the bytes depend on how many processors there are.
    coding = ["-an", "-c:v", "libx264", "-crf", "10", "-pix_fmt", "yuv420p", "-threads", "1"]
    plain = ["-map_metadata", "-1", "-fflags", "+bitexact", "-flags:v", "+bitexact", "-f", "mp4"]
    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-y", "-v", "error", *given, *coding, *plain, str(path)]
    # A session of its own: Ctrl-C is for this process, which ends ffmpeg itself.
    return subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True)


def _end(encoder: "subprocess.Popen[bytes]") -> None:
    if encoder.poll() is None:
        encoder.kill()
    encoder.wait()
    for stream in (encoder.stdin, encoder.stderr):
        with contextlib.suppress(OSError):  # what was still to be written
            if stream:
                stream.close()


def _reason(told: bytes) -> str:
    """The last thing that ffmpeg said."""
    lines = told.decode(errors="replace").split("\n")
    return next((line.strip() for line in reversed(lines) if line.strip()), "ffmpeg was stopped; is the disk full?")
