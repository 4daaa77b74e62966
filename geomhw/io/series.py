"""A time series: numbered ``.vtp`` frames with a ``.pvd`` (ParaView) and a ``.vtp.series`` index beside them."""

import json
import os
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree
from xml.sax.saxutils import quoteattr

from geomhw.errors import FormatError
from geomhw.io.atomic import replacing
from geomhw.io.writing import write
from geomhw.results import Result


@dataclass(frozen=True)
class Frame:
    """One entry of a series: its time, and its file, a name relative to the index."""

    time: float
    file: str


class SeriesWriter:
    """Adds frames to a series that is valid after each: first the frame, then both indices, each whole or not at all.

    path: the ``.pvd``. frames: those of an earlier run to keep.
    """

    def __init__(self, path: str | Path, frames: Sequence[Frame] = ()) -> None:
        self.path = Path(path)
        self.frames = list(frames)

    @property
    def index(self) -> Path:
        """The ``.vtp.series`` file."""
        return self.path.with_suffix(".vtp.series")

    def add(self, time: float, result: Result) -> None:
        """Write the next frame, and the indices that name it."""
        frame = Frame(float(time), f"{self.path.stem}.{len(self.frames):05d}.vtp")
        write(result, self.path.parent / frame.file)
        frames = [*self.frames, frame]
        with replacing([self.path, self.index]) as (pvd, series):
            pvd.write_text(_pvd(frames), encoding="utf-8")
            series.write_text(_series(frames), encoding="utf-8")
        self.frames = frames

    def writes(self, path: Path) -> bool:
        """Whether a file is one that frames or index would be written to."""
        frame = re.fullmatch(re.escape(self.path.stem) + r"\.\d{5,}\.vtp", path.name)
        ours = frame or path.name in (self.path.name, self.index.name)
        return bool(ours) and os.path.realpath(path.parent) == os.path.realpath(self.path.parent)


def read_series(path: str | Path) -> list[Frame]:
    """Frames of a ``.pvd``; FormatError where there is none or it is no series."""
    try:
        root = ElementTree.parse(path).getroot()
        return [Frame(float(item.attrib["timestep"]), item.attrib["file"]) for item in root.iter("DataSet")]
    except FileNotFoundError:
        raise FormatError(f"{path}: there is no such file") from None
    except (OSError, ElementTree.ParseError, KeyError, ValueError) as error:
        raise FormatError(f"{Path(path).name} is not a .pvd series that can be read: {error}") from error


def _pvd(frames: Sequence[Frame]) -> str:
    lines = ['<?xml version="1.0"?>', '<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">']
    lines.append("  <Collection>")
    lines += [f'    <DataSet timestep="{frame.time!r}" part="0" file={quoteattr(frame.file)}/>' for frame in frames]
    return "\n".join([*lines, "  </Collection>", "</VTKFile>", ""])


def _series(frames: Sequence[Frame]) -> str:
    files = [{"name": frame.file, "time": frame.time} for frame in frames]
    return json.dumps({"file-series-version": "1.0", "files": files}, indent=2) + "\n"
