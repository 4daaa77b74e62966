"""Output of a time-dependent command: frames of a series, a table, films and a contact sheet."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from geomhw.background import ahead
from geomhw.errors import RenderError
from geomhw_cli.runtime.background_writer import BackgroundWriter
from geomhw_cli.runtime.interrupts import restored
from geomhw_cli.runtime.job import Job
from geomhw_cli.runtime.picture_kinds import FILMS, KINDS
from geomhw_cli.runtime.pictures import PictureFiles
from geomhw_cli.specs.files import file_stem, inputs, require_writable

if TYPE_CHECKING:
    from geomhw.io import SeriesWriter
    from geomhw.results import Cloud, Result

#: Removed files that the report lists, at most.
MAX_REMOVED = 8


@dataclass
class FrameWriter:
    """Writes frames during the computation and, at the end, films of them.

    extras: paths of the table and the films, by kind. rows: of the table, one per frame.
    background: the thread that writes frames. can_restart: whether this run has written a checkpoint.
    """

    job: Job
    series: "SeriesWriter"
    extras: dict[str, Path]
    fps: float
    rows: list[dict[str, float]] = field(default_factory=list)
    background: BackgroundWriter = field(default_factory=BackgroundWriter)
    can_restart: bool = False

    @classmethod
    def plan(
        cls,
        command: str,
        mesh_path: Path,
        report: Mapping[str, Any],
        *,
        output: Path | None,
        fps: float,
        no_png: bool,
        restart: Path | None = None,
        **settings: Any,
    ) -> "FrameWriter":
        """Check, before any computation, that all files can be written.

        output: of the series; by default frames are in the folder ``<stem>.<command>/``, with a contact sheet and a
        film beside it. restart: the checkpoint that the run goes on from, which may be that of the series. settings:
        files by kind, and values of `output_options.DRAWING`.
        """
        name = f"{file_stem(mesh_path)}.{command}"
        drawn = [kind for kind in (*KINDS, *FILMS) if settings[kind]]
        if no_png and drawn:
            raise click.UsageError(f"--{drawn[0]} and --no-png exclude each other.")
        default = Path(name, f"{name}.pvd")
        if output in (None, default) and not (drawn or no_png):
            settings["png"], settings["gif"] = Path(f"{name}.png"), Path(f"{name}.gif")
        pictures = PictureFiles.take(settings)
        from geomhw.errors import FormatError
        from geomhw.io import SeriesWriter, require_mp4
        from geomhw.io.locks import locked
        from geomhw.render.offscreen import prepare

        output = output or _in_folder(default)
        require_writable([output], [".pvd"])
        pictures.require()
        wanted = {kind: path for kind, path in settings.items() if path}
        for kind, path in wanted.items():
            require_writable([path], [f".{kind}"])
        files = [*wanted.values(), *pictures.files]
        require_writable([output, *files], [".pvd", *(path.suffix.lower() for path in files)])
        series = SeriesWriter(output)
        kept = [path for path in inputs() if path != restart or not _is_same(path, series.state)]
        if lost := next(filter(series.writes, kept), None):
            raise FormatError(f"cannot write {output}: one of its files is the input {lost}, which would be lost")
        click.get_current_context().with_resource(locked([output, *files]))
        if "mp4" in wanted:
            require_mp4()
        if drawn:
            prepare()
        return cls(Job(command, mesh_path, pictures=pictures, **report), series, wanted, fps)

    @property
    def pictures(self) -> PictureFiles:
        """The contact sheet, and the look of the films."""
        assert self.job.pictures
        return self.job.pictures

    @property
    def checkpoint(self) -> Path:
        """The file with the state to restart from."""
        return self.series.state

    @contextmanager
    def running(self) -> Iterator[None]:
        """Write in the background within the block, then remove the other files of an earlier run of the same name.

        An interrupt says how far the series is valid.
        """
        try:
            with self.background, restored():
                yield
        except KeyboardInterrupt as stop:
            if self.rows:
                valid = f"{self.series.path} is valid up to step {self.rows[-1]['step']}"
                stop.args = (f"{valid}, go on with --restart {self.checkpoint}" if self.can_restart else valid,)
            raise
        finally:
            if self.rows and (removed := self.series.remove_former()):
                shown = ", ".join(removed[:MAX_REMOVED]) + (", ..." if len(removed) > MAX_REMOVED else "")
                self.job.remarks.append(f"note: {len(removed)} files of an earlier run are removed: {shown}")

    def add(
        self,
        time: float,
        result: "Result",
        row: dict[str, float],
        tracers: "Cloud | None" = None,
        then: Callable[[], None] | None = None,
    ) -> None:
        """Hand over a frame and its row, to be written in the background, and a call to make after that."""

        def task() -> None:
            self.series.add(time, result, tracers)
            self.rows.append(row)
            self._write_table()
            if then:
                then()
                self.can_restart = True

        self.background(task)

    def _write_table(self) -> None:
        from geomhw.io import write_csv

        if csv := self.extras.get("csv"):
            write_csv(csv, self.rows)

    def finish(self) -> None:
        """Draw films and contact sheet of all frames of the series, read back from their files: all, or none."""
        from geomhw.io import together

        written = [self.series.path, self.series.index]
        if any(frame.tracers for frame in self.series.frames):
            written.append(self.series.tracer_index)
        if self.checkpoint.exists():
            written.append(self.checkpoint)
        self._write_table()  # again: a restarted run may have no frame left to add
        if csv := self.extras.get("csv"):
            written.append(csv)
        self.job.written += map(str, written)
        films = [path for kind, path in self.extras.items() if kind in FILMS]
        pictures = [str(path) for path in [*self.pictures.files, *films]]
        if pictures:
            try:
                with self.job.telling_written(pictures), together():
                    self._draw()
            except RenderError as error:
                where = ", ".join(map(str, written))
                raise RenderError(f"{error} ({where} is written; --no-png leaves the pictures out)") from error
            self.job.written += pictures

    def _draw(self) -> None:
        """Draw the films and the contact sheet; all are written, or none."""
        from geomhw.io import read_frames, write_gif, write_mp4
        from geomhw.render.flow_pictures import contact_sheet, flow_film

        frames = self.series.frames
        results, clouds = read_frames(self.series.path, frames)
        look, gif, mp4 = self.pictures.look, self.extras.get("gif"), self.extras.get("mp4")
        with self.job.stage("render"):
            moving = {"tracers": clouds} if len(clouds) == len(results) else {}
            self.pictures.write_page(results, [frame.time for frame in frames], clouds=moving)
            if not (gif or mp4 or self.pictures.paths):
                return
            with self.pictures.drawn():
                if gif or mp4:
                    film = ahead(flow_film(results, clouds, replace(look, transparent=False)))
                    images = list(film) if gif and mp4 else film
                    if gif:
                        write_gif(gif, images, self.fps)
                    if mp4:
                        write_mp4(mp4, images, self.fps)
                if self.pictures.paths:
                    self.pictures.write(contact_sheet(results, clouds, look))


def _in_folder(path: Path) -> Path:
    """Make the folder of a file, which is removed if it is empty at the end of the command, and return the path."""
    from geomhw.errors import FormatError

    try:
        path.parent.mkdir()
    except OSError as error:
        if not path.parent.is_dir():
            raise FormatError(f"cannot write {path}: {path.parent} is no folder and cannot be made one") from error
        return path
    click.get_current_context().call_on_close(partial(_remove_empty, path.parent))
    return path


def _remove_empty(folder: Path) -> None:
    with suppress(OSError):
        folder.rmdir()


def _is_same(one: Path, other: Path) -> bool:
    return other.exists() and one.exists() and one.samefile(other)
