"""One run of a command: its files, its stages with their times, and its report."""

import json
import logging
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from geomhw.errors import RenderError
from geomhw.options import PANEL_WIDTH
from geomhw.stages import Stages

if TYPE_CHECKING:
    from geomhw.mesh.triangle_mesh import TriangleMesh
    from geomhw.results import Result


@dataclass
class Job:
    """A run of a command on one mesh.

    outputs, png: files to write. notes: remarks of the reader. written: files so far.
    """

    command: str
    mesh_path: Path
    outputs: Sequence[Path] = ()
    png: Path | None = None
    width: int = PANEL_WIDTH
    as_json: bool = False
    quiet: bool = False
    notes: dict[str, Any] = field(default_factory=dict)
    written: list[str] = field(default_factory=list)
    stages: Stages = field(default_factory=Stages)

    def __post_init__(self) -> None:
        if self.quiet:
            logging.getLogger("geomhw").setLevel(logging.ERROR)

    @classmethod
    def plan(
        cls,
        command: str,
        mesh_path: Path,
        inputs: Sequence[Path],
        *,
        outputs: Sequence[Path],
        png: Path | None,
        no_png: bool,
        width: int,
        **report: Any,
    ) -> "Job":
        """Check, before any computation, that all files can be written.

        Without outputs, they are ``<stem>.<command>.vtk`` and ``.png`` in the current directory.
        """
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
        return cls(command, mesh_path, outputs, png, width, **report)

    def stage(self, name: str) -> AbstractContextManager[None]:
        """Measure the time of a block, under this name in the report."""
        return self.stages(name)

    def read(self) -> "TriangleMesh":
        """Read the mesh; remarks of the reader go to the report."""
        from geomhw.io import read

        with self.stage("read"):
            content = read(self.mesh_path)
        self.notes = content.report
        return content.mesh

    def read_oriented(self) -> "TriangleMesh":
        """Read the mesh and orient its faces consistently; the number of turned faces goes to the report."""
        from geomhw.mesh.orientation import oriented

        original = self.read()
        mesh = oriented(original)
        if turned := int((mesh.faces != original.faces).any(axis=1).sum()):
            self.notes = {**self.notes, "turned_faces": turned}
        return mesh

    def write(self, result: "Result", picture: Callable[..., Any]) -> None:
        """Write the data files, all or none, then the picture, so that a failure to draw loses no data.

        picture: draws a result, with panels of a ``width``.
        """
        from geomhw.io import write, write_png

        with self.stage("write"):
            write(result, self.outputs)
        self.written += map(str, self.outputs)
        if self.png:
            try:
                with self.stage("render"):
                    write_png(self.png, picture(result, width=self.width))
            except RenderError as error:
                done = ", ".join(self.written)
                raise RenderError(f"{error} ({done} is written; --no-png leaves the picture out)") from error
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
            print_json(report)
        elif not self.quiet:
            for line in [f"mesh: {mesh_line(report['mesh'])}", *lines, *(f"wrote: {path}" for path in self.written)]:
                label, text = line.split(": ", 1)
                click.echo(f"{label:<10}{text}")

    def _remarks(self, mesh: "TriangleMesh") -> list[str]:
        """Notes and warnings about the mesh."""
        lines = []
        if turned := self.notes.get("turned_faces"):
            lines.append(f"note: {turned} faces are turned, also in the output, to orient the mesh consistently")
        if copies := len(mesh.duplicate_faces):
            lines.append(f"warning: {copies} faces are copies of others; geomhw info --check lists them")
        return lines


def print_json(report: Mapping[str, Any]) -> None:
    """Print a report as JSON."""
    click.echo(json.dumps(report, indent=2, allow_nan=False))


def time_line(time: Mapping[str, Any]) -> str:
    """The report of a diffusion time in one line, as a multiple of h² first."""
    return f"time: t = {time['t_over_h2']:.6g} h² = {time['t']:.6g} ({time['reason']})"


def robust_line(report: Mapping[str, Any]) -> str:
    """The report of a `RobustTriangulation` in one line."""
    parts = [f"edge flips {report['edge_flips']}"]
    if report["sheets"] == 2:
        parts.append("both sides of the mesh")
    if report["mollification"]:
        parts.append(f"lengths + {report['mollification']:.3g}")
    return f"robust: {', '.join(parts)}, h = {report['mean_edge_length']:.6g}"


def mesh_line(mesh: Mapping[str, Any]) -> str:
    """Sizes and topology in one line."""
    parts = [f"{mesh['vertices']} vertices", f"{mesh['faces']} faces"]
    parts.append("genus " + ("undefined" if mesh["genus"] is None else str(mesh["genus"])))
    for key, singular, plural in [
        ("components", "component", "components"),
        ("boundary_loops", "boundary loop", "boundary loops"),
        ("unreferenced_vertices", "unreferenced vertex", "unreferenced vertices"),
    ]:
        if mesh[key] > (key == "components"):
            parts.append(f"{mesh[key]} {singular if mesh[key] == 1 else plural}")
    return ", ".join(parts) + f", h = {mesh['mean_edge_length']:.6g}"
