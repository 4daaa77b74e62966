"""Sources as they are written on the command line: ``12,40-44``, ``face:17``, ``boundary``, ``@file``, ..."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from geomhw.errors import FieldError, FormatError

if TYPE_CHECKING:
    from geomhw.mesh.surface_points import SurfacePoints
    from geomhw.mesh.triangle_mesh import TriangleMesh

SOURCE_HELP = (
    "12 or 12,40-44 (vertices, counted from 0), face:17 (its barycenter), face:17:0.2,0.3,0.5 (barycentric "
    "coordinates), near:X,Y,Z (the nearest point of the surface), max-y, min-x and the like (a vertex), boundary (all "
    "its vertices), several of these with commas between, or @FILE (a text file of them)"
)
#: A report lists no more sources than this, a line no more than that; beyond, it gives their number.
MOST_REPORTED, MOST_IN_A_LINE = 20, 8

_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_TRIPLE = f"{_NUMBER},{_NUMBER},{_NUMBER}"
_ONE = re.compile(
    rf"(?:(?P<first>-?\d+)(?:-(?P<last>\d+))?"
    rf"|face:(?P<face>-?\d+)(?::(?P<weights>{_TRIPLE}))?"
    rf"|near:(?P<near>{_TRIPLE})"
    r"|(?P<end>max|min)-(?P<axis>[xyz])"
    r"|(?P<boundary>boundary))(?:,|$)"
)


@dataclass(frozen=True)
class Spec:
    """One source spec: its parts by name, and where in a file it stands (or nothing), for messages."""

    parts: Mapping[str, str | None]
    origin: str = ""

    def on(self, mesh: "TriangleMesh") -> "SurfacePoints":
        """The points that it names on a mesh; FieldError if there are none."""
        from geomhw.mesh import surface_points

        first, face = self.parts["first"], self.parts["face"]
        weights, near, axis = self.parts["weights"], self.parts["near"], self.parts["axis"]
        try:
            if first is not None:
                return surface_points.vertex_range(mesh, int(first), int(self.parts["last"] or first))
            if face is not None:
                return surface_points.face_point(mesh, int(face), _triple(weights) if weights else None)
            if near is not None:
                return surface_points.nearest_point(mesh, _triple(near))
            if axis is not None:
                sign = 1 if self.parts["end"] == "max" else -1
                return surface_points.vertex_points(
                    mesh, [surface_points.extreme_vertex(mesh, "xyz".index(axis), sign)]
                )
            return surface_points.boundary_points(mesh)
        except FieldError as error:
            raise FieldError(f"{self.origin}{error}") from None


@dataclass(frozen=True)
class SourceSpecs:
    """All that was asked for, and the files that it was read from."""

    specs: Sequence[Spec]
    paths: Sequence[Path] = ()

    @classmethod
    def parse(cls, texts: Sequence[str]) -> "SourceSpecs":
        """Texts as they were typed, joined. UsageError for one that is no source, FormatError for a bad file."""
        specs: list[Spec] = []
        paths = []
        for text in map(str.strip, texts):
            if text.startswith("@"):
                paths.append(Path(text[1:]))
                specs += _of_file(paths[-1])
            else:
                specs += _of_text(text)
        return cls(specs, paths)

    def on(self, mesh: "TriangleMesh") -> "SurfacePoints":
        """The points on a mesh, in the order in which they were named; the vertex of largest y if none was."""
        from geomhw.mesh.surface_points import concatenate, default_source, vertex_points

        if not self.specs:
            return vertex_points(mesh, [default_source(mesh)])
        return concatenate([spec.on(mesh) for spec in self.specs])


def source_lines(path: Path) -> list[SourceSpecs]:
    """What each line of a file names, as a set of its own. FormatError for a bad file."""
    from geomhw.io import read_lines

    return [SourceSpecs(_of_line(path, number, line)) for number, line in read_lines(path)]


def source_pairs(path: Path) -> list[tuple[SourceSpecs, SourceSpecs, str, tuple[str, str]]]:
    """The two that each line of a file names, with a blank, or between numbers a comma, between them, where they stand,
    and in what words; equal words give the same object. FormatError for a bad file."""
    from geomhw.io import read_lines

    pairs, known = [], dict[str, SourceSpecs]()
    for number, line in read_lines(path):
        words = line.split() if not re.fullmatch(r"\d+\s*,\s*\d+", line) else re.findall(r"\d+", line)
        if len(words) != 2:
            raise FormatError(f"{path}, line {number}: '{line[:60]}' is no pair; give two sources, as in: 0 17")
        for word in words:
            if word not in known:
                known[word] = SourceSpecs(_of_line(path, number, word))
        pairs.append((known[words[0]], known[words[1]], f"{path}, line {number}: ", (words[0], words[1])))
    return pairs


def _of_text(text: str) -> list[Spec]:
    try:
        return _specs(text)
    except ValueError as error:
        raise click.UsageError(f"{error}.") from None


def _of_file(path: Path) -> list[Spec]:
    from geomhw.io import read_lines

    return [spec for number, line in read_lines(path) for spec in _of_line(path, number, line)]


def _of_line(path: Path, number: int, text: str) -> list[Spec]:
    origin = f"{path}, line {number}: "
    try:
        return _specs(text, origin)
    except ValueError as error:
        raise FormatError(f"{origin}{error}") from None


def _specs(text: str, origin: str = "") -> list[Spec]:
    """Specs with commas or blanks between; ValueError says which is none."""
    found = []
    for word in re.sub(r"\s*,\s*", ",", text).split() or [""]:
        start = 0
        while start < len(word) or not word:
            match = _ONE.match(word, start)
            if match is None:
                raise ValueError(f"'{word[start:]}' is no source; give {SOURCE_HELP}")
            first, last = match["first"], match["last"]
            if last is not None and int(last) < int(first):
                raise ValueError(f"'{first}-{last}' runs backward; give the smaller vertex first")
            found.append(Spec(match.groupdict(), origin))
            start = match.end()
    return found


def _triple(text: str) -> list[float]:
    return [float(number) for number in text.split(",")]


def shortened(report: Mapping[str, Any]) -> dict[str, Any]:
    """The report with the first few sources (and their vectors) only where they are many, and then their number."""
    count = len(report["sources"])
    if count <= MOST_REPORTED:
        return dict(report)
    few = {name: report[name][:MOST_REPORTED] for name in ("sources", "vectors") if name in report}
    return {**report, "source_count": count, **few}


def source_line(reported: Sequence[Any]) -> str:
    """The sources in one line; of many, their number and the first few."""
    from geomhw.mesh.surface_points import point_name

    names = [point_name(source) for source in reported[:MOST_IN_A_LINE]]
    if len(reported) > MOST_IN_A_LINE:
        return f"source: {len(reported)} points: {', '.join(names)}, ..."
    return f"source: {', '.join(names)}"
