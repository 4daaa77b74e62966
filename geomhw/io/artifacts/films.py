"""Films from pictures: GIF by Pillow, MP4 by the ffmpeg program of imageio-ffmpeg.

ffmpeg is started here, not by imageio-ffmpeg, which leaves its error messages on standard error.
"""

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
from geomhw.options import FRAMES_PER_SECOND

Images = Iterable[NDArray[np.uint8]]

#: Number of pixels from which the palette of a frame is chosen.
SAMPLE = 60_000


def require_mp4() -> None:
    """Check that MP4 films can be written.

    Raises
    ------
    RenderError
        If imageio-ffmpeg or its program is missing.
    """
    try:
        import imageio_ffmpeg

        imageio_ffmpeg.get_ffmpeg_exe()
    except (ImportError, RuntimeError):  # the package may be there without the program
        raise RenderError("no MP4 can be written here: pip install imageio-ffmpeg, or ask for a GIF") from None


def write_gif(path: str | Path, images: Images, fps: float = FRAMES_PER_SECOND) -> None:
    """Write an endless GIF atomically; each frame has a palette of 255 colors of its own.

    Parameters
    ----------
    path
        File to write.
    images
        Pictures of one size, red, green and blue, (h, w, 3), uint8.
    fps
        Frames per second.

    Raises
    ------
    FormatError
        If there are no images, or the file cannot be written.
    """
    from PIL import Image

    pictures = [_with_palette(Image.fromarray(image)) for image in images]
    if not pictures:
        raise FormatError(f"cannot write {path}: the film has no frames")
    options = {"save_all": True, "append_images": pictures[1:], "duration": round(1000 / fps), "loop": 0}
    with replacing([path]) as (temporary,):
        pictures[0].save(temporary, format="GIF", optimize=False, **options)


def _with_palette(picture: Any) -> Any:
    """A picture in 255 colors of its own, dithered.

    Colors are chosen by maximum coverage, because median cut drops rare strong colors such as the ends of a color bar;
    one step of k-means then moves them to where most pixels are.
    """
    from PIL import Image

    stride = math.isqrt(max(picture.width * picture.height // SAMPLE, 1))
    sample = Image.fromarray(np.asarray(picture)[::stride, ::stride])
    palette = sample.quantize(255, Image.Quantize.MAXCOVERAGE, kmeans=1, dither=Image.Dither.NONE)
    return picture.quantize(palette=palette, dither=Image.Dither.FLOYDSTEINBERG)


def write_mp4(path: str | Path, images: Images, fps: float = FRAMES_PER_SECOND) -> None:
    """Write an MP4 film (H.264) atomically; equal pictures give equal bytes.

    Parameters
    ----------
    path
        File to write.
    images
        Pictures of one size, red, green and blue, (h, w, 3), uint8. Odd sizes get one more row or column, a copy of
        the last.
    fps
        Frames per second.

    Raises
    ------
    RenderError
        If imageio-ffmpeg is missing.
    FormatError
        If there are no images, or ffmpeg fails.
    """
    require_mp4()
    with replacing([path]) as (temporary,):
        encoder: subprocess.Popen[bytes] | None = None
        try:
            for image in images:
                even = np.pad(image, [(0, image.shape[0] % 2), (0, image.shape[1] % 2), (0, 0)], mode="edge")
                encoder = encoder or _start_ffmpeg(temporary, even.shape[1], even.shape[0], fps)
                assert encoder.stdin
                try:
                    encoder.stdin.write(even.tobytes())
                except BrokenPipeError:  # ffmpeg has ended; its messages follow
                    break
            messages = encoder.communicate()[1] if encoder else b""
        finally:  # ffmpeg must have ended before its file is renamed or removed
            if encoder:
                _end(encoder)
        if encoder is None:
            raise FormatError(f"cannot write {path}: the film has no frames")
        if encoder.returncode:
            lines = [line.strip() for line in messages.decode(errors="replace").split("\n") if line.strip()]
            raise FormatError(f"cannot write {path}: {lines[-1] if lines else 'ffmpeg was stopped; is the disk full?'}")


def _start_ffmpeg(path: Path, width: int, height: int, fps: float) -> "subprocess.Popen[bytes]":
    """Start ffmpeg, which takes RGB pictures on its standard input."""
    import imageio_ffmpeg

    given = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}", "-r", f"{fps:g}", "-i", "-"]
    # One thread: with several, the bytes depend on the number of processors.
    coding = ["-an", "-c:v", "libx264", "-crf", "10", "-pix_fmt", "yuv420p", "-threads", "1"]
    plain = ["-map_metadata", "-1", "-fflags", "+bitexact", "-flags:v", "+bitexact", "-f", "mp4"]
    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-y", "-v", "error", *given, *coding, *plain, str(path)]
    # In a session of its own: Ctrl-C reaches only this process, which ends ffmpeg itself.
    return subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True)


def _end(encoder: "subprocess.Popen[bytes]") -> None:
    if encoder.poll() is None:
        encoder.kill()
    encoder.wait()
    for stream in (encoder.stdin, encoder.stderr):
        with contextlib.suppress(OSError):  # bytes that ffmpeg did not take
            if stream:
                stream.close()
