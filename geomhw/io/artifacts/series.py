"""Time series: numbered ``.vtp`` frames with a ``.pvd`` (ParaView) and a ``.vtp.series`` index beside them.

Tracer points are files of their own, ``<stem>.tracers.<number>.vtp``: part 1 of each time step in the ``.pvd``, with an
index ``<stem>.tracers.vtp.series``.
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
from geomhw.io.file_content import read_bytes
from geomhw.io.formats.xml_tree import UNWRITABLE, parse_xml
from geomhw.io.reading import read, read_cloud
from geomhw.io.writing import write, write_cloud
from geomhw.results import Cloud, Result

#: The part of a time step in the ``.pvd`` that holds the tracers.
TRACER_PART = "1"


@dataclass(frozen=True)
class Frame:
    """One entry of a series: time, file, and file of its tracers or None; files are relative to the index."""

    time: float
    file: str
    tracers: str | None = None


class SeriesWriter:
    """Adds frames to a series, which is valid after each: first the frame, then the indices, each written atomically.

    Parameters
    ----------
    path
        The ``.pvd`` file; frames and indices are written beside it.
    frames
        Frames of an earlier run to keep.

    Attributes
    ----------
    path, index, tracer_index
        The ``.pvd``, the ``.vtp.series`` and the ``.tracers.vtp.series`` file.
    state
        The ``.restart.npz`` file, where runs keep the state to restart from.

    Raises
    ------
    FormatError
        If the name of the file cannot stand in an XML file.
    """

    def __init__(self, path: str | Path, frames: Sequence[Frame] = ()) -> None:
        self.path = Path(path)
        if UNWRITABLE.search(self.path.name):
            raise FormatError(f"cannot write {self.path}: the name of a series stands in its index; use letters")
        self.frames = list(frames)
        self.index = self.path.with_suffix(".vtp.series")
        self.tracer_index = self.path.with_suffix(".tracers.vtp.series")
        self.state = self.path.with_suffix(".restart.npz")
        self._former = self._files_of_index()

    def add(self, time: float, result: Result, tracers: Cloud | None = None) -> None:
        """Write the next frame and the indices that name it.

        Parameters
        ----------
        time
            Time of the frame.
        result
            Mesh and fields.
        tracers
            Points, in all frames of the series or in none.

        Raises
        ------
        FormatError, FieldError
            As `geomhw.io.write`.
        """
        stem, number = self.path.stem, f"{len(self.frames):05d}"
        name = f"{stem}.tracers.{number}.vtp" if tracers else None
        frame = Frame(float(time), f"{stem}.{number}.vtp", name)
        write(result, self.path.parent / frame.file, compress=True)
        if tracers and name:
            write_cloud(tracers, self.path.parent / name, compress=True)
        frames = [*self.frames, frame]
        texts = {self.path: _pvd(frames), self.index: _series([(f.time, f.file) for f in frames])}
        if tracers:
            texts[self.tracer_index] = _series([(f.time, f.tracers) for f in frames if f.tracers])
        with replacing(list(texts)) as temporaries:
            for temporary, text in zip(temporaries, texts.values(), strict=True):
                temporary.write_text(text, encoding="utf-8")
        self.frames = frames

    def remove_former(self) -> list[str]:
        """Remove the files of an earlier series of this name that are not of this one, and return their names."""
        kept = {name for frame in self.frames for name in (frame.file, frame.tracers)}
        kept |= {self.tracer_index.name} if any(frame.tracers for frame in self.frames) else set()
        removed = []
        for name in self._former:
            path = self.path.parent / name
            if name not in kept and path.is_file():
                path.unlink()
                removed.append(name)
        self._former = []
        return removed

    def _files_of_index(self) -> list[str]:
        """The files that an existing index names and that are named as ours are."""
        if not self.path.is_file():
            return []
        try:
            frames = read_series(self.path)
        except FormatError:
            return []
        names = [name for frame in frames for name in (frame.file, frame.tracers) if name and self._is_ours(name)]
        return [*names, self.tracer_index.name] if any(frame.tracers for frame in frames) else names

    def writes(self, path: Path) -> bool:
        """Return whether a file is one that this series would write, under any name."""
        folder = self.path.parent
        if self._is_ours(path.name) and os.path.realpath(path.parent) == os.path.realpath(folder):
            return True
        existing = [entry.path for entry in os.scandir(folder) if self._is_ours(entry.name)] if path.exists() else []
        return any(os.path.exists(ours) and os.path.samefile(path, ours) for ours in existing)

    def _is_ours(self, name: str) -> bool:
        frame = re.fullmatch(re.escape(self.path.stem) + r"(\.tracers)?\.\d{5,}\.vtp", name)
        return bool(frame) or name in [p.name for p in (self.path, self.index, self.tracer_index, self.state)]


def read_series(path: str | Path) -> list[Frame]:
    """Read the frames of a ``.pvd`` file.

    Raises
    ------
    FormatError
        If the file cannot be read or is not a series.
    """
    try:
        items = [item.attrib for item in parse_xml(read_bytes(Path(path))).iter("DataSet")]
        parts = {item["timestep"]: item["file"] for item in items if item.get("part") == TRACER_PART}
        meshes = [item for item in items if item.get("part") != TRACER_PART]
        return [Frame(float(item["timestep"]), item["file"], parts.get(item["timestep"])) for item in meshes]
    except (ElementTree.ParseError, KeyError, ValueError) as error:
        raise FormatError(f"{Path(path).name} is not a .pvd series that can be read: {error}") from error


def read_frames(path: str | Path, frames: Sequence[Frame]) -> tuple[list[Result], list[Cloud]]:
    """Read the meshes of the frames of a series, and the tracers of those that have some."""
    folder = Path(path).parent
    results = [read(folder / frame.file) for frame in frames]
    return results, [read_cloud(folder / frame.tracers) for frame in frames if frame.tracers]


def _pvd(frames: Sequence[Frame]) -> str:
    lines = ['<?xml version="1.0"?>', '<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">']
    lines.append("  <Collection>")
    for frame in frames:
        for part, file in (("0", frame.file), (TRACER_PART, frame.tracers)):
            if file:
                lines.append(f'    <DataSet timestep="{frame.time!r}" part="{part}" file={quoteattr(file)}/>')
    return "\n".join([*lines, "  </Collection>", "</VTKFile>", ""])


def _series(frames: Sequence[tuple[float, str]]) -> str:
    files = [{"name": file, "time": time} for time, file in frames]
    return json.dumps({"file-series-version": "1.0", "files": files}, indent=2) + "\n"
