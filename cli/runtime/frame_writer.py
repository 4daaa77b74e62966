"""Output of a time-dependent command: frames of a series, a table, films and a contact sheet."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from geomhw_cli.runtime.background_writer import BackgroundWriter
from geomhw_cli.runtime.interrupts import restored, whole
from geomhw_cli.runtime.job import Job
from geomhw_cli.runtime.memory import DRAWING, require_memory
from geomhw_cli.specs.files import file_stem, inputs, require_writable

if TYPE_CHECKING:
    from geomhw.io import SeriesWriter
    from geomhw.results import Cloud, Result

#: Pictures on a contact sheet, at most.
MAX_ON_SHEET = 12
#: Removed files that the report lists, at most.
MAX_REMOVED = 8
#: Kinds of files that show pictures of the frames.
PICTURES = {"gif", "mp4", "png"}


@dataclass
class FrameWriter:
    """Writes frames during the computation and, at the end, films of them.

    extras: paths of the table and the films, by kind. rows: of the table, one per frame. background: the thread that
    writes frames. can_restart: whether this run has written a checkpoint.
    """

    job: Job
    series: "SeriesWriter"
    extras: dict[str, Path]
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
        width: int,
        restart: Path | None = None,
        **extras: Path | None,
    ) -> "FrameWriter":
        """Check, before any computation, that all files can be written.

        output: of the series, by default ``<stem>.<command>.pvd``. restart: the checkpoint that the run goes on from,
        which may be that of the series.
        """
        from geomhw.errors import FormatError
        from geomhw.io import SeriesWriter, require_mp4
        from geomhw.io.locks import locked
        from geomhw.render.offscreen import prepare

        output = output or Path(f"{file_stem(mesh_path)}.{command}.pvd")
        require_writable([output], [".pvd"])
        wanted = {kind: path for kind, path in extras.items() if path}
        for kind, path in wanted.items():
            require_writable([path], [f".{kind}"])
        require_writable([output, *wanted.values()], [".pvd", *(f".{kind}" for kind in wanted)])
        series = SeriesWriter(output)
        kept = [path for path in inputs() if path != restart or not _is_same(path, series.state)]
        if lost := next(filter(series.writes, kept), None):
            raise FormatError(f"cannot write {output}: one of its files is the input {lost}, which would be lost")
        click.get_current_context().with_resource(locked([output, *wanted.values()]))
        if "mp4" in wanted:
            require_mp4()
        if wanted.keys() & PICTURES:
            require_memory(DRAWING, "drawing")
            prepare()
        return cls(Job(command, mesh_path, width=width, **report), series, wanted)

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
        """Draw films and contact sheet of all frames of the series, read back from their files."""
        written = [self.series.path, self.series.index]
        if any(frame.tracers for frame in self.series.frames):
            written.append(self.series.tracer_index)
        if self.checkpoint.exists():
            written.append(self.checkpoint)
        self._write_table()  # again: a restarted run may have no frame left to add
        if csv := self.extras.get("csv"):
            written.append(csv)
        self.job.written += map(str, written)
        pictures = [str(path) for kind, path in self.extras.items() if kind in PICTURES]
        if pictures:
            with self.job.telling_written(pictures):
                self._draw()
            self.job.written += pictures

    def _draw(self) -> None:
        """Draw the films and the contact sheet."""
        from geomhw.io import read, read_cloud, write_gif, write_mp4, write_png
        from geomhw.render.flow_pictures import contact_sheet, flow_film

        frames, folder = self.series.frames, self.series.path.parent
        results = [read(folder / frame.file) for frame in frames]
        clouds = [read_cloud(folder / frame.tracers) for frame in frames if frame.tracers]
        with self.job.stage("render"):
            images = list(whole(flow_film(results, clouds, width=self.job.width)))
            if gif := self.extras.get("gif"):
                write_gif(gif, images)
            if mp4 := self.extras.get("mp4"):
                write_mp4(mp4, images)
            if png := self.extras.get("png"):
                count = min(MAX_ON_SHEET, len(images))
                chosen = [round(k * (len(images) - 1) / max(count - 1, 1)) for k in range(count)]
                write_png(png, contact_sheet([images[k] for k in chosen]))


def _is_same(one: Path, other: Path) -> bool:
    return other.exists() and one.exists() and one.samefile(other)
