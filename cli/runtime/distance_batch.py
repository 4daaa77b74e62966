"""Distances for many queries on one mesh, written block by block to a file from which an interrupted run resumes."""

from math import inf, prod
from typing import TYPE_CHECKING, Any

import click

from geomhw.wording import counted
from geomhw_cli.runtime.accuracy import accuracy_lines
from geomhw_cli.runtime.job import Job, robust_line, time_line
from geomhw_cli.runtime.progress import progress
from geomhw_cli.specs.distance_methods import DistanceMethod
from geomhw_cli.specs.files import require_writable
from geomhw_cli.specs.label_tables import LabelTable
from geomhw_cli.specs.masks import MaskSpec, MeshPart
from geomhw_cli.specs.queries import DistanceQueries, ResolvedQueries

if TYPE_CHECKING:
    from geomhw.arrays import Floats
    from geomhw.geodesic.heat_method import HeatDistance
    from geomhw.geodesic.label_groups import LabelGroups
    from geomhw.io import ResumableFile


def compute_distances(
    job: Job,
    queries: DistanceQueries,
    dtype: str,
    method: DistanceMethod,
    beyond: float,
    mask: MaskSpec | None,
    table: LabelTable | None = None,
) -> None:
    """Compute the distances and write them to the output of the job, which must be one file.

    dtype: ``<f4`` or ``<f8``. beyond: the value for infinite distances. Blocks depend on the mesh alone, so that a
    resumed run writes the same bytes.
    """
    from geomhw.geodesic.heat_method import HeatDistance, block_size

    _check_files(job, queries, table)
    whole = job.read()
    part = MeshPart.of(whole, mask)
    mesh, resolved = part.mesh, queries.resolve(whole)
    job.remarks += resolved.remarks
    if resolved.sets is not None:
        resolved.sets = [part.points(points) for points in resolved.sets]
    groups = table.groups(part) if table else None
    with job.stage("set up"):
        solver = method.solver(mesh, resolved.count)
    run = {"mesh": mesh.digest, "question": queries.option, "sources": queries.digest, "precision": dtype}
    run |= method.report() | ({"beyond": str(beyond)} if beyond != inf else {})
    run |= table.report() if table else {}
    shape = (resolved.count, len(groups.statistics), len(groups.values)) if groups else resolved.shape(mesh)
    partial = _open_partial(job, run, shape, dtype)
    resumed, size = partial.done, block_size(mesh.n_vertices)
    statistics = {"largest_distance": 0.0, "unreachable": 0, **partial.note}
    with partial:
        try:
            with progress("geodesic") as bar:
                for first in range(resumed, resolved.count, size):
                    last = min(first + size, resolved.count)
                    with job.stage("compute"):
                        values = resolved.distances(mesh, method.rows(solver), first, last)
                    with job.stage("write"):
                        if groups:
                            values = groups.of_rows(values)
                        else:
                            _update(statistics, values)
                            values[values == inf] = beyond
                        partial.append(values.astype(dtype).tobytes(), last, statistics)
                    bar(last / resolved.count)
            with job.stage("write"):
                if groups:
                    _write_table(job, groups, partial, beyond, statistics)
                elif queries.is_pairs:
                    _write_pairs(job, queries, resolved, partial, dtype)
                else:
                    partial.finish()
        except KeyboardInterrupt as stop:
            if partial.done:
                done = f"{partial.done} of {resolved.count} sources are kept in {partial.path.name}"
                stop.args = (f"{done}, and the same command goes on from there",)
            raise
    job.written.append(str(job.outputs[0]))
    report = {
        "question": queries.option.removeprefix("--"),
        "queries": resolved.count,
        "resumed_after": resumed,
        "shape": list(shape),
        "numbers": "single" if dtype == "<f4" else "double",
        **statistics,
        **solver.settings(),
        **({"limit": limit} if (limit := method.settings.get("limit", inf)) < inf else {}),
    }
    if isinstance(solver, HeatDistance) and not job.quiet:
        report["accuracy"] = _accuracy(solver, resolved, report["refined"])
    lines = [
        f"sources: {resolved.count}" + (f", of which {resumed} were there" if resumed else ""),
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


def _accuracy(solver: "HeatDistance", resolved: ResolvedQueries, refined: bool) -> dict[str, Any]:
    """The errors of the distances from the first sources that lie on the surface."""
    from geomhw.geodesic.accuracy import distance_errors
    from geomhw.mesh.surface_points import vertex_points

    if refined:
        return {"exact": True}
    mesh = solver.mesh
    points = resolved.sets[0] if resolved.sets else vertex_points(mesh, [int(mesh.faces.min())])
    return {"exact": False, "of_sources": points.report(), **distance_errors(mesh, points, solver.rows([points])[0])}


def compute_matrix(job: Job, limit: float, mask: MaskSpec | None) -> None:
    """Write the sparse matrix of exact distances between all vertices within a limit to the output of the job."""
    from geomhw.geodesic.exact import ExactDistance
    from geomhw.io import write_matrix

    require_writable(job.outputs, [".npz"])
    mesh = job.read()
    with job.stage("set up"):
        solver = ExactDistance(MeshPart.of(mesh, mask).mesh)
    with job.stage("compute"):
        matrix = solver.matrix(limit)
    with job.stage("write"):
        write_matrix(job.outputs[0], matrix)
    job.written.append(str(job.outputs[0]))
    n, stored, largest = mesh.n_vertices, matrix.nnz, float(matrix.data.max(initial=0.0))
    report = {"question": "all-pairs", "queries": n, "shape": [n, n], "stored": stored, "largest_distance": largest}
    lines = [f"sources: {n}", f"stored: {stored} distances within {limit:g}", f"largest: {largest:.10g}"]
    job.finish(mesh, {**report, **solver.settings(), "limit": limit}, lines)


def _check_files(job: Job, queries: DistanceQueries, table: LabelTable | None) -> None:
    """Raise an error unless there is one output, and it and the files of a partial run can be written."""
    if len(job.outputs) != 1:
        raise click.UsageError(f"{queries.option} writes one file; give -o D.{'csv' if table else 'npy'}.")
    (output,) = job.outputs
    extensions = [".csv"] if table else [".npy", ".csv"] if queries.is_pairs else [".npy"]
    require_writable([output], extensions)
    partial = [output.with_name(f"{output.stem}.partial{suffix}") for suffix in (".npy", ".json")]
    require_writable(partial, [".npy", ".json"])


def _open_partial(job: Job, run: dict[str, Any], shape: tuple[int, ...], dtype: str) -> "ResumableFile":
    """The file of all distances, with those of an earlier run if it was the same."""
    from geomhw import __version__
    from geomhw.io.artifacts.arrays import npy_header
    from geomhw.io.artifacts.resumable_file import ResumableFile

    header = npy_header(shape, dtype)
    size = len(header) + prod(shape) * int(dtype[-1])
    return ResumableFile(job.outputs[0], {"version": __version__, **run}, header, size, ".npy")


def _update(statistics: dict[str, Any], values: "Floats") -> None:
    """Include values in the largest finite distance and the number of infinite ones."""
    import numpy as np

    finite = np.isfinite(values)
    statistics["largest_distance"] = max(statistics["largest_distance"], float(values.max(where=finite, initial=0.0)))
    statistics["unreachable"] += int(values.size - np.count_nonzero(finite))


def _write_table(
    job: Job, groups: "LabelGroups", partial: "ResumableFile", beyond: float, statistics: dict[str, Any]
) -> None:
    """Write the statistics between labels, one row per pair, and include them in the statistics of the report."""
    import numpy as np

    from geomhw.io import write_csv

    table = groups.table(np.load(partial.path, mmap_mode="r"))
    _update(statistics, table)
    table[table == inf] = beyond
    labels = [int(value) if value.is_integer() else value for value in groups.values.tolist()]
    rows = [
        {"source": source, "target": target, **dict(zip(groups.statistics, values, strict=True))}
        for k, source in enumerate(labels)
        for target, values in zip(labels, table[:, k].T.tolist(), strict=True)
    ]
    write_csv(job.outputs[0], rows)
    partial.discard()


def _write_pairs(
    job: Job, queries: DistanceQueries, resolved: ResolvedQueries, partial: "ResumableFile", dtype: str
) -> None:
    """Write the distances of pairs in the order of their lines."""
    import csv

    import numpy as np

    from geomhw.io import replacing
    from geomhw.io.artifacts.arrays import npy_header, read_numpy

    distances = np.empty(len(queries.pairs), dtype=dtype)
    distances[resolved.lines] = read_numpy(partial.bytes_so_far())
    with replacing(job.outputs) as (temporary,):
        if job.outputs[0].suffix.lower() == ".npy":
            temporary.write_bytes(npy_header(distances.shape, dtype) + distances.tobytes())
        else:
            rows = zip(queries.pairs, distances.tolist(), strict=True)
            with temporary.open("w", encoding="utf-8", newline="") as stream:
                writer = csv.writer(stream, lineterminator="\n")
                writer.writerow(["source", "target", "distance"])
                writer.writerows([*pair.words, repr(distance)] for pair, distance in rows)
    partial.discard()
