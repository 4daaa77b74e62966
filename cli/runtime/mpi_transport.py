"""Vector transport over MPI ranks: ``vecdiffuse --engine petsc``."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geomhw_cli.runtime.job import time_line
from geomhw_cli.runtime.mpi_runs import RankedCommand, engine_line, heat_line
from geomhw_cli.runtime.mpi_sources import source_points
from geomhw_cli.runtime.transport_reach import lines_on_reach
from geomhw_cli.specs.sources import SourceSpecs, source_line

if TYPE_CHECKING:
    from geomhw.arrays import Floats, Ints
    from geomhw.distributed import LocalMesh, LocalResult
    from geomhw.mesh.surface_points import SurfacePoints
    from geomhw.mesh.triangle_mesh import TriangleMesh
    from geomhw.options import Connection
    from geomhw.stages import Stages

#: Parameters of ``vecdiffuse`` that exist over ranks.
OPTIONS = {"sources", "vector", "angle", "seed", "times", "connection"}


def transport_over_ranks(
    mesh_path: Path,
    sources: SourceSpecs,
    vectors: "Callable[[TriangleMesh, SurfacePoints, Ints], Floats]",
    times: Sequence[str],
    connection: "Connection",
    outputs: Sequence[Path],
    report: Mapping[str, bool],
) -> None:
    """Compute, write and report vectors on the mesh of a file that all ranks read.

    vectors: returns the vectors at sources, (s, 3), on the mesh of the faces round them, from that mesh, the sources
        on it, and their `source_orientation`.
    """
    from geomhw.distributed import WRITABLE

    def compute(mesh: "LocalMesh", stages: "Stages", remarks: list[str]) -> "LocalResult":
        from geomhw.distributed import distributed_transport, source_orientation, source_stars

        points = source_points(mesh, sources, remarks)
        with stages("sources"):
            stars = source_stars(mesh, points.corners)
            sides = source_orientation(mesh, stars, points)
        given = vectors(stars.mesh, stars.points(points), sides)
        return distributed_transport(mesh, stars, points, given, times, connection, stages)

    writable = [extension for extension in WRITABLE if extension != ".npy"]
    RankedCommand("vecdiffuse", OPTIONS, compute, _lines, writable).run(mesh_path, outputs, report)


def _lines(answers: Mapping[str, Any]) -> list[str]:
    work = ", ".join(f"vectors in {heat_line(heat['vectors'])}" for heat in answers["heat"])
    lines = [source_line(answers["sources"]), *(time_line(step, "dt") for step in answers["times"])]
    lines.append(engine_line(answers["engine"], work))
    return lines + lines_on_reach(answers)
