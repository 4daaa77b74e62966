"""Options for the files that commands write, in groups that `Job.plan` and `FrameWriter.plan` take."""

import click

from geomhw.options import FRAMES_PER_SECOND, PANEL_WIDTH, DrawName, UpAxis
from geomhw_cli.options import OUTPUT, Choice, OptionGroup, choice, flag, option
from geomhw_cli.specs.files import FormatName, set_format
from geomhw_cli.specs.looks import ColorMap, Isolines, Limits, ViewName
from geomhw_cli.specs.numbers import Number

#: Formats of a mesh with arrays, as help texts give them.
MESH_FORMATS = ".vtk, .vtp, .vtu, .ply, .glb, .gii (.func.gii, .label.gii) or .csv"
OUTPUT_FORMAT = option(
    "--output-format",
    "FORMAT",
    FormatName(),
    "Format of -o - (standard output): vtk, vtp, vtu, ply, glb, gii or csv. The report goes to stderr.  "
    "[default: that of --format]",
    expose_value=False,
    callback=set_format,
)
#: Options of every command that draws, which `PictureFiles.take` takes out of a group's values.
DRAWING = (
    option("--svg", "FILE", OUTPUT, "The picture as SVG, with texts and color bars as vectors."),
    option("--pdf", "FILE", OUTPUT, "The picture as PDF, with texts and color bars as vectors."),
    option("--html", "FILE", OUTPUT, "Page for the browser, to turn and read, as of geomhw view."),
    option("--view", "VIEW", ViewName(), "front, back, left, right, top, bottom or AZIMUTH,ELEVATION in degrees."),
    option(
        "--up",
        "x|y|z",
        Choice(UpAxis),
        "Axis that points up in pictures.  [default: that of the file's format, or guessed]",
    ),
    option("--zoom", "F", Number(0.01, 100), "Magnification of the mesh in its panel.", default=1.0),
    option(
        "--width",
        "PX",
        Number(120, 4000, whole=True),
        "Width of each panel of a picture, in pixels. Text and lines scale with it.",
        default=PANEL_WIDTH,
    ),
    option("--dpi", "N", Number(10, 2400), "Pixels per inch, which set the size on paper."),
    option("--colormap", "NAME", ColorMap(), "Color map of the main quantity: a name of matplotlib."),
    option("--range limits", "LO,HI", Limits(), "Values at the ends of the color bar of the main quantity."),
    option("--isolines", "D|N|none", Isolines(), "Isolines: their number such as 12, or spacing such as 0.5 or 5.0."),
    flag("--transparent", "Make the background transparent."),
)
#: The option of commands that draw vectors.
DRAW = choice(
    "--draw",
    DrawName,
    "How pictures draw vectors: arrows; streamlines, evenly spaced, wider where vectors are long; or lic, a texture of "
    "short streaks along them (line integral convolution).",
)


def _files(what: str, *further: click.Option) -> OptionGroup:
    """The files of a command with one result, as `Job.plan` takes them. what: the data that -o names."""
    output = option("-o --output outputs", "FILE", OUTPUT, f"{what} May be repeated.", multiple=True)
    pictures = option("--png", "FILE", OUTPUT, "Picture."), flag("--no-png", "Draw no picture.")
    return OptionGroup("Output", output, *further, *pictures, *DRAWING, name="files")


#: Files of a command that computes one field, vectors, curves on the mesh, or points on the mesh.
FIELD_FILES = _files(f"Mesh with the computed arrays: {MESH_FORMATS}.", OUTPUT_FORMAT)
VECTOR_FILES = OptionGroup("Output", *FIELD_FILES.options, DRAW, name="files")
CURVE_FILES = _files("Curves as polylines, .vtp, or as a table with a row per point, .csv.")
POINT_FILES = _files("Points, .vtp, or as a table with a row per point, .csv.")
#: Files of a command that computes a time series, as `FrameWriter.plan` takes them.
SERIES_FILES = OptionGroup(
    "Output",
    option(
        "-o --output",
        "OUT.pvd",
        OUTPUT,
        "Time series, with its .vtp frames and a .vtp.series index beside it.  [default: in <stem>.<command>/]",
    ),
    option("--csv", "FILE", OUTPUT, "Table with one line per frame."),
    option("--gif", "FILE", OUTPUT, "Film of the frames as GIF."),
    option("--mp4", "FILE", OUTPUT, "Film of the frames as MP4. Needs imageio-ffmpeg."),
    option("--fps", "N", Number(1, 50), "Frames of a film per second.", default=FRAMES_PER_SECOND),
    option("--png", "FILE", OUTPUT, "Contact sheet of at most twelve frames."),
    flag("--no-png", "Draw no contact sheet and no film."),
    *DRAWING,
    DRAW,
    name="files",
)
