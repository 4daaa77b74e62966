"""Extreme values of every option with a number: no traceback, no warning of a library, exit code 0 or 2, no file left
when a value is refused. Warnings are errors in these tests."""

from collections.abc import Iterator
from pathlib import Path

import click
import numpy as np
import pytest

from geomhw.mesh.primitives import icosphere
from geomhw.results import Field, Result
from geomhw_cli.main import program
from geomhw_cli.specs.arrays import MESH_ARRAY
from geomhw_cli.specs.files import FormatName, InputFile, OutputFile, Spec
from geomhw_cli.specs.looks import ColorMap, Isolines, Limits, ViewName
from geomhw_cli.specs.numbers import Number
from support.program import files, run, save_off

BALL = icosphere(1)
VALUES = ["1e300", "1e-300", "-0.0", "nan", "inf", str(10**21), "7" * 5000, "-1", "1e-320", "-1e300"]
SHORT = {
    "advect": ["--steps", "2", "--every", "1", "-o", "r.pvd", "-q"],
    "fluid": ["--steps", "2", "--every", "1", "-o", "r.pvd", "-q", "--force", "none"],
    "geodesic": ["-o", "r.vtp", "-q"],
    "vecdiffuse": ["-o", "r.vtp", "-q"],
    "helmholtz": ["--field", "f.npy", "-o", "r.vtp", "-q"],
    "compare": ["ball.off", "-q"],
    "repair": ["-o", "r.ply", "-q"],
    "center": ["--points", "0,3", "-o", "r.vtp", "-q"],
    "voronoi": ["--sites", "0,3", "-o", "r.vtp", "-q"],
    "sample": ["--count", "3", "-o", "r.vtp", "-q"],
    "path": ["--from", "0", "--to", "9", "-o", "r.vtp", "-q"],
    "trace": ["--length", "1", "-o", "r.vtp", "-q"],
    "logmap": ["-o", "r.vtp", "-q"],
    "spectrum": ["-k", "4", "-o", "r.vtp", "-q"],
    "killing": ["-k", "3", "-o", "r.vtp", "-q"],
    "design": ["-o", "r.vtp", "-q"],
    "isolines": ["--array", "v.npy", "-o", "r.vtp", "-q"],
    "split": ["--curve", "c.csv", "-o", "r.vtp", "-q"],
    "signed": ["--curve", "c.csv", "-o", "r.vtp", "-q"],
    "smooth": ["--array", "v.npy", "--fwhm", "1", "-o", "r.vtp", "-q"],
    "gradient": ["--array", "v.npy", "-o", "r.vtp", "-q"],
    "extrema": ["--array", "v.npy", "-o", "r.vtp", "-q"],
    "rois": ["--center", "0", "--radius", "1", "-o", "r.vtp", "-q"],
    "streamlines": ["--field", "rigid:x", "-o", "r.vtp", "-q"],
    "bracket": ["--field", "rigid:x", "--field", "rigid:y", "-o", "r.vtp", "-q"],
    "derive": ["--field", "rigid:x", "--along", "rigid:y", "-o", "r.vtp", "-q"],
    "push": ["--field", "rigid:x", "--by", "rigid:y", "--time", "0.1", "--frames", "2", "-o", "r.pvd", "-q"],
}
#: Numbers within texts, by option; # is the place of the number.
SOURCES = ["#", "#-#", "face:#", "face:1:#,0,1", "near:#,0,0", "near:#,#,#", "near:0.1,0.1,#"]
COLORS = ["hue:#,0,1", *(f"blob:{source}" for source in SOURCES)]
FIELDS = ["rotation:#,0,1", "rigid:#,#,1"]
FLOWS = ["random:#", "random:1:#", "rossby-haurwitz:#", "harmonic:#", "vortices:#=1,2=-1", "vortices:1=#,2=-1"]
TEXTS = {
    ("advect", "--field"): FIELDS,
    ("advect", "--color"): COLORS,
    ("fluid", "--init"): FIELDS + FLOWS,
    ("fluid", "--color"): COLORS,
    ("geodesic", "--source"): SOURCES,
    ("vecdiffuse", "--source"): SOURCES,
    ("geodesic", "--to"): SOURCES,
    ("geodesic", "--time"): ["#", "#*h2"],
    ("vecdiffuse", "--dt"): ["#", "#*h2"],
    ("helmholtz", "--field"): [],
    ("center", "--points"): SOURCES,
    ("voronoi", "--sites"): SOURCES,
    ("design", "--align"): [*(f"{source}:1,2,3" for source in SOURCES), "5:#,0,1", "5:#,#,#"],
    ("design", "--singularity"): ["5=#", "#=2", "face:5=#"],
    ("signed", "--time"): ["#", "#*h2"],
    ("streamlines", "--spacing"): ["#", "#.0"],
    ("split", "--pieces"): [],
    ("batch", "command_name"): [],
    ("batch", "meshes"): [],
    ("batch", "--out"): [],
    ("batch", "--shard"): [],
    ("batch", "--scheduler"): [],
    **{(command, "--shard"): ["#/2", "1/#"] for command in ("geodesic", "info", "path", "trace")},
    ("geodesic", "--scheduler"): [],
    ("compare", "--ignore"): [],
    ("view", "--array"): [],
}

#: Types of the options of pictures, and of files of a mesh with an array.
LOOKS = ViewName | Limits | Isolines | ColorMap
MESH_ARRAYS = type(MESH_ARRAY.type)


def numeric_options() -> Iterator[tuple[str, list[str]]]:
    """Yield each command with an option and its values, in which # stands for the number.

    An option that commands share, such as those of pictures, is tried with the first of them.
    """
    tried: list[click.Parameter] = []
    for name, command in program.commands.items():
        for option in command.params:
            if not isinstance(option, click.Option) or any(option is other for other in tried):
                continue
            if name == "batch":  # its only number is that of processes
                continue
            tried.append(option)
            if isinstance(option.type, Number):
                yield name, [option.opts[0], *["#"] * option.nargs]
                if option.nargs > 1:
                    yield name, [option.opts[0], "#", *["0"] * (option.nargs - 1)]
            for text in TEXTS.get((name, option.opts[0]), []):
                yield name, [option.opts[0], text]


@pytest.mark.parametrize("value", VALUES, ids=[value[:8] for value in VALUES])
@pytest.mark.parametrize(
    ("command", "option"), list(numeric_options()), ids=lambda part: part if isinstance(part, str) else "=".join(part)
)
def test_extreme_value(command: str, option: list[str], value: str, folder: Path) -> None:
    """The value is used, or refused in one short sentence with exit code 2, before anything is written."""
    save_off(BALL)
    np.save("f.npy", BALL.face_centers)
    np.save("v.npy", BALL.vertices[:, 2])
    corners = BALL.vertices[BALL.faces[0, [0, 1, 2, 0]]]
    np.savetxt("c.csv", corners, delimiter=",", header="x,y,z", comments="")
    before = files(folder)
    words = [part.replace("#", value) for part in option]
    answer = run(command, "ball.off", *SHORT.get(command, []), *words)
    assert answer.exit_code in (0, 2), answer.output
    if answer.exit_code:
        assert files(folder) == before
        assert answer.stdout == ""
        assert len(answer.stderr) < 2000
        assert answer.stderr.strip().splitlines()[-1].startswith("Error: ")


@pytest.mark.parametrize("command", list(program.commands))
def test_every_option_is_known(command: str) -> None:
    """Each option has one of the program's own types: a number in a range, a file to read or to write, a text whose
    files count as inputs, a choice, a flag; other texts are listed above."""
    for parameter in program.commands[command].params:
        own = isinstance(
            parameter.type,
            Number
            | InputFile
            | OutputFile
            | FormatName
            | Spec
            | click.Choice
            | click.types.BoolParamType
            | LOOKS
            | MESH_ARRAYS,
        )
        known = own or (command, parameter.opts[0]) in TEXTS
        assert known, f"{command} {parameter.opts[0]} has the type {parameter.type}"


@pytest.mark.parametrize(
    "arguments",
    [
        ["fluid", "--until", "1", "--dt", "1e-17"],
        ["fluid", "--until", "1", "--cfl", "1e-17", "--force", "none"],
        ["fluid", "--dt", "1e50"],
        ["fluid", "--cfl", "1e20", "--force", "none"],
        ["fluid", "--init", "vortices:1=1e21,2=-1e21"],
        ["fluid", "--dt", "0.5", "--scheme", "rk4"],
        ["advect", "--dt", "1e50"],
        ["geodesic", "--time", "1e12"],
        ["geodesic", "--time", "1e-200", "--robust"],
        ["vecdiffuse", "--dt", "1e-200*h2"],
        ["geodesic", "--source", "near:1e9,0,0"],
    ],
)
def test_impossible_here(arguments: list[str], folder: Path) -> None:
    """A value that is impossible on this mesh leaves no file, also if only the first step finds out."""
    save_off(BALL)
    answer = run(arguments[0], "ball.off", *arguments[1:])
    assert answer.exit_code == (1 if "rk4" in arguments else 2)
    assert len(answer.stderr.strip().splitlines()) == 1
    assert files(folder) == ["ball.off"]


def test_distance_of_near(folder: Path) -> None:
    """``near:`` prints its distance from the surface, and warns beyond a tenth of the diagonal."""
    save_off(BALL)
    answer = run("geodesic", "ball.off", "--source", "near:0,0,1.1", "--source", "near:0,0,-3", "-o", "r.vtp")
    lines = answer.stdout.splitlines()
    (note,) = [line for line in lines if "near:0,0,1.1" in line]
    (warning,) = [line for line in lines if "near:0,0,-3" in line]
    assert note.startswith("note")
    assert warning.startswith("warning")
    height = -(BALL.vertices[:, 2].min())
    assert float(warning.split(" is ")[1].split()[0]) == pytest.approx(3 - height, abs=0.1)
    answer = run("advect", "ball.off", "--color", "blob:near:0,0,9", "--steps", "1", "-o", "r.pvd")
    assert "warning   near:0,0,9" in answer.stdout


@pytest.mark.parametrize(
    "arguments",
    [
        ["advect", "--color", "blob:@pts.csv", "--csv", "pts.csv"],
        ["fluid", "--color", "blob:@pts.csv", "--csv", "pts.csv"],
        ["advect", "--color", "blob:pts.csv:x=3", "--csv", "pts.csv"],
        ["fluid", "--restart", "pts.csv", "--csv", "pts.csv"],
        ["advect", "--color", "blob:@pts.00000.vtp", "-o", "pts.pvd"],
        ["geodesic", "--source", "@pts.vtp", "-o", "pts.vtp"],
        ["vecdiffuse", "--source", "@pts.vtp", "-o", "pts.vtp"],
        ["helmholtz", "--field", "pts.vtp:wind", "-o", "pts.vtp"],
        ["geodesic", "--pairs", "pts.csv", "-o", "pts.csv"],
        ["geodesic", "--pairs", "pts.partial.npy", "-o", "pts.npy"],
        ["geodesic", "--sources", "pts.partial.json", "-o", "pts.npy"],
    ],
)
def test_no_input_is_overwritten(arguments: list[str], folder: Path) -> None:
    """Files that specs name are inputs, which no output replaces."""
    from geomhw.io import write

    save_off(BALL)
    for part in arguments:
        if "pts" in part:
            Path(part.split("@")[-1].split(":wind")[0]).write_text("3\n" if "pairs" not in str(arguments) else "3,4\n")
    if "helmholtz" in arguments:
        write(Result(BALL, [Field("wind", "face", BALL.face_centers)]), "pts.vtp")
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    answer = run(arguments[0], "ball.off", *arguments[1:])
    assert answer.exit_code == 1
    assert "input" in answer.stderr or "no state" in answer.stderr  # not a checkpoint at all
    assert {name: Path(name).read_bytes() for name in before if Path(name).exists()} == before
