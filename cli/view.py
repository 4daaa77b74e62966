"""``geomhw view``: results in a window, or in a page for the browser."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from geomhw_cli.options import INPUT, OUTPUT, REPORT, OptionGroup, command, option
from geomhw_cli.runtime.job import print_json
from geomhw_cli.runtime.pictures import PAGES, write_page
from geomhw_cli.specs.files import add_input, file_stem, read_input, require_writable

if TYPE_CHECKING:
    from geomhw.results import Cloud, Result


@command(
    OptionGroup(
        "Picture",
        option("--array", "NAME", str, "Array that is shown first.  [default: the first of the file]"),
        option(
            "--with clouds",
            "FILE",
            INPUT,
            "Points or polylines of a .vtp file, such as those of geomhw path. May be repeated.",
            multiple=True,
        ),
    ),
    OptionGroup("Output", option("-o --output", "PAGE.html", OUTPUT, "Page for the browser. Without it, a window.")),
    REPORT,
)
def view(
    mesh_path: Path, array: str | None, clouds: tuple[Path, ...], output: Path | None, report: dict[str, Any]
) -> None:
    """Show the arrays of MESH, or of a time series (.pvd), to turn, zoom and read.

    The page is one HTML file, which needs no network: drag to turn, wheel to zoom, shift and drag to move, click to
    read the values at a vertex. Menus choose array and colors, a slider the time. Its address takes choices, as in
    page.html#array=distance&isolines=12&vertex=7.

    \b
    Examples:
      geomhw geodesic data/creature.obj -o creature.vtp
      geomhw view creature.vtp --array distance -o creature.html
      geomhw advect data/torus.off --steps 20 --every 2 -o torus.pvd
      geomhw view torus.pvd -o torus.html
      geomhw path data/torus.off --from 0 --to 150 --no-png -o path.vtp
      geomhw view data/torus.off --with path.vtp -o path.html
    """
    from geomhw.errors import FieldError
    from geomhw.io import read_cloud
    from geomhw.io.reading import upward_axis
    from geomhw.render.look import Look

    if output:
        require_writable([output], PAGES)
    times, frames, tracers = _read(mesh_path)
    names = [field.name for field in frames[0].fields if field.location != "mesh"]
    if array and array not in names:
        raise FieldError(f"{mesh_path} has no array '{array}'" + (f"; there are {', '.join(names)}" if names else ""))
    marks: dict[str, Any] = {path.stem: read_cloud(path) for path in clouds}
    if tracers:
        marks["tracers"] = tracers
    if not output:
        from geomhw.render import show_window

        show_window(frames[-1], array, {name: mark[-1] if mark is tracers else mark for name, mark in marks.items()})
        return
    look = Look(file_up=upward_axis(frames[0]))
    write_page(output, frames, times, title=file_stem(mesh_path), active=array or "", clouds=marks, look=look)
    if report["as_json"] and not report["quiet"]:
        print_json({"command": "view", "file": str(mesh_path), "frames": len(frames), "files": [str(output)]})
    elif not report["quiet"]:
        click.echo(f"wrote     {output}")


def _read(path: Path) -> tuple[list[float], list["Result"], list["Cloud"]]:
    """Times, frames and tracers of a series, or one frame at time 0."""
    from geomhw.io import read_frames, read_series

    if path.suffix.lower() != ".pvd":
        return [0.0], [read_input(path)], []
    series = read_series(path)
    files = [path.parent / name for frame in series for name in (frame.file, frame.tracers) if name]
    for file in files:
        add_input(file)
    frames, tracers = read_frames(path, series)
    return [frame.time for frame in series], frames, tracers if len(tracers) == len(series) else []
