"""What ``geomhw geodesic`` is asked at once: all pairs, the pairs of a file, or the sets of sources of a file."""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from geomhw.errors import FieldError
from geomhw_cli.specs.sources import SourceSpecs, source_lines, source_pairs

if TYPE_CHECKING:
    from geomhw.arrays import Floats, Ints
    from geomhw.geodesic.heat_method import HeatDistance
    from geomhw.mesh.surface_points import SurfacePoints
    from geomhw.mesh.triangle_mesh import TriangleMesh


@dataclass
class DistanceQueries:
    """As they were typed. option: ``--all-pairs``, ``--pairs`` or ``--sources``. words: of the lines of pairs."""

    option: str
    paths: Sequence[Path] = ()
    sets: Sequence[SourceSpecs] = ()
    pairs: Sequence[tuple[SourceSpecs, SourceSpecs, str]] = ()
    words: Sequence[tuple[str, str]] = ()
    count: int = 0

    @classmethod
    def parse(
        cls, all_pairs: bool, pairs: Path | None, source_file: Path | None, rest: dict[str, Any]
    ) -> "DistanceQueries | None":
        """None where nothing of that kind is asked. UsageError for two of them, or one with what is for one source."""
        asked = [
            name
            for name, given in (("--all-pairs", all_pairs), ("--pairs", pairs), ("--sources", source_file))
            if given
        ]
        if not asked:
            if rest["single"]:
                raise click.UsageError("--single is for --all-pairs, --pairs and --sources.")
            return None
        if len(asked) > 1:
            raise click.UsageError(f"{asked[0]} and {asked[1]} exclude each other.")
        if barred := next((name for name in ("--source", "--png") if rest[name.removeprefix("--")]), None):
            raise click.UsageError(f"{barred} and {asked[0]} exclude each other.")
        if pairs:
            found = source_pairs(pairs)
            return cls(asked[0], [pairs], pairs=[p[:3] for p in found], words=[p[3] for p in found])
        if source_file:
            return cls(asked[0], [source_file], sets=source_lines(source_file))
        return cls(asked[0])

    @property
    def of_pairs(self) -> bool:
        """Whether one number is asked for a line, and not one for each vertex."""
        return self.option == "--pairs"

    def digest(self) -> str:
        """Different for different questions."""
        text = repr(self.words) if self.of_pairs else repr([[spec.parts for spec in one.specs] for one in self.sets])
        return hashlib.sha256(text.encode()).hexdigest()

    def on(self, mesh: "TriangleMesh") -> "Asked":
        """On a mesh; FieldError for a source, or the end of a pair, that it does not have."""
        if self.of_pairs:
            asked = _grouped(mesh, self.pairs)
        elif self.sets:
            asked = Asked(len(self.sets), [one.on(mesh) for one in self.sets])
        else:
            asked = Asked(mesh.n_vertices)
        self.count = asked.count
        return asked


@dataclass
class Asked:
    """Questions on one mesh: ``count`` sets of sources, by default each vertex.

    targets: of each set, the vertices to which distances are asked; by default all. lines: where these stand in the
    file, one set after the other.
    """

    count: int
    sets: "Sequence[SurfacePoints] | None" = None
    targets: "Sequence[Ints] | None" = None
    lines: "Ints | None" = None

    def size(self, mesh: "TriangleMesh") -> tuple[int, ...]:
        """The shape of all answers."""
        return (self.count, mesh.n_vertices) if self.lines is None else (len(self.lines),)

    def answers(self, solver: "HeatDistance", first: int, last: int) -> "Floats":
        """Those to some of the sets, one after the other."""
        import numpy as np

        from geomhw.mesh.surface_points import vertex_points

        if self.sets is not None:
            rows = solver.rows(self.sets[first:last])
        else:
            # From a vertex without faces nothing can be reached but itself.
            rows = np.full((last - first, solver.mesh.n_vertices), np.inf)
            rows[np.arange(last - first), np.arange(first, last)] = 0.0
            used = np.setdiff1d(np.arange(first, last), solver.mesh.unreferenced_vertices)
            rows[used - first] = solver.rows([vertex_points(solver.mesh, [v]) for v in used.tolist()])
        if self.targets is None:
            return rows
        return np.concatenate([row[to] for row, to in zip(rows, self.targets[first:last], strict=True)])


def _grouped(mesh: "TriangleMesh", pairs: Sequence[tuple[SourceSpecs, SourceSpecs, str]]) -> Asked:
    """Pairs by their sources, so that each is solved for once, in the order in which they come first."""
    import numpy as np

    sources: dict[int, tuple[Any, list[int], list[int]]] = {}
    ends: dict[int, int] = {}
    for line, (start, end, origin) in enumerate(pairs):
        if id(end) not in ends:
            ends[id(end)] = _vertex(mesh, end, origin)
        if id(start) not in sources:
            sources[id(start)] = (start.on(mesh), [], [])
        sources[id(start)][1].append(ends[id(end)])
        sources[id(start)][2].append(line)
    return Asked(
        len(sources),
        [group[0] for group in sources.values()],
        [np.array(group[1]) for group in sources.values()],
        np.concatenate([group[2] for group in sources.values()]),
    )


def _vertex(mesh: "TriangleMesh", specs: SourceSpecs, origin: str) -> int:
    found = specs.on(mesh)
    if len(found) != 1 or len(found.vertices) != 1:
        raise FieldError(f"{origin}the second of a pair is one vertex")
    return int(found.vertices[0])
