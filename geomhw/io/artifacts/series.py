"""A time series: numbered ``.vtp`` frames with a ``.pvd`` (ParaView) and a ``.vtp.series`` index beside them.

Points that go with the frames are files of their own, ``<stem>.tracers.<number>.vtp``: part 1 of each time step in the
``.pvd``, with an index ``<stem>.tracers.vtp.series``.
"""

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
from geomhw.io.file_bytes import content
from geomhw.io.formats.xml_tree import UNWRITABLE, parse_xml
from geomhw.io.writing import write, write_cloud
from geomhw.results import Cloud, Result

#: Which part of a time step in the ``.pvd`` the tracers are.
TRACER_PART = "1"


@dataclass(frozen=True)
class Frame:
    """One entry of a series: its time, its file, and that of its tracers where it has them, relative to the index."""

    time: float
    file: str
    tracers: str | None = None


class SeriesWriter:
    """Adds frames to a series that is valid after each: first the frame, then both indices, each whole or not at all.

    path: the ``.pvd``. frames: those of an earlier run to keep.
    """

    def __init__(self, path: str | Path, frames: Sequence[Frame] = ()) -> None:
        self.path = Path(path)
        if UNWRITABLE.search(self.path.name):
            raise FormatError(f"cannot write {self.path}: the name of a series stands in its index; use letters")
        self.frames = list(frames)

    @property
    def index(self) -> Path:
        """The ``.vtp.series`` file."""
        return self.path.with_suffix(".vtp.series")

    @property
    def tracer_index(self) -> Path:
        """The ``.tracers.vtp.series`` file, where the frames have tracers."""
        return self.path.with_suffix(".tracers.vtp.series")

    @property
    def state(self) -> Path:
        """Where the state to restart from is kept, of runs that keep one."""
        return self.path.with_suffix(".restart.npz")

    def add(self, time: float, result: Result, tracers: Cloud | None = None) -> None:
        """Write the next frame, and the indices that name it; with tracers in all frames of the series, or in none."""
        stem, number = self.path.stem, f"{len(self.frames):05d}"
        name = f"{stem}.tracers.{number}.vtp" if tracers else None
        frame = Frame(float(time), f"{stem}.{number}.vtp", name)
        write(result, self.path.parent / frame.file)
        if tracers and name:
            write_cloud(tracers, self.path.parent / name)
        frames = [*self.frames, frame]
        indices = [self.path, self.index, *([self.tracer_index] if tracers else [])]
        with replacing(indices) as (pvd, series, *others):
            pvd.write_text(_pvd(frames), encoding="utf-8")
            series.write_text(_series(frames), encoding="utf-8")
            for other in others:
                other.write_text(_series([Frame(f.time, f.tracers) for f in frames if f.tracers]), encoding="utf-8")
        self.frames = frames

    def writes(self, path: Path) -> bool:
        """Whether a file is one that frames, index or state would be written to, under whatever name."""
        folder = self.path.parent
        if self._is_ours(path.name) and os.path.realpath(path.parent) == os.path.realpath(folder):
            return True
        there = [entry.path for entry in os.scandir(folder) if self._is_ours(entry.name)] if path.exists() else []
        return any(os.path.exists(ours) and os.path.samefile(path, ours) for ours in there)

    def _is_ours(self, name: str) -> bool:
        frame = re.fullmatch(re.escape(self.path.stem) + r"(\.tracers)?\.\d{5,}\.vtp", name)
        return bool(frame) or name in [p.name for p in (self.path, self.index, self.tracer_index, self.state)]


def read_series(path: str | Path) -> list[Frame]:
    """Frames of a ``.pvd``; FormatError where there is none or it is no series."""
    try:
        items = [item.attrib for item in parse_xml(content(Path(path))).iter("DataSet")]
        parts = {item["timestep"]: item["file"] for item in items if item.get("part") == TRACER_PART}
        meshes = [item for item in items if item.get("part") != TRACER_PART]
        return [Frame(float(item["timestep"]), item["file"], parts.get(item["timestep"])) for item in meshes]
    except (ElementTree.ParseError, KeyError, ValueError) as error:
        raise FormatError(f"{Path(path).name} is not a .pvd series that can be read: {error}") from error


def _pvd(frames: Sequence[Frame]) -> str:
    lines = ['<?xml version="1.0"?>', '<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">']
    lines.append("  <Collection>")
    for frame in frames:
        for part, file in (("0", frame.file), (TRACER_PART, frame.tracers)):
            if file:
                lines.append(f'    <DataSet timestep="{frame.time!r}" part="{part}" file={quoteattr(file)}/>')
    return "\n".join([*lines, "  </Collection>", "</VTKFile>", ""])


def _series(frames: Sequence[Frame]) -> str:
    files = [{"name": frame.file, "time": frame.time} for frame in frames]
    return json.dumps({"file-series-version": "1.0", "files": files}, indent=2) + "\n"
