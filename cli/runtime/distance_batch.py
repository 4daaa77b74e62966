"""``geomhw geodesic --all-pairs``, ``--pairs`` and ``--sources``: many questions on one mesh, in constant memory."""

import hashlib
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from geomhw_cli import options
from geomhw_cli.runtime.job import Job, robust_line
from geomhw_cli.runtime.progress import progress
from geomhw_cli.specs.queries import DistanceQueries

if TYPE_CHECKING:
    from geomhw.arrays import Floats
    from geomhw.geodesic.heat_method import HeatDistance
    from geomhw.io import ResumableFile
    from geomhw.mesh.triangle_mesh import TriangleMesh


def batch_options(command: Callable[..., None]) -> Callable[..., None]:
    """The options that ask for distances alone, from many sources."""
    for option in (
        click.option("--all-pairs", is_flag=True, help="Distances from each vertex to each: a matrix, -o D.npy."),
        click.option(
            "--pairs",
            metavar="FILE",
            type=options.FILE,
            help="Distance from the first to the second of each line, a source and a vertex: -o D.csv or D.npy.",
        ),
        click.option(
            "--sources",
            "source_file",
            metavar="FILE",
            type=options.FILE,
            help="Distances from each line of a file, one set of sources as in --source, to all vertices: -o D.npy.",
        ),
        click.option("--single", is_flag=True, help="Of these, write single precision."),
    ):
        command = option(command)
    return command


@dataclass
class DistanceBatch:
    """One run: what is asked, where answers go, and how far it has come."""

    job: Job
    questions: DistanceQueries
    output: Path
    kind: str
    choices: dict[str, Any]
    resumed: int = 0
    note: dict[str, Any] = field(default_factory=lambda: {"largest_distance": 0.0, "unreachable": 0})

    @classmethod
    def plan(
        cls, mesh_path: Path, questions: DistanceQueries, outputs: Sequence[Path], single: bool, choices: dict[str, Any]
    ) -> "DistanceBatch":
        """Check names and usage before any work is done."""
        from geomhw.io import check_outputs

        if len(outputs) != 1:
            raise click.UsageError(f"{questions.option} writes one file; give -o D.npy.")
        inputs = [mesh_path, *questions.paths]
        check_outputs(outputs, inputs, extensions=[".npy", ".csv"] if questions.of_pairs else [".npy"])
        stem = outputs[0].stem
        partial = [outputs[0].with_name(f"{stem}.partial{suffix}") for suffix in (".npy", ".json")]
        check_outputs(partial, inputs, extensions=[".npy", ".json"])
        json_and_quiet = {name: choices.pop(name) for name in ("as_json", "quiet")}
        job = Job("geodesic", mesh_path, outputs, **json_and_quiet)
        return cls(job, questions, outputs[0], "<f4" if single else "<f8", choices)

    def run(self) -> None:
        """All of it."""
        from geomhw.geodesic.heat_method import HeatDistance

        mesh = self.job.read()
        asked = self.questions.on(mesh)
        with self.job.stage("set up"):
            solver = HeatDistance(mesh, **self.choices, queries=asked.count)
            solver.prepare()
        with self._file(mesh, asked.size(mesh)) as partial, self._kept(partial):
            self._answer(mesh, solver, asked, partial)
            with self.job.stage("write"):
                if asked.lines is None:
                    partial.finish()
                else:
                    self._write_pairs(partial, asked)
        self.job.written.append(str(self.output))
        self._report(mesh, solver, asked)

    def _file(self, mesh: "TriangleMesh", shape: tuple[int, ...]) -> "ResumableFile":
        """What is written to, and whose run."""
        from math import prod

        from geomhw import __version__
        from geomhw.io import ResumableFile, npy_header

        run = {
            "version": __version__,
            "mesh": hashlib.sha256(mesh.vertices.tobytes() + mesh.faces.tobytes()).hexdigest(),
            "question": self.questions.option,
            "sources": self.questions.digest(),
            "precision": self.kind,
            **self.choices,
        }
        start = npy_header(shape, self.kind)
        partial = ResumableFile(self.output, run, start, len(start) + prod(shape) * int(self.kind[-1]), ".npy")
        self.resumed, self.note = partial.done, {**self.note, **partial.note}
        return partial

    def _answer(self, mesh: "TriangleMesh", solver: "HeatDistance", asked: Any, partial: "ResumableFile") -> None:
        """Block by block, of a size that depends on the mesh alone: an interrupted run goes on with the same blocks."""
        from geomhw.geodesic.heat_method import block_size

        size = block_size(mesh.n_vertices)
        with progress("geodesic") as bar:
            for first in range(partial.done, asked.count, size):
                last = min(first + size, asked.count)
                with self.job.stage("compute"):
                    values = asked.answers(solver, first, last)
                with self.job.stage("write"):
                    partial.append(values.astype(self.kind).tobytes(), last, self._noted(values))
                bar(last / asked.count)

    def _noted(self, values: "Floats") -> dict[str, Any]:
        import numpy as np

        finite = np.isfinite(values)
        self.note["largest_distance"] = max(self.note["largest_distance"], float(values.max(where=finite, initial=0.0)))
        self.note["unreachable"] += int(values.size - np.count_nonzero(finite))
        return self.note

    def _write_pairs(self, partial: "ResumableFile", asked: Any) -> None:
        """Distances in the order of the lines."""
        import numpy as np

        from geomhw.io import npy_header, read_numpy, replacing

        distances = np.empty(len(asked.lines), dtype=self.kind)
        distances[asked.lines] = read_numpy(partial.bytes_so_far())
        with replacing([self.output]) as (temporary,):
            if self.output.suffix.lower() == ".npy":
                temporary.write_bytes(npy_header(distances.shape, self.kind) + distances.tobytes())
            else:
                rows = zip(self.questions.words, distances.tolist(), strict=True)
                text = "".join(f"{one},{other},{distance!r}\n" for (one, other), distance in rows)
                temporary.write_text("source,target,distance\n" + text, encoding="utf-8", newline="\n")
        partial.discard()

    @contextmanager
    def _kept(self, partial: "ResumableFile") -> Iterator[None]:
        """Ctrl-C, or a signal to end, leaves what is done, and says so."""
        try:
            yield
        except KeyboardInterrupt:
            if not partial.done:
                raise
            what = f"{partial.done} of {self.questions.count} sources are kept in {partial.path.name}"
            raise click.ClickException(f"interrupted; {what}, and the same command goes on from there") from None

    def _report(self, mesh: "TriangleMesh", solver: "HeatDistance", asked: Any) -> None:
        report = {
            "question": self.questions.option.removeprefix("--"),
            "queries": asked.count,
            "resumed_after": self.resumed,
            "shape": list(asked.size(mesh)),
            "numbers": "single" if self.kind == "<f4" else "double",
            **self.note,
            **solver.settings(),
        }
        lines = [
            f"sources: {asked.count}" + (f", of which {self.resumed} were there" if self.resumed else ""),
            f"time: t = {report['time']['t']:.6g} ({report['time']['reason']})",
            f"largest: {report['largest_distance']:.10g}",
        ]
        if "robust" in report:
            lines.append(robust_line(report["robust"]))
        if report["unreachable"]:
            lines.append(f"warning: {report['unreachable']} distances are inf, to other components than the source's")
        self.job.finish(mesh, report, lines)
