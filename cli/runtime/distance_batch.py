"""Distances for many queries on one mesh, written block by block to a file from which an interrupted run resumes."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, fields
from functools import cached_property
from functools import partial as partial_call
from math import inf, prod
from threading import Lock
from typing import TYPE_CHECKING, Any

import click

from geomhw.wording import counted
from geomhw_cli.runtime.accuracy import accuracy_lines, sampled_errors
from geomhw_cli.runtime.distance_files import (
    EXTENSIONS,
    file_chunks,
    joined_statistics,
    pair_lines,
    statistics_of,
    write_labels,
    write_pairs,
)
from geomhw_cli.runtime.job import Job, robust_line, time_line
from geomhw_cli.runtime.progress import progress
from geomhw_cli.specs.distance_methods import DistanceMethod
from geomhw_cli.specs.files import require_writable
from geomhw_cli.specs.label_tables import LabelTable
from geomhw_cli.specs.masks import MaskSpec, MeshPart
from geomhw_cli.specs.queries import DistanceQueries, ResolvedQueries
from geomhw_cli.specs.shards import WHOLE, ShardPart

if TYPE_CHECKING:
    from geomhw.arrays import Floats
    from geomhw.geodesic.label_groups import LabelGroups
    from geomhw.io.artifacts.resumable_file import Place, ResumableFile, Written
    from geomhw.mesh.triangle_mesh import TriangleMesh

#: A function that yields, for spans of the sources, bytes to append and the statistics of their distances.
Answers = Callable[[Sequence[tuple[int, int]]], Iterator[Any]]
_SOLVING = Lock()


def compute_distances(
    job: Job,
    queries: DistanceQueries,
    dtype: str,
    method: DistanceMethod,
    beyond: float,
    mask: MaskSpec | None,
    table: LabelTable | None = None,
    shard: ShardPart = WHOLE,
    scheduler: str | None = None,
) -> None:
    """Compute the distances and write them to the output of the job, which must be one file.

    dtype: ``<f4`` or ``<f8``. beyond: the value for infinite distances. shard: the part of the sources to compute.
    scheduler: of Dask, on whose workers to compute. Blocks depend on the mesh alone, so that a resumed run, shards and
    workers write the same bytes.
    """
    from geomhw.geodesic.heat_method import block_size

    kind = "pairs" if queries.is_pairs else "labels" if table else "rows"
    _check_files(job, queries, EXTENSIONS[kind], shard)
    whole = job.read()
    part = MeshPart.of(whole, mask)
    mesh, resolved = part.mesh, queries.resolve(whole)
    job.remarks += resolved.remarks
    resolved.place(part)
    groups = table.groups(part) if table else None
    size = block_size(mesh.n_vertices)
    batch = _Batch(resolved, dtype, beyond, groups, *shard.range(resolved.count, size))
    problem = _Problem(mesh, batch, method)
    with job.stage("set up"):
        solver = problem.solver if not scheduler else method.solver(mesh)
    run = _identity(mesh, queries, resolved, dtype, method, beyond, table)
    unfinished = _open_unfinished(job, run | shard.report(), batch.shape(mesh, batch.first, batch.last), dtype)
    resumed = unfinished.done
    with unfinished:
        try:
            with _answers(problem, unfinished, scheduler) as answers:
                statistics = batch.fill(job, answers, unfinished, size)
            with job.stage("write"):
                about = {"shape": batch.shape(mesh, 0, resolved.count), "dtype": dtype, "beyond": str(beyond)}
                about |= (groups.report() if groups else {}) | statistics
                statistics |= _finish(job, kind, queries, batch, unfinished, run, about, shard)
        except KeyboardInterrupt as stop:
            if unfinished.done:
                done = f"{unfinished.done} of {batch.last - batch.first} sources are kept in {unfinished.path.name}"
                stop.args = (f"{done}, and the same command goes on from there",)
            raise
    job.written.append(str(job.outputs[0]))
    report = {
        "question": queries.option.removeprefix("--"),
        "queries": batch.last - batch.first,
        **shard.report(),
        "resumed_after": resumed,
        "shape": list(batch.shape(mesh, batch.first, batch.last)),
        "numbers": "single" if dtype == "<f4" else "double",
        **statistics,
        **solver.settings(),
        **({"limit": limit} if (limit := method.settings.get("limit", inf)) < inf else {}),
    }
    if method.name != "exact" and not job.quiet:
        is_exact = report.get("refined", False)
        report["accuracy"] = {"exact": True} if is_exact else sampled_errors(mesh, method.rows(solver), resolved)
    lines = [
        f"sources: {report['queries']}" + (f", of which {resumed} were there" if resumed else ""),
        *shard.lines(),
        f"largest: {report['largest_distance']:.10g}",
    ]
    if "time" in report:
        lines.insert(1, time_line(report["time"]))
    if "robust" in report:
        lines.append(robust_line(report["robust"]))
    if "accuracy" in report:
        lines += accuracy_lines(report)
    if report["unreachable"]:
        where = "beyond the limit" if report.get("limit") else "to components without the source"
        lines.append(f"warning: {counted(report['unreachable'], 'distance')} {where}: {beyond:g}")
    job.finish(whole, report, lines)


@dataclass(frozen=True)
class _Batch:
    """The sources ``first`` to ``last`` - 1 of some queries, and what is written of their distances."""

    queries: ResolvedQueries
    dtype: str
    beyond: float
    groups: "LabelGroups | None"
    first: int
    last: int

    def shape(self, mesh: "TriangleMesh", first: int, last: int) -> tuple[int, ...]:
        """Shape of the answers to some sources."""
        if self.groups:
            return (last - first, len(self.groups.statistics), len(self.groups.values))
        return self.queries.shape(mesh, first, last)

    def fill(self, job: Job, answers: Answers, unfinished: "ResumableFile", size: int) -> dict[str, Any]:
        """Compute and append all blocks that are not there; return the statistics of all."""
        statistics = {"largest_distance": 0.0, "unreachable": 0, **unfinished.note}
        begins = range(self.first + unfinished.done, self.last, size)
        spans = [(begin, min(begin + size, self.last)) for begin in begins]
        found = answers(spans)
        with progress("geodesic") as bar:
            for _, end in spans:
                with job.stage("compute"):
                    data, of_block = next(found)
                with job.stage("write"):
                    statistics = joined_statistics([statistics, of_block])
                    unfinished.append(data, end - self.first, statistics)
                bar((end - self.first) / (self.last - self.first))
        return statistics

    def written(self, values: "Floats") -> tuple[bytes, dict[str, Any]]:
        """What is written of distances from some sources, and their statistics, zeros of tables."""
        if self.groups:
            return self.groups.of_rows(values).astype(self.dtype).tobytes(), joined_statistics([])
        statistics = statistics_of(values)
        values[values == inf] = self.beyond
        return values.astype(self.dtype).tobytes(), statistics


@dataclass(frozen=True)
class _Problem:
    """Queries on a mesh. A worker has a copy, and its solver."""

    mesh: "TriangleMesh"
    batch: _Batch
    method: DistanceMethod

    @cached_property
    def solver(self) -> Any:
        """The solver for all queries."""
        return self.method.solver(self.mesh, self.batch.queries.count)

    def __getstate__(self) -> dict[str, Any]:
        """Leave the solver here."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    def block(self, span: tuple[int, int]) -> tuple[bytes, dict[str, Any]]:
        """What is written of the distances from a span of the sources, and their statistics."""
        rows = self.method.rows(self.solver)
        return self.batch.written(self.batch.queries.distances(self.mesh, rows, *span))

    def offset(self, first: int) -> int:
        """Bytes of all blocks before a source."""
        return prod(self.batch.shape(self.mesh, self.batch.first, first)) * int(self.batch.dtype[-1])


@contextmanager
def _answers(problem: _Problem, unfinished: "ResumableFile", scheduler: str | None) -> Iterator[Answers]:
    """A function that yields, for spans of the sources in order, bytes to append and the statistics."""
    if scheduler is None:
        yield partial_call(map, problem.block)
        return
    from geomhw_cli.runtime.dask_cluster import connected, in_order

    with connected(scheduler) as client:
        yield lambda spans: in_order(client, _on_worker, spans, problem, (unfinished.place(), unfinished.start))


def _on_worker(
    span: tuple[int, int], problem: _Problem, target: "tuple[Place, int]"
) -> tuple["bytes | Written", dict[str, Any]]:
    """Compute on a worker, whose threads share the solver, and write to the file itself if it is there."""
    from geomhw.io.artifacts.resumable_file import write_part

    with _SOLVING:
        data, statistics = problem.block(span)
    place, start = target
    return write_part(place, start + problem.offset(span[0]), data) or data, statistics


def _identity(
    mesh: "TriangleMesh",
    queries: DistanceQueries,
    resolved: ResolvedQueries,
    dtype: str,
    method: DistanceMethod,
    beyond: float,
    table: LabelTable | None,
) -> dict[str, Any]:
    """What tells a run from others: its partial file and its shards are those of no other run."""
    from geomhw import __version__

    run = {"version": __version__, "mesh": mesh.digest, "question": queries.option, "sources": queries.digest}
    run |= {"precision": dtype} | method.report() | ({"beyond": str(beyond)} if beyond != inf else {})
    return run | resolved.report() | (table.report() if table else {})


def _finish(
    job: Job,
    kind: str,
    queries: DistanceQueries,
    batch: _Batch,
    unfinished: "ResumableFile",
    run: Mapping[str, Any],
    about: Mapping[str, Any],
    shard: ShardPart,
) -> dict[str, Any]:
    """Make the output, a whole file or a shard, of the unfinished one; return statistics that replace others."""
    import numpy as np

    from geomhw.io.artifacts.shards import write_shard

    output, start, found = job.outputs[0], unfinished.start, dict[str, Any]()
    chunks: Any = partial_call(file_chunks, unfinished.path, start)
    if kind == "pairs":
        distances = np.fromfile(unfinished.path, dtype=batch.dtype, offset=start)
        words = [pair.words for pair in queries.pairs]
        chunks = partial_call(pair_lines, words, batch.queries.lines_of(batch.first, batch.last), distances)
    if not shard.is_whole:
        write_shard(output, run, shard.number, shard.of, kind, about, chunks)
    elif kind == "pairs":
        write_pairs(output, chunks(), batch.dtype)
    elif kind == "labels":
        shape = tuple(about["shape"])
        values = np.memmap(unfinished.path, dtype=batch.dtype, mode="r", offset=start, shape=shape)
        found = write_labels(output, values, about)
    else:
        unfinished.finish()
        return found
    unfinished.discard()
    return found


def _check_files(job: Job, queries: DistanceQueries, extensions: list[str], shard: ShardPart) -> None:
    """Raise an error unless there is one output, and it and the files of a partial run can be written."""
    if len(job.outputs) != 1:
        end = ".shard" if not shard.is_whole else extensions[0]
        raise click.UsageError(f"{queries.option} writes one file; give -o D{end}.")
    (output,) = job.outputs
    require_writable([output], shard.extensions(extensions))
    partial = [output.with_name(f"{output.stem}.partial{suffix}") for suffix in (".npy", ".json")]
    require_writable(partial, [".npy", ".json"])


def _open_unfinished(job: Job, run: dict[str, Any], shape: tuple[int, ...], dtype: str) -> "ResumableFile":
    """The file of all distances, with those of an earlier run if it was the same."""
    from geomhw.io.artifacts.arrays import npy_header
    from geomhw.io.artifacts.resumable_file import ResumableFile

    header = npy_header(shape, dtype)
    return ResumableFile(job.outputs[0], run, header, len(header) + prod(shape) * int(dtype[-1]), ".npy")
