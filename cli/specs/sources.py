"""Source points as written on the command line: ``12,40-44``, ``face:17``, ``boundary``, ``@file``, ..."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import click

from geomhw.errors import ArgumentError, FieldError, FormatError
from geomhw_cli.specs.curve_specs import CurveSpec, curve_files, is_curve
from geomhw_cli.specs.files import add_input
from geomhw_cli.specs.near_points import near_points, near_remarks, shortened_remarks, triple
from geomhw_cli.specs.numbers import excerpt
from geomhw_cli.specs.vertex_lists import VertexList, is_vertex_list, line_origin, vertices_on

if TYPE_CHECKING:
    from geomhw.mesh.surface_points import SurfacePoints
    from geomhw.mesh.triangle_mesh import TriangleMesh

SOURCE_HELP = (
    "12 or 12,40-44 (vertices, counted from 0), face:17 (its barycenter), face:17:0.2,0.3,0.5 (barycentric "
    "coordinates), near:X,Y,Z (the nearest point of the surface), max-y, min-x and so on (the extreme vertex), "
    "boundary (all its vertices), several of these separated by commas, @FILE (a text file of them), "
    "FILE:ARRAY=VALUE (all vertices, or vertices of the faces, where an array has this value), or a curve: curve:FILE "
    "(polylines of a .vtp, .obj, .csv or .border), curve:boundary, edges:angle>40, border:FILE:ARRAY"
)
#: Most sources that a report lists, and that a line lists; further ones are only counted.
MAX_REPORTED, MAX_IN_LINE = 20, 8

_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_TRIPLE = f"{_NUMBER},{_NUMBER},{_NUMBER}"
_ONE = re.compile(
    rf"(?:(?P<first>-?\d{{1,18}})(?:-(?P<last>\d{{1,18}}))?"
    rf"|face:(?P<face>-?\d{{1,18}})(?::(?P<weights>{_TRIPLE}))?"
    rf"|near:(?P<near>{_TRIPLE})"
    r"|(?P<end>max|min)-(?P<axis>[xyz])"
    r"|(?P<boundary>boundary))(?:,|$)"
)


@dataclass(frozen=True)
class Spec:
    """One source spec: its parts by name, and for messages its file and line, or "" on the command line.

    filled: whether its vertices belong to a filled region.
    """

    parts: Mapping[str, str | None]
    origin: str = ""
    filled: bool = False

    def resolve(self, mesh: "TriangleMesh") -> "SurfacePoints":
        """Find the points on a mesh. Raises FieldError if there are none."""
        from geomhw.mesh import named_points, nearest_point

        if region := self.parts.get("region"):
            return _region(mesh, region, str(self.parts["value"]))
        first, face, weights, near, axis = (
            self.parts.get(name) for name in ("first", "face", "weights", "near", "axis")
        )
        try:
            if first is not None:
                points = named_points.vertex_range(mesh, int(first), int(self.parts.get("last") or first))
                return named_points.region_points(mesh, points.vertices) if self.filled else points
            if face is not None:
                return named_points.face_point(mesh, int(face), triple(weights) if weights else None)
            if near is not None:
                return nearest_point(mesh, triple(near))
            if axis is not None:
                sign = 1 if self.parts["end"] == "max" else -1
                vertex = named_points.extreme_vertex(mesh, "xyz".index(axis), sign)
                return named_points.vertex_points(mesh, [vertex])
            return named_points.boundary_points(mesh)
        except FieldError as error:
            if self.origin:
                raise FieldError(f"{self.origin}{error}") from None
            raise


@dataclass(frozen=True)
class SourceSpecs:
    """Source specs, in order."""

    specs: Sequence[Spec | VertexList | CurveSpec]

    @classmethod
    def parse(cls, texts: Sequence[str]) -> "SourceSpecs":
        """Parse the texts of the command line, in order.

        Raises UsageError for a text that is no source, and FormatError for such a file.
        """
        specs: list[Spec | VertexList | CurveSpec] = []
        for text in map(str.strip, texts):
            for path in source_files(text):
                add_input(path)
            if text.startswith("@"):
                specs += _listed(Path(text[1:]))
                continue
            try:
                specs += [CurveSpec(text)] if is_curve(text) else [_parse_region(text)] if "=" in text else _parse(text)
            except ValueError as error:
                raise click.UsageError(f"{error}.") from None
        return cls(specs)

    def resolve(self, mesh: "TriangleMesh", remarks: list[str] | None = None, curves: bool = False) -> "SurfacePoints":
        """Find the points on a mesh, in order; by default the vertex of largest y.

        remarks: takes a line for each ``near:`` and curve, with the distance from the surface. curves: whether curves
        are allowed, whose segments are sources, too.
        """
        from geomhw.mesh.named_points import default_source, vertex_points
        from geomhw.mesh.surface_points import concatenate

        if not self.specs:
            return vertex_points(mesh, [default_source(mesh)])
        if (found := [spec for spec in self.specs if isinstance(spec, CurveSpec)]) and not curves:
            raise ArgumentError(f"'{excerpt(found[0].text)}' is a curve; give points here")
        places = [spec.parts.get("near") for spec in self.specs]
        near = near_points(mesh, places)
        parts = [
            near.get(k) or (spec.resolve(mesh, remarks) if isinstance(spec, CurveSpec) else spec.resolve(mesh))
            for k, spec in enumerate(self.specs)
        ]
        if remarks is not None:
            remarks += shortened_remarks(near_remarks(mesh, places, parts))
        return concatenate(parts)

    def vertices(self, mesh: "TriangleMesh") -> list[int]:
        """Find the vertices that the specs name. Raises ArgumentError for a point within a face."""
        points = self.resolve(mesh)
        if len(points.within_faces):
            raise ArgumentError("a target must be a vertex, not a point within a face")
        return [int(v) for v in points.vertices]


class SourcePair(NamedTuple):
    """A source, a second point, their words in the file, and for messages the file and line."""

    start: SourceSpecs
    end: SourceSpecs
    words: tuple[str, str]
    origin: str


def source_files(text: str) -> list[Path]:
    """The file that a source on the command line is read from."""
    from geomhw.io import field_file

    if is_curve(text.strip()):
        return curve_files(text)
    if text.strip().startswith("@"):
        return [Path(text.strip()[1:])]
    return [field_file(text.strip().rpartition("=")[0])] if "=" in text else []


def source_lines(path: Path) -> list[SourceSpecs]:
    """Read a set of sources from each line of a file. Raises FormatError for a line that has no sources."""
    from geomhw.io import read_lines

    return [SourceSpecs(list(_parse_lazily(path, number, line))) for number, line in read_lines(path)]


def source_pairs(path: Path) -> list[SourcePair]:
    """Read a pair from each line of a file, separated by a blank, or between numbers by a comma.

    Equal words give the same object. Raises FormatError for a line that is no pair.
    """
    from geomhw.io import read_lines

    pairs, known = [], dict[str, SourceSpecs]()
    for number, line in read_lines(path):
        words = line.split() if not re.fullmatch(r"\d+\s*,\s*\d+", line) else re.findall(r"\d+", line)
        if len(words) != 2:
            raise FormatError(f"{path}, line {number}: '{line[:60]}' is no pair; give two sources, as in: 0 17")
        for word in words:
            if word not in known:
                known[word] = SourceSpecs(list(_parse_lazily(path, number, word)))
        start, end = words
        pairs.append(SourcePair(known[start], known[end], (start, end), line_origin(path, number)))
    return pairs


def _listed(path: Path) -> Iterator[Spec | VertexList]:
    """Iterate over the sources on all lines of a file. Raises FormatError for a line that has no sources."""
    from itertools import groupby

    import numpy as np

    from geomhw.io import read_lines

    def on_line(number: int, line: str) -> Iterator[int | Spec]:
        return vertices_on(line) if is_vertex_list(line) else _parse_lazily(path, number, line)

    sources = ((number, found) for number, line in read_lines(path) for found in on_line(number, line))
    for is_vertex, group in groupby(sources, key=lambda item: isinstance(item[1], int)):
        if is_vertex:
            lines, vertices = np.fromiter(group, dtype=(np.int64, 2)).T
            yield VertexList(vertices, lines, path)
        else:
            yield from (replace(spec, filled=True) for _, spec in group if not isinstance(spec, int))


def _parse_lazily(path: Path, number: int, text: str) -> Iterator[Spec]:
    """Iterate over the sources on a line of a file. Raises FormatError if it has no sources."""
    origin = line_origin(path, number)
    try:
        yield from _parse(text, origin)
    except ValueError as error:
        raise FormatError(f"{origin}{error}") from None


def _parse(text: str, origin: str = "") -> Iterator[Spec]:
    """Parse specs separated by commas or blanks; raises ValueError for one that is no source."""
    text = re.sub(r"\s*,\s*", ",", text)
    for word in (match[0] for match in re.finditer(r"\S+|^\s*$", text)):
        word, start = word.strip(), 0
        while start < len(word) or not word:
            match = _ONE.match(word, start)
            if match is None:
                raise ValueError(f"'{excerpt(word[start:])}' is no source; give {SOURCE_HELP}")
            first, last = match["first"], match["last"]
            if last is not None and int(last) < int(first):
                raise ValueError(f"'{first}-{last}' runs backward; give the smaller vertex first")
            yield Spec({name: part for name, part in match.groupdict().items() if part is not None}, origin)
            start = match.end()


def _parse_region(text: str) -> Spec:
    """Parse FILE:ARRAY=VALUE; raises ValueError unless the value is a number."""
    field, _, value = text.rpartition("=")
    try:
        float(value)
    except ValueError:
        raise ValueError(f"'{text}' is no region; give FILE:ARRAY=NUMBER, such as labels.npy=3") from None
    return Spec({"region": field, "value": value})


def _region(mesh: "TriangleMesh", field: str, value: str) -> "SurfacePoints":
    """The vertices, or the vertices of the faces, where an array has a value."""
    import numpy as np

    from geomhw.io import read_field
    from geomhw.mesh.named_points import region_points

    array = read_field(field, mesh)
    inside = np.asarray(array.values) == float(value)
    if inside.ndim != 1 or array.location == "mesh":
        raise FieldError(f"{field} is no array of labels; it needs one number per vertex or face")
    vertices = np.flatnonzero(inside) if array.location == "vertex" else np.unique(mesh.faces[inside])
    vertices = np.setdiff1d(vertices, mesh.unreferenced_vertices)
    if not len(vertices):
        raise FieldError(f"{field} is {value} at no vertex of the surface")
    return region_points(mesh, vertices)


def shortened(report: Mapping[str, Any]) -> dict[str, Any]:
    """The report with only the first sources (and their vectors) if there are many, and with their number."""
    count = len(report["sources"])
    if count <= MAX_REPORTED:
        return dict(report)
    first = {name: report[name][:MAX_REPORTED] for name in ("sources", "vectors") if name in report}
    return {**report, "source_count": count, **first}


def source_line(sources: Sequence[Any], label: str = "source") -> str:
    """The reported sources in one line; if there are many, their number and the first. label: begins the line."""
    from geomhw.mesh.surface_points import point_name

    names = [point_name(source) for source in sources[:MAX_IN_LINE]]
    if len(sources) > MAX_IN_LINE:
        return f"{label}: {len(sources)} points: {', '.join(names)}, ..."
    return f"{label}: {', '.join(names)}"
