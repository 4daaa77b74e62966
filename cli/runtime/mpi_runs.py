"""Runs of a command over MPI ranks: the options that exist there, the files, and the report of rank 0."""

import os
import signal
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from threading import Event, Thread
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from geomhw.errors import ArgumentError, GeomhwError
from geomhw.stages import Stages
from geomhw.wording import counted
from geomhw_cli.runtime.job import print_json
from geomhw_cli.specs.files import STANDARD, require_writable
from geomhw_cli.specs.sources import shortened

if TYPE_CHECKING:
    from geomhw.distributed import LocalMesh, LocalResult, Ranks

#: Parameters that every command has over ranks.
SHARED = {"mesh_path", "engine", "outputs", "as_json", "quiet", "verbose"}
#: Environment variables in which MPI libraries give a process its rank.
RANK_VARIABLES = ("OMPI_COMM_WORLD_RANK", "PMI_RANK", "PMIX_RANK", "SLURM_PROCID")
#: What the first rank prints at SIGTERM.
ENDED = (
    "the run was ended from outside, as mpirun does when a rank is killed, often for lack of memory; start more ranks"
)


@dataclass(frozen=True)
class RankedCommand:
    """A command over ranks.

    Attributes
    ----------
    name : of the command.
    options : names of its parameters that exist over ranks, without those of `SHARED`.
    compute : returns the result on the part of a rank; it may add lines to a list of remarks.
    lines : of the report, from that of the result.
    writable : extensions of its files; the first is the default.
    """

    name: str
    options: set[str]
    compute: "Callable[[LocalMesh, Stages, list[str]], LocalResult]"
    lines: Callable[[Mapping[str, Any]], list[str]]
    writable: Sequence[str]

    def run(self, mesh_path: Path, outputs: Sequence[Path], report: Mapping[str, bool]) -> None:
        """Compute, write and report on the mesh of a file that all ranks read.

        Errors that all ranks have are printed by the first.
        """
        try:
            self._require_options()
            from geomhw.distributed import connect

            if mesh_path == STANDARD:
                raise ArgumentError("standard input cannot be read in slices; give a file")
            targets = list(outputs) or [Path(f"{mesh_path.stem}.{self.name}{self.writable[0]}")]
            require_writable(targets, self.writable)
            ranks = _needed(connect)
            with _announced_end(ranks), ranks.stopping_together():
                self._run(ranks, mesh_path, targets, report)
        except (GeomhwError, click.UsageError):
            if _is_later_rank():  # exit code 0: at another one mpirun ends the first rank, perhaps before it prints
                click.get_current_context().exit(0)
            raise

    def _require_options(self) -> None:
        """Raise UsageError for an option that is given and that does not exist over ranks."""
        context = click.get_current_context()
        for option in context.command.params:
            given = context.get_parameter_source(option.name or "") is ParameterSource.COMMANDLINE
            if given and option.name not in self.options | SHARED:
                raise click.UsageError(
                    f"{option.opts[0]} and --engine petsc exclude each other; leave one of them out."
                )

    def _run(self, ranks: "Ranks", mesh_path: Path, targets: Sequence[Path], report: Mapping[str, bool]) -> None:
        from geomhw.distributed import distribute, open_sliced, write_distributed

        stages, before = Stages(), _peak_memory()
        with stages("read and distribute"):
            file = open_sliced(ranks, mesh_path)
            mesh = distribute(ranks, file)
        remarks: list[str] = []
        result = self.compute(mesh, stages, remarks)
        with stages("write"):
            written = write_distributed(result, list(targets))
        engine = _engine(ranks, mesh, _peak_memory() - before)
        if ranks.rank or report["quiet"]:
            return
        answers = shortened(result.report)
        size = {"vertices": mesh.n_vertices, "faces": file.n_faces, "mean_edge_length": answers.pop("mean_edge_length")}
        lines = [*self.lines({**answers, "engine": engine}), *remarks]
        if report["as_json"]:
            remarks = [line for line in lines if line.startswith(("warning: ", "note: "))]
            head = {"command": self.name, "input": {"path": str(mesh_path)}, "mesh": size, **answers, "engine": engine}
            print_json({**head, "remarks": remarks, "files": written, "seconds": stages.seconds})
            return
        first = f"mesh: {size['vertices']} vertices, {size['faces']} faces, h = {size['mean_edge_length']:.6g}"
        for line in [first, *lines, *(f"wrote: {path}" for path in written)]:
            label, text = line.split(": ", 1)
            click.echo(f"{label:<10}{text}")


def heat_line(heat: Mapping[str, Any]) -> str:
    """How a heat step was solved, for the line of the engine."""
    return f"{heat['per_vertex']:.1f} sweeps" if heat["method"] == "sweeps" else counted(heat["rounds"], "round")


def engine_line(engine: Mapping[str, Any], work: str) -> str:
    """The library, the ranks, the work of the solvers, and the memory."""
    ranks = counted(engine["ranks"], "rank")
    return f"engine: PETSc {engine['petsc']} on {ranks}, {work}, {engine['bytes_per_vertex']:.0f} bytes per vertex"


def _engine(ranks: "Ranks", mesh: "LocalMesh", used: int) -> dict[str, Any]:
    """The ranks, for a report; used: bytes of memory of this one."""
    return {
        "name": "petsc",
        "petsc": ".".join(map(str, ranks.petsc.Sys.getVersion())),
        "ranks": ranks.size,
        "vertices": ranks.comm.allgather(mesh.n_own),
        "ghosts": ranks.comm.allgather(len(mesh.ghosts)),
        "bytes_sent": ranks.comm.allgather(ranks.bytes_sent),
        "bytes_per_vertex": round(ranks.sum(used) / mesh.n_vertices, 1),
    }


def _is_later_rank() -> bool:
    """Whether this is a rank other than the first, as far as the environment tells."""
    return next((os.environ[name] for name in RANK_VARIABLES if name in os.environ), "0") != "0"


def _needed(connect: "Callable[[], Ranks]") -> "Ranks":
    """Start MPI. Raises ArgumentError that names the option, if a library is missing."""
    try:
        return connect()
    except ArgumentError as error:
        raise ArgumentError(f"--engine petsc: {error}") from error


@contextmanager
def _announced_end(ranks: "Ranks") -> Iterator[None]:
    """Print `ENDED` at SIGTERM, on the first rank, by a thread: MPI may never return to the main one."""
    if ranks.rank:
        yield
        return
    reader, writer = os.pipe()
    os.set_blocking(writer, False)
    before = signal.set_wakeup_fd(writer, warn_on_full_buffer=False)
    announced = Event()
    Thread(target=_announce, args=(reader, announced), daemon=True).start()
    try:
        yield
    except KeyboardInterrupt:
        if not announced.is_set():
            raise
        click.get_current_context().exit(128 + signal.SIGTERM)
    finally:
        signal.set_wakeup_fd(before)
        os.close(writer)


def _announce(reader: int, announced: Event) -> None:
    """Print a sentence at the first SIGTERM whose number arrives in a pipe, until that is closed."""
    while (number := os.read(reader, 1)) and number[0] != signal.SIGTERM:
        pass
    if number:
        announced.set()
        os.write(2, f"Error: {ENDED}\n".encode())
    os.close(reader)


def _peak_memory() -> int:
    """The largest memory of this process so far, in bytes; 0 where the system does not tell."""
    with suppress(OSError), open("/proc/self/status", encoding="ascii") as status:
        # Linux; `resource` would count the memory of the process that started this one.
        return next((1024 * int(line.split()[1]) for line in status if line.startswith("VmHWM:")), 0)
    try:
        import resource
    except ImportError:
        return 0
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss  # bytes on macOS
