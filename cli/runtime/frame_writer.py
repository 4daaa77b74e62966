"""What the commands with time write: a series of frames, a table, films and a contact sheet."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from geomhw_cli import options
from geomhw_cli.runtime.background_writer import BackgroundWriter
from geomhw_cli.runtime.job import Job

if TYPE_CHECKING:
    from geomhw.io import SeriesWriter
    from geomhw.results import Cloud, Result

#: Pictures on a contact sheet, at most.
MOST_ON_SHEET = 12
#: Tracers, at most.
MOST_TRACERS = 10_000_000
#: What is drawn of the frames.
PICTURES = {"gif", "mp4", "png"}


def frame_options(command: Callable[..., None]) -> Callable[..., None]:
    """The output options that the commands with time share."""
    for option in (
        click.option(
            "-o",
            "--output",
            metavar="OUT.pvd",
            type=options.FILE,
            help="Time series; its .vtp frames and a .vtp.series index go beside it.  [default: <stem>.<command>.pvd]",
        ),
        click.option("--gif", metavar="FILE", type=options.FILE, help="Film of the frames as a GIF."),
        click.option(
            "--mp4", metavar="FILE", type=options.FILE, help="Film of the frames as MP4; needs imageio-ffmpeg."
        ),
        click.option("--png", metavar="FILE", type=options.FILE, help="Contact sheet of up to twelve frames."),
        options.width_option,
        click.option("--csv", metavar="FILE", type=options.FILE, help="Table with a line a frame."),
        click.option(
            "--tracers",
            metavar="N",
            type=click.IntRange(1, MOST_TRACERS),
            help="Particles carried along: points of <OUT>.tracers.*.vtp, in the series as part 1, streaks in films.",
        ),
    ):
        command = option(command)
    return command


@dataclass
class FrameWriter:
    """Writes frames as they come and, at the end, the films of them.

    background: the thread that writes frames; it ends with the last one. rows: the lines of the table, one a frame that
    is written.
    """

    job: Job
    series: "SeriesWriter"
    films: Mapping[str, Path]
    rows: list[dict[str, float]] = field(default_factory=list)
    background: BackgroundWriter = field(default_factory=BackgroundWriter)

    @classmethod
    def plan(
        cls,
        job: Job,
        output: Path | None,
        gif: Path | None,
        mp4: Path | None,
        png: Path | None,
        csv: Path | None,
        inputs: Sequence[Path] = (),
    ) -> "FrameWriter":
        """Check all names, and that films can be made here, before any work is done."""
        from geomhw.errors import FormatError
        from geomhw.io import SeriesWriter, check_outputs, require_mp4
        from geomhw.render.offscreen import prepare

        output = output or Path(f"{job.mesh_path.stem}.{job.command}.pvd")
        taken = [job.mesh_path, *inputs]
        check_outputs([output], taken, extensions=[".pvd"])
        films = {kind: path for kind, path in {"gif": gif, "mp4": mp4, "png": png, "csv": csv}.items() if path}
        for kind, path in films.items():
            check_outputs([path], taken, extensions=[f".{kind}"])
        check_outputs([output, *films.values()], taken, extensions=[".pvd", *(f".{kind}" for kind in films)])
        series = SeriesWriter(output)
        if lost := next((path for path in taken if series.writes(path)), None):
            raise FormatError(f"cannot write {output}: a frame or index of it would be the input {lost}, and lost")
        if mp4:
            require_mp4()
        if films.keys() & PICTURES:
            prepare()
        return cls(job, series, films)

    @property
    def checkpoint(self) -> Path:
        """Where the state to restart from is kept."""
        return self.series.state

    def add(
        self,
        time: float,
        result: "Result",
        row: dict[str, float],
        tracers: "Cloud | None" = None,
        then: Callable[[], None] | None = None,
    ) -> None:
        """Hand over a frame, to be written with the table up to it, and what is to be done with that."""

        def piece() -> None:
            self.series.add(time, result, tracers)
            self.rows.append(row)
            self._write_table()
            if then:
                then()

        self.background(piece)

    def _write_table(self) -> None:
        from geomhw.io import write_csv

        if csv := self.films.get("csv"):
            write_csv(csv, self.rows)

    def finish(
        self, picture: "Callable[[list[Result], list[Cloud]], Iterator[Any]]", sheet: Callable[..., Any]
    ) -> None:
        """Films and contact sheet of all frames of the series, read back from their files.

        picture: from results, and their tracers if there are any, to a picture each, all of one size. sheet: from
        pictures to one with all of them.
        """
        from geomhw.io import read, read_cloud, write_gif, write_mp4, write_png

        frames, folder = self.series.frames, self.series.path.parent
        self.job.written += [str(self.series.path), str(self.series.index)]
        if any(frame.tracers for frame in frames):
            self.job.written.append(str(self.series.tracer_index))
        if self.checkpoint.exists():
            self.job.written.append(str(self.checkpoint))
        self._write_table()  # again: a restart may have had nothing left to add
        if csv := self.films.get("csv"):
            self.job.written.append(str(csv))
        if not self.films.keys() & PICTURES:
            return
        results = [read(folder / frame.file) for frame in frames]
        clouds = [read_cloud(folder / frame.tracers) for frame in frames if frame.tracers]
        with self.job.stage("render"):
            images = list(picture(results, clouds))
            if gif := self.films.get("gif"):
                write_gif(gif, images)
            if mp4 := self.films.get("mp4"):
                write_mp4(mp4, images)
            if png := self.films.get("png"):
                count = min(MOST_ON_SHEET, len(images))
                chosen = [round(k * (len(images) - 1) / max(count - 1, 1)) for k in range(count)]
                write_png(png, sheet([images[k] for k in chosen]))
        self.job.written += [str(self.films[kind]) for kind in ("gif", "mp4", "png") if kind in self.films]
