"""Geodesic distances over MPI ranks: ``geodesic --engine petsc``."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geomhw.wording import counted
from geomhw_cli.runtime.job import time_line
from geomhw_cli.runtime.mpi_runs import RankedCommand, engine_line, heat_line
from geomhw_cli.runtime.mpi_sources import source_points
from geomhw_cli.specs.sources import SourceSpecs, source_line

if TYPE_CHECKING:
    from geomhw.distributed import LocalMesh, LocalResult
    from geomhw.stages import Stages


def distances_over_ranks(
    mesh_path: Path,
    sources: SourceSpecs,
    time: str,
    bound: bool,
    outputs: Sequence[Path],
    report: Mapping[str, bool],
) -> None:
    """Compute, write and report distances on the mesh of a file that all ranks read."""
    from geomhw.distributed import WRITABLE

    def compute(mesh: "LocalMesh", stages: "Stages", remarks: list[str]) -> "LocalResult":
        from geomhw.distributed import distributed_distance

        return distributed_distance(mesh, source_points(mesh, sources, remarks), time, bound, stages)

    RankedCommand("geodesic", {"sources", "time", "bound"}, compute, _lines, WRITABLE).run(mesh_path, outputs, report)


def _lines(answers: Mapping[str, Any]) -> list[str]:
    poisson, farthest = answers["poisson"], answers["farthest"]
    iterations = f"{counted(poisson['iterations'], 'iteration')} with {poisson['preconditioner']}"
    lines = [
        source_line(answers["sources"]),
        time_line(answers["time"]),
        f"farthest: vertex {farthest['vertex']} at {farthest['distance']:.10g}",
        engine_line(answers["engine"], f"heat in {heat_line(answers['heat'])}, distance in {iterations}"),
    ]
    if unreached := answers["unreachable_vertices"]:
        lines.append(
            f"warning: {counted(unreached, 'vertex', 'vertices')} on components without a source: distance inf"
        )
    return lines
