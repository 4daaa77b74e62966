"""``--tracers`` of ``advect`` and ``fluid``: files, indices, films and restarts."""

import json
import signal
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image

from geomhw.io import read, read_cloud
from geomhw.io.artifacts import series as series_module
from geomhw.io.artifacts.series import read_series
from geomhw.results import Cloud
from support.flow_files import BALL, FILM, SHORT, both
from support.pictures import needs_opengl
from support.program import contents, files, run, save_off

TRACED = ("--tracers", "44")


@pytest.fixture(autouse=True)
def folder(folder: Path) -> Path:
    """Each test has its own working folder with a small sphere in it."""
    save_off(BALL)
    return folder


def clouds(path: str | Path) -> list[Cloud]:
    """Return the tracers of a series, after a check of its indices."""
    path = Path(path)
    entries = [item.attrib for item in ElementTree.parse(path).iter("DataSet")]
    frames, tracers = ([item for item in entries if item["part"] == part] for part in ("0", "1"))
    assert [item["timestep"] for item in tracers] == [item["timestep"] for item in frames]
    index = json.loads(path.with_suffix(".tracers.vtp.series").read_text())
    assert [(f["name"], f["time"]) for f in index["files"]] == [(t["file"], float(t["timestep"])) for t in tracers]
    assert [item["file"] for item in tracers] == [f"{path.stem}.tracers.{k:05d}.vtp" for k in range(len(tracers))]
    return [read_cloud(path.parent / item["file"]) for item in tracers]


# -- files -------------------------------------------------------------------------------------------------------


@both
def test_in_the_series(command: str) -> None:
    """Each frame has a cloud with its velocity and color; the mesh frames are unchanged by tracers."""
    assert run(command, "ball.off", *SHORT, *TRACED, "--color", "handout", "-o", "flow.pvd").exit_code == 0
    run(command, "ball.off", *SHORT, "--color", "handout", "-o", "plain.pvd", "-q")
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
    """In a rotation of one radian per unit of time, tracers turn by that angle."""
    option, free = {"advect": ("--field", []), "fluid": ("--init", ["--force", "none"])}[command]
    pace = ("--dt", "0.05", "--steps", "10", "--every", "10", "-q")
    run(command, "ball.off", option, "rigid:z", *free, *pace, *TRACED, "-o", "flow.pvd")
    first, last = (cloud.points[:, 0] + 1j * cloud.points[:, 1] for cloud in clouds("flow.pvd"))
    assert np.median(np.angle(last / first)) == pytest.approx(0.5, rel=0.1)


@both
def test_report(command: str) -> None:
    """The report has the number of tracers and their index file, or null."""
    report = json.loads(run(command, "ball.off", *SHORT, *TRACED, "--no-png", "--json").stdout)
    assert report["tracers"] == 44
    assert f"ball.{command}/ball.{command}.tracers.vtp.series" in report["files"]
    assert all(Path(name).is_file() for name in report["files"])
    assert json.loads(run(command, "ball.off", *SHORT, "-o", "plain.pvd", "--json").stdout)["tracers"] is None
    assert not Path("plain.tracers.vtp.series").exists()


def test_readable_by_vtk() -> None:
    """VTK reads the tracers as points, with one vertex cell each."""
    from vtkmodules.vtkIOXML import vtkXMLPolyDataReader

    run("fluid", "ball.off", "-o", "ball.fluid.pvd", *SHORT, *TRACED, "-q")
    reader = vtkXMLPolyDataReader()
    reader.SetFileName("ball.fluid.tracers.00002.vtp")
    reader.Update()
    data = reader.GetOutput()
    assert (data.GetNumberOfPoints(), data.GetNumberOfVerts(), data.GetNumberOfPolys()) == (44, 44, 0)
    assert data.GetPointData().GetArray("velocity").GetNumberOfComponents() == 3


@needs_opengl
@both
def test_film(command: str) -> None:
    """The picture has white streaks where the dye is not white."""
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
    """A run in two parts gives the tracer bytes of a single run."""
    for name in ("parts", "whole"):
        (folder / name).mkdir()
    same = (*options, *pace, *TRACED, "--every", "3", "-q")
    run("fluid", "ball.off", *same, "--steps", "7", "-o", "parts/flow.pvd")
    on = ("--restart", "parts/flow.restart.npz", "-o", "parts/flow.pvd")
    assert run("fluid", "ball.off", *same, "--steps", "11", *on).exit_code == 0
    run("fluid", "ball.off", *same, "--steps", "11", "-o", "whole/flow.pvd")
    assert len(clouds("parts/flow.pvd")) == 5
    assert contents(folder / "parts") == contents(folder / "whole")


def test_interrupt(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C during the tracers of a frame takes effect after the frame: frames, tracers and indices agree."""
    written = series_module.write_cloud

    def stop(cloud: Cloud, path: Path, **how: bool) -> None:
        if "00001" in path.name:
            signal.raise_signal(signal.SIGINT)
        written(cloud, path, **how)

    monkeypatch.setattr(series_module, "write_cloud", stop)
    assert run("fluid", "ball.off", *SHORT, *TRACED, "-o", "flow.pvd").exit_code == 130
    assert len(clouds("flow.pvd")) == len(read_series("flow.pvd")) == 2
    assert not [name for name in files(folder) if name.startswith(".")]
