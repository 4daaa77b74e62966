"""Geodesic distances over MPI ranks: the options that there are, the files, and the report of rank 0."""

import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from geomhw.errors import ArgumentError, GeomhwError
from geomhw.stages import Stages
from geomhw.wording import counted
from geomhw_cli.runtime.job import print_json, time_line
from geomhw_cli.specs.files import STANDARD, require_writable
from geomhw_cli.specs.sources import SourceSpecs, Spec, shortened, source_line
from geomhw_cli.specs.vertex_lists import VertexList

if TYPE_CHECKING:
    from geomhw.arrays import Ints
    from geomhw.distributed import LocalMesh, Ranks

#: Parameters of ``geodesic`` that the engine has.
OPTIONS = {"mesh_path", "sources", "time", "bound", "engine", "outputs", "as_json", "quiet", "verbose"}
#: Environment variables in which MPI libraries give a process its rank.
RANK_VARIABLES = ("OMPI_COMM_WORLD_RANK", "PMI_RANK", "PMIX_RANK", "SLURM_PROCID")


def distances_over_ranks(
    mesh_path: Path,
    sources: SourceSpecs,
    time: str,
    bound: bool,
    outputs: Sequence[Path],
    report: Mapping[str, bool],
) -> None:
    """Compute, write and report distances on the mesh of a file that all ranks read.

    Errors that all ranks have are printed by the first.
    """
    try:
        _require_options()
        from geomhw.distributed import WRITABLE, connect

        if mesh_path == STANDARD:
            raise ArgumentError("standard input cannot be read in slices; give a binary PLY file")
        targets = list(outputs) or [Path(f"{mesh_path.stem}.geodesic.pvtu")]
        require_writable(targets, WRITABLE)
        ranks = _needed(connect)
        with ranks.stopping_together():
            _run(ranks, mesh_path, sources, time, bound, targets, report)
    except (GeomhwError, click.UsageError):
        if _is_later_rank():  # exit code 0, since mpirun ends the first rank, perhaps before it prints, at another one
            click.get_current_context().exit(0)
        raise


def _is_later_rank() -> bool:
    """Whether this is a rank other than the first, as far as the environment tells."""
    return next((os.environ[name] for name in RANK_VARIABLES if name in os.environ), "0") != "0"


def _needed(connect: "Callable[[], Ranks]") -> "Ranks":
    """Start MPI. Raises ArgumentError that names the option, if a library is missing."""
    try:
        return connect()
    except ArgumentError as error:
        raise ArgumentError(f"--engine petsc: {error}") from error


def _require_options() -> None:
    """Raise UsageError for an option that is given and that the engine does not have."""
    context = click.get_current_context()
    for option in context.command.params:
        given = context.get_parameter_source(option.name or "") is ParameterSource.COMMANDLINE
        if given and option.name not in OPTIONS:
            raise click.UsageError(f"{option.opts[0]} and --engine petsc exclude each other.")


def _run(
    ranks: "Ranks",
    mesh_path: Path,
    sources: SourceSpecs,
    time: str,
    bound: bool,
    targets: Sequence[Path],
    report: Mapping[str, bool],
) -> None:
    from geomhw.distributed import distribute, distributed_distance, open_sliced, write_distributed

    stages, before = Stages(), _peak_memory()
    with stages("read and distribute"):
        with ranks.agreeing():
            file = open_sliced(mesh_path)
        mesh = distribute(ranks, file)
    result = distributed_distance(mesh, _vertices(mesh, sources), time, bound, stages)
    with stages("write"):
        written = write_distributed(result, list(targets))
    used = ranks.sum(_peak_memory() - before) / mesh.n_vertices
    engine = {
        "name": "petsc",
        "petsc": ".".join(map(str, ranks.petsc.Sys.getVersion())),
        "ranks": ranks.size,
        "vertices": ranks.comm.allgather(mesh.n_own),
        "ghosts": ranks.comm.allgather(len(mesh.ghosts)),
        "bytes_sent": ranks.comm.allgather(ranks.bytes_sent),
        "bytes_per_vertex": round(used, 1),
    }
    if ranks.rank or report["quiet"]:
        return
    answers = shortened(result.report)
    size = {"vertices": mesh.n_vertices, "faces": file.n_faces, "mean_edge_length": answers.pop("mean_edge_length")}
    lines = _lines(answers, engine)
    if report["as_json"]:
        warnings = [line for line in lines if line.startswith("warning: ")]
        head = {"command": "geodesic", "input": {"path": str(mesh_path)}, "mesh": size, **answers, "engine": engine}
        print_json({**head, "remarks": warnings, "files": written, "seconds": stages.seconds})
        return
    first = f"mesh: {size['vertices']} vertices, {size['faces']} faces, h = {size['mean_edge_length']:.6g}"
    for line in [first, *lines, *(f"wrote: {path}" for path in written)]:
        label, text = line.split(": ", 1)
        click.echo(f"{label:<10}{text}")


def _lines(answers: Mapping[str, Any], engine: Mapping[str, Any]) -> list[str]:
    heat, poisson, farthest = answers["heat"], answers["poisson"], answers["farthest"]
    steps = f"{heat['per_vertex']:.1f} sweeps" if heat["method"] == "sweeps" else counted(heat["rounds"], "round")
    lines = [
        source_line(answers["sources"]),
        time_line(answers["time"]),
        f"farthest: vertex {farthest['vertex']} at {farthest['distance']:.10g}",
        f"engine: PETSc {engine['petsc']} on {counted(engine['ranks'], 'rank')}, heat in {steps}, distance in "
        f"{counted(poisson['iterations'], 'iteration')} with {poisson['preconditioner']}, "
        f"{engine['bytes_per_vertex']:.0f} bytes per vertex",
    ]
    if unreached := answers["unreachable_vertices"]:
        lines.append(
            f"warning: {counted(unreached, 'vertex', 'vertices')} on components without a source: distance inf"
        )
    return lines


def _vertices(mesh: "LocalMesh", sources: SourceSpecs) -> "Ints":
    """The source vertices as numbers of the file. Raises ArgumentError for sources that are no vertices."""
    import numpy as np

    from geomhw.distributed import extreme_vertex

    found = []
    for spec in sources.specs or [Spec({"end": "max", "axis": "y"})]:
        if isinstance(spec, VertexList):
            found.append(np.asarray(spec.vertices, dtype=np.int64))
        elif first := spec.parts.get("first"):
            last = int(spec.parts.get("last") or first)
            if last >= mesh.n_vertices:
                raise ArgumentError(f"source {last} is not a vertex: the mesh has {mesh.n_vertices}")
            found.append(np.arange(int(first), last + 1))
        elif axis := spec.parts.get("axis"):
            sign = 1 if spec.parts["end"] == "max" else -1
            found.append(np.array([extreme_vertex(mesh, "xyz".index(axis), sign)]))
        else:
            raise ArgumentError(
                "--engine petsc has vertices as sources: 12 or 12,40-44, max-y and so on, @FILE of them"
            )
    return np.concatenate(found)


def _peak_memory() -> int:
    """The largest memory of this process so far, in bytes; 0 where the system does not tell."""
    try:
        import resource
    except ImportError:
        return 0
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
