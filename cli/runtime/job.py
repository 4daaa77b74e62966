"""One run of a command: its files, its stages with their times, and its report."""

import json
import logging
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from geomhw.errors import RenderError
from geomhw.stages import Stages
from geomhw.wording import counted
from geomhw_cli.runtime.interrupts import restored
from geomhw_cli.runtime.picture_kinds import KINDS
from geomhw_cli.runtime.pictures import PictureFiles
from geomhw_cli.specs.files import STANDARD, file_stem, read_input, require_writable, write_outputs

if TYPE_CHECKING:
    from geomhw.mesh.triangle_mesh import TriangleMesh
    from geomhw.results import Cloud, Field, Result


@dataclass
class Job:
    """A run of a command on one mesh.

    outputs, pictures: files to write. notes, fields: report and arrays of the reader. remarks: lines for the report.
    written: files so far.
    """

    command: str
    mesh_path: Path
    outputs: Sequence[Path] = ()
    pictures: PictureFiles | None = None
    as_json: bool = False
    quiet: bool = False
    verbose: bool = False
    notes: dict[str, Any] = field(default_factory=dict)
    fields: "Sequence[Field]" = ()
    remarks: list[str] = field(default_factory=list)
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
        *,
        outputs: Sequence[Path],
        no_png: bool,
        extensions: Sequence[str] = (),
        beside: Sequence[tuple[Path | None, Sequence[str]]] = (),
        **settings: Any,
    ) -> "Job":
        """Check, before any computation, that all files can be written.

        Without outputs, they are ``<stem>.<command>`` with the first extension and ``.png`` in the current directory.
        extensions: of outputs, by default those of meshes. beside: other data files, if any, with their extensions.
        settings: of `output_options.DRAWING`, `options.REPORT`.
        """
        name = f"{file_stem(mesh_path)}.{command}"
        drawn = [kind for kind in KINDS if settings[kind]]
        if drawn and no_png:
            raise click.UsageError(f"--{drawn[0]} and --no-png exclude each other.")
        if not (outputs or drawn or no_png):
            settings["png"] = Path(f"{name}.png")
        pictures = PictureFiles.take(settings)
        from geomhw.io import WRITABLE
        from geomhw.io.locks import locked

        extensions = extensions or WRITABLE
        outputs = outputs or [Path(f"{name}{extensions[0]}")]
        require_writable(outputs, extensions)
        pictures.require()
        others = [(path, known) for path, known in beside if path]
        for path, known in others:
            require_writable([path], known)
        further = [*(path for path, _ in others), *pictures.files]
        files = [*outputs, *further]
        require_writable(files, [*extensions, *(path.suffix.lower() for path in further)])
        click.get_current_context().with_resource(locked([path for path in files if path != STANDARD]))
        return cls(command, mesh_path, outputs, pictures, **settings)

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Measure the time of a block, under this name in the report; with ``verbose``, log it."""
        before = self.stages.seconds.get(name, 0.0)
        self.log(f"{name} ...")
        with self.stages(name), restored():
            yield
        self.log(f"{name}: {self.stages.seconds[name] - before:.3f} s")

    def log(self, text: str) -> None:
        """Print a line on stderr, with ``verbose``."""
        if self.verbose:
            click.echo(f"{self.command}: {text}", err=True)

    def read(self) -> "TriangleMesh":
        """Read the mesh; remarks of the reader go to the report."""
        self.log(f"reading {self.mesh_path}")
        with self.stage("read"):
            content = read_input(self.mesh_path)
        self.log(f"{content.mesh.n_vertices} vertices, {content.mesh.n_faces} faces")
        self.notes, self.fields = content.report, content.fields
        if self.pictures:
            self.pictures.stand_as(content)
        return content.mesh

    def read_oriented(self) -> "TriangleMesh":
        """Read the mesh and orient its faces consistently; the number of turned faces goes to the report."""
        from geomhw.mesh.orientation import oriented

        original = self.read()
        mesh = oriented(original)
        if turned := int((mesh.faces != original.faces).any(axis=1).sum()):
            self.notes = {**self.notes, "turned_faces": turned}
        return mesh

    def write(
        self,
        result: Any,
        picture: Callable[..., Any],
        writer: Callable[[Any, Sequence[Path]], None] = write_outputs,
        mesh: "TriangleMesh | None" = None,
        beside: Sequence[tuple[Path | None, Callable[[Path], None]]] = (),
    ) -> None:
        """Write the data files, all or none, then the page and the picture, so that a failure to draw loses no data.

        picture: draws a result, with a ``look``. writer: writes a result to files, by default one on a mesh. mesh: that
        of curves. beside: other data files, if any, each with a function that writes it.
        """
        from geomhw.io import together, writing_remarks
        from geomhw.results import Result

        others = [(path, write) for path, write in beside if path]
        with self.stage("write"), together():
            for path, write in others:
                write(path)
            writer(result, self.outputs)
        if writer is write_outputs:
            self.remarks += [f"note: {remark}" for path in self.outputs for remark in writing_remarks(result, path)]
        self.written += map(str, [*self.outputs, *(path for path, _ in others)])
        if self.pictures and self.pictures.page:
            with self.stage("page"), self.telling_written([str(self.pictures.page)]):
                frame, clouds = (Result(mesh), {"curves": result}) if mesh else (result, self._streamlines(result))
                self.written += self.pictures.write_page([frame], clouds=clouds)
        if self.pictures and self.pictures.paths:
            names = [str(path) for path in self.pictures.paths.values()]
            try:
                with self.stage("render"), self.telling_written(names):
                    with self.pictures.drawn():
                        image = picture(result, look=self.pictures.look)
                    self.pictures.write(image)
            except RenderError as error:
                done = ", ".join(self.written)
                raise RenderError(f"{error} ({done} is written; --no-png leaves the picture out)") from error
            self.written += names

    def _streamlines(self, result: "Result") -> "dict[str, Cloud]":
        """Return the streamlines of the vector fields of a result, if pictures have them."""
        from geomhw.render.flow_lines import streamlines_of

        return streamlines_of(result) if self.pictures and self.pictures.look.draw == "streamlines" else {}

    @contextmanager
    def telling_written(self, pictures: Sequence[str]) -> Iterator[None]:
        """Draw pictures within the block; an interrupt says that other files are written and these are not."""
        try:
            yield
        except KeyboardInterrupt as stop:
            stop.args = (f"{', '.join(self.written)} is written, {', '.join(pictures)} is not",)
            raise

    def finish(self, mesh: "TriangleMesh", answers: Mapping[str, Any], lines: Sequence[str]) -> None:
        """Print the report: mesh, answers, files and times as JSON, or the mesh, these lines and the files."""
        if self.quiet:
            return
        from geomhw.mesh import mesh_summary

        lines = [*lines, *self.remarks, *self._remarks(mesh)]
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
            print_json(report, self.outputs)
        else:
            for line in [f"mesh: {mesh_line(report['mesh'])}", *lines, *(f"wrote: {path}" for path in self.written)]:
                label, text = line.split(": ", 1)
                click.echo(f"{label:<10}{text}", err=STANDARD in self.outputs)

    def _remarks(self, mesh: "TriangleMesh") -> list[str]:
        """Notes and warnings about the mesh."""
        lines = [f"note: {remark}" for remark in self.notes.get("remarks", ())]
        if turned := self.notes.get("turned_faces"):
            lines.append(f"note: {counted(turned, 'face')} turned, also in the output, to orient the mesh consistently")
        if copies := len(mesh.duplicate_faces):
            lines.append(f"warning: {counted(copies, 'copy', 'copies')} of other faces; geomhw info --check lists them")
        return lines


def print_json(report: Mapping[str, Any] | Sequence[Any], outputs: Sequence[Path] = ()) -> None:
    """Print a report as JSON, on stderr if one of the outputs goes to stdout."""
    click.echo(json.dumps(report, indent=2, allow_nan=False), err=STANDARD in outputs)


def time_line(time: Mapping[str, Any], name: str = "time") -> str:
    """The report of a diffusion time in one line, as a multiple of h² first."""
    return f"{name}: t = {time['t_over_h2']:.6g} h² = {time['t']:.6g} ({time['reason']})"


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
