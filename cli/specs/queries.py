"""Queries for distances from many sources: all pairs of vertices, the pairs of a file, or the source sets of a file."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import click

from geomhw.errors import FieldError
from geomhw_cli.specs.near_points import shortened_remarks
from geomhw_cli.specs.sources import SourcePair, SourceSpecs, source_lines, source_pairs

if TYPE_CHECKING:
    from geomhw.arrays import Floats, Ints
    from geomhw.mesh.surface_points import SurfacePoints
    from geomhw.mesh.triangle_mesh import TriangleMesh
    from geomhw_cli.specs.masks import MeshPart


#: A function from sets of sources, and the vertices wanted from each or None, to rows of distances.
Rows: TypeAlias = "Callable[[Sequence[SurfacePoints], Sequence[Ints] | None], Floats]"


@dataclass(frozen=True)
class DistanceQueries:
    """Queries as written on the command line.

    option: ``--all-pairs``, ``--pairs`` or ``--sources``. to: the vertices to which distances are wanted, by default
    all.
    """

    option: str
    sets: Sequence[SourceSpecs] = ()
    pairs: Sequence[SourcePair] = ()
    to: SourceSpecs | None = None

    @classmethod
    def parse(
        cls,
        all_pairs: bool,
        pairs: Path | None,
        source_file: Path | None,
        to: SourceSpecs | None,
        single: bool,
        others: Mapping[str, Any],
    ) -> "DistanceQueries | None":
        """Read the queries of the three options; None if there are none.

        others: values of options that exclude these three. Raises UsageError for options that exclude each other.
        """
        given = {"--all-pairs": all_pairs, "--pairs": pairs, "--sources": source_file}
        option, *more = [name for name, value in given.items() if value] or [""]
        if not option:
            if single:
                raise click.UsageError("--single is for --all-pairs, --pairs and --sources.")
            return None
        if more:
            raise click.UsageError(f"{option} and {more[0]} exclude each other.")
        if excluded := next((name for name, value in others.items() if value), None):
            raise click.UsageError(f"{excluded} and {option} exclude each other.")
        if pairs:
            if to:
                raise click.UsageError(f"--to and {option} exclude each other.")
            return cls(option, pairs=source_pairs(pairs))
        return cls(option, sets=source_lines(source_file) if source_file else (), to=to)

    @property
    def is_pairs(self) -> bool:
        """Whether a query is a distance between two points, not a row of distances to all vertices."""
        return self.option == "--pairs"

    @cached_property
    def digest(self) -> str:
        """SHA-256 of the queries, in hexadecimal."""
        if self.is_pairs:
            return pairs_digest(self.pairs)
        return _digest([[spec.parts for spec in one.specs] for one in self.sets])

    def count(self, n: int) -> int:
        """The number of sets of sources on a mesh of n vertices."""
        return len({id(pair.start) for pair in self.pairs}) if self.is_pairs else len(self.sets) or n

    def resolve(self, mesh: "TriangleMesh") -> "ResolvedQueries":
        """Find the points on a mesh. Raises FieldError for a point that the mesh does not have."""
        import numpy as np

        found: list[str] = []
        if self.is_pairs:
            resolved = _group_by_source(mesh, self.pairs, found)
        elif self.sets:
            resolved = ResolvedQueries(len(self.sets), [specs.resolve(mesh, found) for specs in self.sets])
        else:
            resolved = ResolvedQueries(mesh.n_vertices)
        if self.to:
            resolved.columns = np.array(self.to.vertices(mesh), dtype=np.int64)
        resolved.remarks = shortened_remarks(found)
        return resolved


def pairs_digest(pairs: Sequence[SourcePair]) -> str:
    """SHA-256 of pairs as they are written, in hexadecimal."""
    return _digest([pair.words for pair in pairs])


def _digest(values: Any) -> str:
    from hashlib import sha256

    return sha256(repr(values).encode()).hexdigest()


@dataclass
class ResolvedQueries:
    """``count`` sets of sources on a mesh, by default each vertex.

    targets: for each set, the vertices to which distances are wanted. lines: the lines of the file that these stand
    in, for all sets in order. columns: without targets, the vertices to which distances are wanted, by default all.
    wanted: for each set, those of its targets or of the columns that are in the part of the mesh where paths stay; None
    for all vertices. remarks: of `SourceSpecs.resolve`.
    """

    count: int
    sets: "Sequence[SurfacePoints] | None" = None
    targets: "Sequence[Ints] | None" = None
    lines: "Ints | None" = None
    columns: "Ints | None" = None
    wanted: "Sequence[Ints] | None" = None
    remarks: Sequence[str] = ()

    def place(self, part: "MeshPart") -> None:
        """Find the sources and the wanted vertices in a part of the mesh. Raises FieldError for a source outside."""
        if self.sets is not None:
            self.sets = [part.points(points) for points in self.sets]
        if self.targets is not None:
            self.wanted = [part.vertices(targets) for targets in self.targets]
        elif self.columns is not None:
            self.wanted = [part.vertices(self.columns)] * self.count

    def report(self) -> dict[str, str]:
        """Return what identifies the columns in the record of a resumable run."""
        return {} if self.columns is None else {"to": _digest(self.columns.tolist())}

    def shape(self, mesh: "TriangleMesh", first: int, last: int) -> tuple[int, ...]:
        """Shape of the distances from the sets ``first`` to ``last`` - 1: (sets, columns), or (pairs,)."""
        if self.lines is not None:
            return (len(self.lines_of(first, last)),)
        return last - first, mesh.n_vertices if self.columns is None else len(self.columns)

    def lines_of(self, first: int, last: int) -> "Ints":
        """The lines of the file that the distances from these sets stand in."""
        import numpy as np

        assert self.targets is not None
        assert self.lines is not None
        ends = np.append(0, np.cumsum([len(group) for group in self.targets]))
        return self.lines[ends[first] : ends[last]]

    def distances(
        self,
        mesh: "TriangleMesh",
        rows_of: "Rows",
        first: int,
        last: int,
    ) -> "Floats":
        """Distances from the sets ``first`` to ``last`` - 1, in order.

        rows_of: returns rows of distances from sets of sources, to the vertices wanted from each.
        """
        import numpy as np

        from geomhw.mesh.named_points import vertex_points

        wanted = self.wanted and self.wanted[first:last]
        if self.sets is not None:
            rows = rows_of(self.sets[first:last], wanted)
        else:
            # A vertex without faces reaches only itself.
            rows = np.full((last - first, mesh.n_vertices), np.inf)
            rows[np.arange(last - first), np.arange(first, last)] = 0.0
            used = np.setdiff1d(np.arange(first, last), mesh.unreferenced_vertices) - first
            sources = [vertex_points(mesh, [v]) for v in (used + first).tolist()]
            rows[used] = rows_of(sources, wanted and [wanted[k] for k in used])
        if self.targets is None:
            return rows if self.columns is None else np.ascontiguousarray(rows[:, self.columns])
        return np.concatenate([row[to] for row, to in zip(rows, self.targets[first:last], strict=True)])


def _group_by_source(mesh: "TriangleMesh", pairs: Sequence[SourcePair], remarks: list[str]) -> ResolvedQueries:
    """Pairs grouped by source, so that each source is solved for once, in order of first appearance."""
    import numpy as np

    sources: dict[int, tuple[Any, list[int], list[int]]] = {}
    ends: dict[int, int] = {}
    for line, pair in enumerate(pairs):
        start, end = id(pair.start), id(pair.end)  # equal words give the same object
        if end not in ends:
            ends[end] = _vertex(mesh, pair, remarks)
        if start not in sources:
            sources[start] = (pair.start.resolve(mesh, remarks), [], [])
        sources[start][1].append(ends[end])
        sources[start][2].append(line)
    points, targets, lines = zip(*sources.values(), strict=True)
    return ResolvedQueries(len(points), points, [np.array(group) for group in targets], np.concatenate(lines))


def _vertex(mesh: "TriangleMesh", pair: SourcePair, remarks: list[str]) -> int:
    """The vertex at the end of a pair."""
    points = pair.end.resolve(mesh, remarks)
    if len(points) != 1 or len(points.vertices) != 1:
        raise FieldError(f"{pair.origin}the second of a pair must be one vertex")
    return int(points.vertices[0])
