"""``--tracers`` of ``geomhw advect`` and ``geomhw fluid``: files, indices, restarts, films, refusals."""

import json
import signal
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image
from test_commands import run, save_off
from test_commands_flow import (
    BALL,
    FILM,
    SHORT,
    both,
    contents,
    files,
    one_line,
    spoiled_inputs,
)
from test_render import needs_opengl

from geomhw.io import read, read_cloud, read_series, write
from geomhw.io.artifacts import series as series_module
from geomhw.results import Cloud

TRACED = ("--tracers", "44")


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Each test works in a folder of its own, with a small sphere in it."""
    monkeypatch.chdir(tmp_path)
    save_off(BALL)
    return tmp_path


def clouds(path: str | Path) -> list[Cloud]:
    """Tracers of a series, after a look at its indices: part 1 of the times of the frames, in files beside them."""
    path = Path(path)
    entries = [item.attrib for item in ElementTree.parse(path).iter("DataSet")]
    frames, tracers = ([item for item in entries if item["part"] == part] for part in ("0", "1"))
    assert [item["timestep"] for item in tracers] == [item["timestep"] for item in frames]
    index = json.loads(path.with_suffix(".tracers.vtp.series").read_text())
    assert [(f["name"], f["time"]) for f in index["files"]] == [(t["file"], float(t["timestep"])) for t in tracers]
    assert [item["file"] for item in tracers] == [f"{path.stem}.tracers.{k:05d}.vtp" for k in range(len(tracers))]
    return [read_cloud(path.parent / item["file"]) for item in tracers]


# -- what is written ---------------------------------------------------------------------------------------------


@both
def test_in_the_series(command: str) -> None:
    """A cloud a frame, at its time, with the velocity and color of the frame; the mesh's frames are as without them."""
    assert run(command, "ball.off", *SHORT, *TRACED, "-o", "flow.pvd", "-q").exit_code == 0
    run(command, "ball.off", *SHORT, "-o", "plain.pvd", "-q")
    found = clouds("flow.pvd")
    assert len(found) == 4
    for k, cloud in enumerate(found):
        frame, twin = Path(f"flow.{k:05d}.vtp"), Path(f"plain.{k:05d}.vtp")
        assert frame.read_bytes() == twin.read_bytes()
        result, face = read(frame), cloud["face"]
        assert cloud["time"] == result["time"]
        assert cloud.points.shape == cloud["velocity"].shape == cloud["color"].shape == (44, 3)
        np.testing.assert_array_equal(cloud["velocity"], result["velocity"][face])
        above = (cloud.points - BALL.vertices[BALL.faces[face, 0]]) * BALL.face_normals[face]
        np.testing.assert_allclose(above.sum(axis=1), 0, atol=1e-14)
    frames = read_series("flow.pvd")
    assert [frame.file for frame in frames] == [f"flow.{k:05d}.vtp" for k in range(4)]
    assert [frame.tracers for frame in frames] == [f"flow.tracers.{k:05d}.vtp" for k in range(4)]


@both
def test_downstream(command: str) -> None:
    """In a rotation about z at one radian a unit of time tracers turn so, towards +y from +x."""
    option, free = {"advect": ("--field", []), "fluid": ("--init", ["--force", "none"])}[command]
    pace = ("--dt", "0.05", "--steps", "10", "--every", "10", "-q")
    run(command, "ball.off", option, "rigid:z", *free, *pace, *TRACED, "-o", "flow.pvd")
    first, last = (cloud.points[:, 0] + 1j * cloud.points[:, 1] for cloud in clouds("flow.pvd"))
    assert np.median(np.angle(last / first)) == pytest.approx(0.5, rel=0.1)


@both
def test_report(command: str) -> None:
    """Their number, and the index of their files; null, and no such file, where there are none."""
    report = json.loads(run(command, "ball.off", *SHORT, *TRACED, "--json").stdout)
    assert report["tracers"] == 44
    assert f"ball.{command}.tracers.vtp.series" in report["files"]
    assert all(Path(name).is_file() for name in report["files"])
    assert json.loads(run(command, "ball.off", *SHORT, "-o", "plain.pvd", "--json").stdout)["tracers"] is None
    assert not Path("plain.tracers.vtp.series").exists()


def test_readable_by_vtk() -> None:
    """VTK's own reader takes them as points with a vertex each."""
    from vtkmodules.vtkIOXML import vtkXMLPolyDataReader

    run("fluid", "ball.off", *SHORT, *TRACED, "-q")
    reader = vtkXMLPolyDataReader()
    reader.SetFileName("ball.fluid.tracers.00002.vtp")
    reader.Update()
    data = reader.GetOutput()
    assert (data.GetNumberOfPoints(), data.GetNumberOfVerts(), data.GetNumberOfPolys()) == (44, 44, 0)
    assert data.GetPointData().GetArray("velocity").GetNumberOfComponents() == 3


@needs_opengl
@both
def test_film(command: str) -> None:
    """Streaks in the picture, white where no color of the dye is."""
    white = []
    for name, options in (("with", ("--tracers", "300")), ("without", ())):
        pictures = ("-o", f"{name}.pvd", "--png", f"{name}.png", "-q")
        assert run(command, "ball.off", *FILM, *options, *pictures).exit_code == 0
        with Image.open(f"{name}.png") as sheet:
            body = np.asarray(sheet.convert("RGB"))[100:240, 80:220].astype(int)  # within the first sphere
        white.append(int((body.min(axis=2) > 200).sum()))
    assert white[0] > white[1] + 20


# -- interrupt and restart ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("options", [[], ["--scheme", "handout"]])
@pytest.mark.parametrize("pace", [["--dt", "0.01"], ["--cfl", "0.3", "--force", "none"]])
def test_a_run_in_two_parts(options: list[str], pace: list[str], folder: Path) -> None:
    """On from a last frame out of turn to the bytes of a single run, those of the tracers too."""
    for name in ("parts", "whole"):
        (folder / name).mkdir()
    same = (*options, *pace, *TRACED, "--every", "3", "-q")
    run("fluid", "ball.off", *same, "--steps", "7", "-o", "parts/flow.pvd")
    on = ("--restart", "parts/flow.restart.npz", "-o", "parts/flow.pvd")
    assert run("fluid", "ball.off", *same, "--steps", "11", *on).exit_code == 0
    run("fluid", "ball.off", *same, "--steps", "11", "-o", "whole/flow.pvd")
    assert len(clouds("parts/flow.pvd")) == 5
    assert contents(folder / "parts") == contents(folder / "whole")


@pytest.mark.parametrize(("first", "then"), [([], TRACED), (TRACED, []), (TRACED, ["--tracers", "45"])])
def test_restart_with_other_tracers(first: list[str], then: list[str], folder: Path) -> None:
    """Neither with, without, nor with more of them than before."""
    run("fluid", "ball.off", *SHORT, *first, "-q")
    before = contents(folder)
    one_line(run("fluid", "ball.off", *SHORT, *then, "--restart", "ball.fluid.restart.npz"), "tracers = ", "start anew")
    assert contents(folder) == before


def test_interrupt(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C while the tracers of a frame are written takes effect after it: frames, tracers and indices agree."""
    written = series_module.write_cloud

    def stop(cloud: Cloud, path: Path) -> None:
        if "00001" in path.name:
            signal.raise_signal(signal.SIGINT)
        written(cloud, path)

    monkeypatch.setattr(series_module, "write_cloud", stop)
    assert run("fluid", "ball.off", *SHORT, *TRACED, "-o", "flow.pvd").exit_code == 1
    assert len(clouds("flow.pvd")) == len(read_series("flow.pvd")) == 2
    assert not [name for name in files(folder) if name.startswith(".")]


# -- refusals ----------------------------------------------------------------------------------------------------


@both
@pytest.mark.parametrize("count", ["0", "-3", "2.5", "many", "10000001"])
def test_no_number(command: str, count: str, folder: Path) -> None:
    """What is no number of tracers: exit code 2, said in the last line, nothing written."""
    answer = run(command, "ball.off", "--tracers", count)
    assert answer.exit_code == 2
    last = answer.stderr.strip().splitlines()[-1]
    assert "--tracers" in last
    assert count in last
    assert files(folder) == ["ball.off"]


def test_manifolds_only(folder: Path) -> None:
    """A color is carried over three faces at an edge; a particle would not know where to go."""
    spoiled_inputs()
    before = files(folder)
    one_line(run("advect", "fan.off", *SHORT, *TRACED), "tracers", "3 faces meet at edge 0-1")
    assert files(folder) == before
    assert run("advect", "moebius.off", *SHORT, *TRACED, "-q").exit_code == 0


def test_tracers_read_from_are_not_written_over(folder: Path) -> None:
    """A mesh that has the name of tracers to come is not lost to them."""
    (folder / "ball.off").rename(folder / "flow.tracers.00000.off")
    write(read("flow.tracers.00000.off"), "flow.tracers.00000.vtp")
    before = contents(folder)
    one_line(run("fluid", "flow.tracers.00000.vtp", *SHORT, *TRACED, "-o", "flow.pvd"), "flow.pvd", "input")
    assert contents(folder) == before
