"""One run of a command: plans its files, keeps time, writes data before pictures, prints the report."""

import json
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from geomhw.errors import RenderError
from geomhw.stages import Stages

if TYPE_CHECKING:
    from geomhw.mesh.triangle_mesh import TriangleMesh
    from geomhw.results import Result


@dataclass
class Job:
    """What a command was asked for, and what it has done so far.

    outputs, png: files to write, checked before any work is done.
    """

    command: str
    mesh_path: Path
    outputs: Sequence[Path] = ()
    png: Path | None = None
    as_json: bool = False
    quiet: bool = False
    notes: dict[str, Any] = field(default_factory=dict)
    written: list[str] = field(default_factory=list)
    stages: Stages = field(default_factory=Stages)

    @classmethod
    def plan(
        cls,
        command: str,
        mesh_path: Path,
        *,
        outputs: Sequence[Path] = (),
        png: Path | None = None,
        no_png: bool = False,
        as_json: bool = False,
        quiet: bool = False,
        inputs: Sequence[Path] = (),
    ) -> "Job":
        """Fill in default names: without -o, ``<stem>.<command>.vtk`` and ``.png`` in the current directory."""
        from geomhw.io import WRITABLE, check_outputs

        if png and no_png:
            raise click.UsageError("--png and --no-png exclude each other.")
        name = f"{mesh_path.stem}.{command}"
        if not outputs:
            outputs = [Path(f"{name}.vtk")]
            png = png or (None if no_png else Path(f"{name}.png"))
        check_outputs(outputs, [mesh_path, *inputs])
        if png:
            check_outputs([png], [mesh_path, *inputs], extensions=[".png"])
            check_outputs([*outputs, png], extensions=[*WRITABLE, ".png"])
        return cls(command, mesh_path, outputs, png, as_json, quiet)

    def stage(self, name: str) -> AbstractContextManager[None]:
        """Time what happens inside under that name."""
        return self.stages(name)

    def read(self) -> "TriangleMesh":
        """The mesh of the command line; what the reader noticed goes to the report."""
        from geomhw.io import read

        with self.stage("read"):
            found = read(self.mesh_path)
        self.notes = found.report
        return found.mesh

    def read_oriented(self) -> "TriangleMesh":
        """The same with faces turned so that they agree on what is up; how many were goes to the report."""
        from geomhw.mesh.orientation import oriented

        given = self.read()
        mesh = oriented(given)
        if turned := int((mesh.faces != given.faces).any(axis=1).sum()):
            self.notes = {**self.notes, "turned_faces": turned}
        return mesh

    def write(self, result: "Result", picture: "Callable[[Result], Any] | None" = None) -> None:
        """Write the data files, all or none; then the picture, so that a failure to draw loses no data."""
        from geomhw.io import write, write_png

        with self.stage("write"):
            write(result, self.outputs)
        self.written += [str(path) for path in self.outputs]
        if self.png and picture:
            try:
                with self.stage("render"):
                    write_png(self.png, picture(result))
            except RenderError as error:
                kept = ", ".join(self.written)
                raise RenderError(f"{error} ({kept} is written; --no-png leaves the picture out)") from error
            self.written.append(str(self.png))

    def finish(self, mesh: "TriangleMesh", answers: Mapping[str, Any], lines: Sequence[str]) -> None:
        """Print the report: mesh, answers, files and times as JSON, or the mesh, these lines and the files."""
        from geomhw.mesh import mesh_summary

        lines = [*lines, *self._remarks(mesh)]
        report = {
            "command": self.command,
            "input": {"path": str(self.mesh_path), **self.notes},
            "mesh": mesh_summary(mesh),
            **answers,
            "remarks": [line for line in lines if line.startswith(("note: ", "warning: "))],
            "files": self.written,
            "seconds": self.stages.seconds,
        }
        if self.as_json:
            click.echo(json.dumps(report, indent=2, allow_nan=False))
        elif not self.quiet:
            width = 10
            for label, text in [("mesh", mesh_line(report["mesh"])), *[line.split(": ", 1) for line in lines]]:
                click.echo(f"{label:<{width}}{text}")
            for path in self.written:
                click.echo(f"{'wrote':<{width}}{path}")

    def _remarks(self, mesh: "TriangleMesh") -> list[str]:
        """What a reader of the results should know of the mesh."""
        lines = []
        if turned := self.notes.get("turned_faces"):
            lines.append(f"note: {turned} faces are turned, also in what is written, for all to agree on what is up")
        if copies := len(mesh.duplicate_faces):
            lines.append(f"warning: {copies} faces are copies of others; geomhw info --check names them")
        return lines


def robust_line(done: dict[str, Any]) -> str:
    """What --robust did, in one line."""
    parts = [f"edge flips {done['edge_flips']}, rounds {done['flip_rounds']}"]
    if done["sheets"] == 2:
        parts.append("both sides of the mesh")
    if done["mollification"]:
        parts.append(f"lengths + {done['mollification']:.3g}")
    return f"robust: {', '.join(parts)}, h = {done['mean_edge_length']:.6g}"


def mesh_line(mesh: dict[str, Any]) -> str:
    """Sizes and topology in one line."""
    parts = [f"{mesh['vertices']} vertices", f"{mesh['faces']} faces"]
    parts.append("genus " + ("undefined" if mesh["genus"] is None else str(mesh["genus"])))
    for key, one, many in [
        ("components", "component", "components"),
        ("boundary_loops", "boundary loop", "boundary loops"),
        ("unreferenced_vertices", "unreferenced vertex", "unreferenced vertices"),
    ]:
        if mesh[key] > (key == "components"):
            parts.append(f"{mesh[key]} {one if mesh[key] == 1 else many}")
    return ", ".join(parts) + f", h = {mesh['mean_edge_length']:.6g}"
