"""What a run of ``geomhw geodesic`` would take, from the first bytes of the mesh file and the options alone."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING

import click

from geomhw.errors import ArgumentError
from geomhw.wording import counted
from geomhw_cli.runtime.job import print_json
from geomhw_cli.runtime.memory import available_memory
from geomhw_cli.specs.distance_methods import DistanceMethod
from geomhw_cli.specs.files import STANDARD, format_extension
from geomhw_cli.specs.queries import DistanceQueries
from geomhw_cli.specs.shards import ShardPart

if TYPE_CHECKING:
    from geomhw.io import MeshSize


@dataclass(frozen=True)
class Cost:
    """Processor seconds and megabytes on x million vertices: a + b x^p of each."""

    seconds: float = 0.0
    seconds_per_million: float = 0.0
    power: float = 1.0
    megabytes: float = 0.0
    megabytes_per_million: float = 0.0
    memory_power: float = 1.0

    def at(self, x: float) -> tuple[float, float]:
        """Seconds and megabytes."""
        memory = self.megabytes + self.megabytes_per_million * x**self.memory_power
        return self.seconds + self.seconds_per_million * x**self.power, memory


#: Measured by ``python tests/benchmarks/costs.py`` on 2 cores of a Xeon at 2.8 GHz, on spheres and scans of 642 to
#: 1,000,000 vertices. Where spheres and scans differ, the geometric mean.
COSTS = {
    # whole runs with one set of sources, reading a binary file and writing included
    "multigrid": Cost(1.0, 9, 1, 190, 1350),
    "direct": Cost(0.9, 60, 1.3, 75, 4500, 1.1),
    "exact": Cost(1.6, 54, 1.4, 190, 750),
    "fast-marching": Cost(0.6, 3.5, 1, 110, 520),
    "refine": Cost(1.6, 58, 1.4, 190, 1250),
    # in addition
    "robust": Cost(0.2, 8, 1, 10, 250),
    "accuracy": Cost(0.8, 25, 1, 90),
    "picture": Cost(3.0, 10, 1, 450),
    "text": Cost(0, 1.5),
    # seconds of one more set of sources, and megabytes of a block of sets
    "multigrid set": Cost(0, 5, 1, 0, 260),
    "direct set": Cost(0, 0.8, 1.25, 10, 5000),
    "exact set": Cost(0, 54, 1.4, 0, 260),
    "fast-marching set": Cost(0, 1.3, 1, 0, 260),
    # one more entry of a sparse matrix, in millions
    "entry": Cost(0, 1.4, 1, 0, 60),
}
#: The most vertices at which the report compares distances with exact ones, in millions.
COMPARED = 0.05
#: The most vertices, in millions, at which blocks have 32 sets; on more, they have fewer and take no more memory.
BLOCKS = 0.26
#: Vertices within the limit of each vertex that the estimate of a sparse matrix counts with.
NEIGHBORS = 1000
#: Formats that are text.
TEXT = (".off", ".obj", ".inp", ".msh", ".gltf")


@dataclass(frozen=True)
class Plan:
    """Options on which the cost of a run depends. width: bytes of a number of the matrix that is
    written, 0 without one. is_partial: whether some distances are not wanted.
    """

    method: DistanceMethod
    queries: DistanceQueries | None
    is_sparse: bool
    width: int
    is_partial: bool
    draws: bool
    quiet: bool
    shard: ShardPart

    def solver(self, size: "MeshSize", sets: int) -> str:
        """The stage of `COSTS` that computes distances."""
        from geomhw.solvers.auto import iterates

        settings = self.method.settings
        if self.method.name != "heat":
            return self.method.name
        if settings["refine"] or (settings["refine"] is None and settings["robust"]):
            return "refine"
        return "multigrid" if iterates(settings["solver"], size.vertices, sets) else "direct"

    def sets(self, n: int) -> int:
        """The number of sets of sources."""
        if self.queries is None:
            return 1
        first, last = self.shard.range(self.queries.count(n))
        return last - first

    def cost(self, size: "MeshSize", extension: str) -> tuple[float, float]:
        """Processor seconds and bytes of memory."""
        x = max(size.vertices, size.faces / 2) / 1e6
        sets = self.sets(size.vertices)
        solver = self.solver(size, sets)
        stages = [COSTS[solver].at(x)]
        if self.method.settings.get("robust"):
            stages.append(COSTS["robust"].at(x))
        if solver in ("multigrid", "direct", "fast-marching") and not self.quiet:
            stages.append(COSTS["accuracy"].at(min(x, COMPARED)))
        if self.draws:
            stages.append(COSTS["picture"].at(x))
        if extension in TEXT:
            stages.append(COSTS["text"].at(x))
        if self.is_sparse:
            stages.append(COSTS["entry"].at(size.vertices * min(size.vertices, NEIGHBORS) / self.shard.of / 1e6))
        elif sets > 1:
            further = COSTS[f"{'exact' if solver == 'refine' else solver} set"]
            stages.append((further.at(x)[0] * (sets - 1), further.at(min(x, BLOCKS))[1]))
        return sum(seconds for seconds, _ in stages), 1e6 * sum(megabytes for _, megabytes in stages)

    def remarks(self, size: "MeshSize") -> Iterator[str]:
        """What the estimate does not know."""
        limit = self.method.settings.get("limit", inf)
        if size.source == "file size":
            yield "note: this format has no counts in its first bytes; the file size gives them within a factor of two"
        if self.is_sparse:
            yield f"note: assumes {NEIGHBORS:,} vertices within the limit of each; both figures grow in proportion"
        elif limit < inf or self.is_partial:
            yield "note: without --limit, --to and --mask, which may save most of it"
        yield "note: within a factor of two to three, on 2 cores at 2.8 GHz; shared machines take longer"

    def output(self, n: int) -> int | None:
        """Bytes of the matrix of distances; None of other files."""
        return self.sets(n) * n * self.width if self.width else None


def print_estimate(path: Path, plan: Plan, as_json: bool) -> None:
    """Print what a run would take. Raises ArgumentError for standard input, which has no size."""
    from geomhw.io import mesh_size

    if path == STANDARD:
        raise ArgumentError("--estimate needs a file: standard input does not say how large it is")
    extension = format_extension(path)
    size = mesh_size(path, extension)
    n, available = size.vertices, available_memory()
    seconds, memory = plan.cost(size, extension or path.suffix.lower())
    sets, output = plan.sets(n), plan.output(n)
    fits = available is None or memory <= available
    divides = plan.method.name == "heat" and plan.queries is None
    remarks = list(plan.remarks(size))
    if not fits:
        advice = "; --engine petsc divides it among the processes of mpirun" if divides else ""
        remarks.append(f"warning: this machine has less memory, {_gigabytes(available or 0)}{advice}")
    report = {
        "command": "geodesic",
        "input": {"path": str(path)},
        "mesh": {"vertices": n, "faces": size.faces, "counts": size.source},
        "question": plan.queries.option.removeprefix("--") if plan.queries else "source",
        "queries": sets,
        **plan.shard.report(),
        "method": plan.solver(size, sets),
        "engine": "petsc" if divides and not fits else "embedded",
        "processor_seconds": float(f"{seconds:.3g}"),
        "memory": int(float(f"{memory:.3g}")),
        "memory_available": available,
        "output": output,
        "remarks": remarks,
    }
    if as_json:
        print_json(report)
        return
    lines = [f"mesh: {n:,} vertices, {size.faces:,} faces, by the {size.source}"]
    lines += [f"sets: {counted(sets, 'set')} of sources", *plan.shard.lines()]
    lines += [f"method: {report['method']}, engine {report['engine']}"]
    lines += [f"time: about {_duration(seconds)} of processor time", f"memory: about {_gigabytes(memory)}"]
    lines += [f"output: {_gigabytes(output)}"] if output is not None else []
    for line in [*lines, *remarks]:
        label, text = line.split(": ", 1)
        click.echo(f"{label:<10}{text}")


def _gigabytes(count: float) -> str:
    """Bytes in a readable unit."""
    unit, size = next((pair for pair in (("TB", 1e12), ("GB", 1e9)) if count >= pair[1]), ("MB", 1e6))
    return f"{count / size:.2g} {unit}" if count < 100 * size else f"{count / size:,.0f} {unit}"


def _duration(seconds: float) -> str:
    """Seconds in a readable unit."""
    units = (("days", 172800, 86400), ("hours", 7200, 3600), ("minutes", 120, 60))
    unit, size = next(((name, size) for name, least, size in units if seconds >= least), ("s", 1))
    return f"{seconds / size:.2g} {unit}" if seconds < 100 * size else f"{seconds / size:,.0f} {unit}"
