"""``advect`` and ``fluid``: series, tables, films, interrupts and restarts."""

import json
import signal
import subprocess
import sys
import time
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from geomhw.flow.initial_fields import hue_stripes, rigid_field, waves
from geomhw.io import write
from geomhw.io.artifacts import series as series_module
from geomhw.mesh.primitives import grid
from geomhw.results import Field, Result
from support.flow_files import BALL, FILM, FINE, SHORT, both, jagged, series, spoiled_inputs, table, times
from support.messages import missing
from support.pictures import needs_opengl
from support.program import contents, files, run, save_off

COLUMNS = {
    "advect": "step,time,color_min,color_max,color_mean",
    "fluid": "step,time,energy,enstrophy,circulation,divergence,courant,color_min,color_max",
}


@pytest.fixture(autouse=True)
def folder(folder: Path) -> Path:
    """Each test has its own working folder with a small sphere in it."""
    save_off(BALL)
    return folder


# -- files -------------------------------------------------------------------------------------------------------


@both
def test_default_names(command: str, folder: Path) -> None:
    """By default the series goes to a folder of its own, without pictures on request, with a report in words."""
    answer = run(command, "ball.off", *SHORT, "--no-png")
    assert answer.exit_code == 0
    assert answer.stderr == ""
    name = f"ball.{command}"
    frames = [f"{name}.{k:05d}.vtp" for k in range(4)]
    state = [f"{name}.restart.npz"] if command == "fluid" else []
    assert files(folder / name) == sorted([f"{name}.pvd", f"{name}.vtp.series", *frames, *state])
    assert sorted(path.name for path in folder.iterdir()) == [name, "ball.off"]
    for word in ("42 vertices", "0.07", "7 steps", f"{name}.pvd"):
        assert word in answer.stdout


@needs_opengl
@both
def test_default_pictures(command: str, folder: Path) -> None:
    """By default a contact sheet and a film lie beside the folder of frames; a second run replaces its frames."""
    name = f"ball.{command}"
    assert run(command, "ball.off", *FILM).exit_code == 0
    assert sorted(path.name for path in folder.iterdir()) == sorted([name, f"{name}.gif", f"{name}.png", "ball.off"])
    answer = run(command, "ball.off", "--dt", "0.01", "--steps", "2", "--every", "2", "--width", "150")
    assert "2 files of an earlier run are removed" in answer.stdout
    assert len(series(f"{name}/{name}.pvd")) == 2
    with Image.open(f"{name}.png") as sheet:
        assert sheet.text["Description"].startswith(f"geomhw {command} ball.off --dt 0.01")
        assert sheet.text["Software"].startswith("geomhw ")


def test_a_failed_run_leaves_no_folder(folder: Path) -> None:
    """A command that fails before the first frame leaves no empty folder; a file in its place is refused."""
    assert run("fluid", "none.off", "--steps", "3").exit_code == 1
    assert files(folder) == ["ball.off"]
    (folder / "ball.fluid").write_text("")
    assert "is no folder" in run("fluid", "ball.off", *SHORT).stderr


@both
def test_frames(command: str) -> None:
    """Each frame holds color, velocity and time, and a fluid's also vorticity, at the expected times."""
    run(command, "ball.off", *SHORT, "-o", "flow.pvd", "-q")
    expected = {"color": ("vertex", (42,)), "velocity": ("face", (80, 3)), "time": ("mesh", (1,))}
    expected |= {"vorticity": ("vertex", (42,))} if command == "fluid" else {}
    for frame in series("flow.pvd"):
        assert {field.name: (field.location, np.shape(field.values)) for field in frame.fields} == expected
        np.testing.assert_array_equal(frame.mesh.vertices, BALL.vertices)
    np.testing.assert_allclose(times("flow.pvd"), [0, 0.03, 0.06, 0.07], rtol=1e-14)
    np.testing.assert_array_equal(series("flow.pvd")[0]["color"], waves(BALL))
    run(command, "ball.off", *SHORT, "-o", "old.pvd", "--color", "handout", "-q")
    np.testing.assert_array_equal(series("old.pvd")[0]["color"], hue_stripes(BALL))


@both
def test_another_folder(command: str, folder: Path) -> None:
    """``-o`` in another folder puts all files there; the folder can be moved, since names are relative."""
    (folder / "out").mkdir()
    assert run(command, "ball.off", *SHORT, "-o", "out/flow.pvd").exit_code == 0
    assert files(folder) == ["ball.off", "out"]
    (folder / "out").rename(folder / "moved")
    assert len(series("moved/flow.pvd")) == 4


@both
def test_table(command: str) -> None:
    """The table has the documented columns, one line per frame, with the times of the series."""
    run(command, "ball.off", *SHORT, "-o", "flow.pvd", "--csv", "flow.csv", "-q")
    assert Path("flow.csv").read_text().splitlines()[0] == COLUMNS[command]
    rows = table("flow.csv")
    assert [row["step"] for row in rows] == [0, 3, 6, 7]
    assert [row["time"] for row in rows] == times("flow.pvd")
    assert [row["color_max"] for row in rows] == [frame["color"].max() for frame in series("flow.pvd")]
    for column in COLUMNS[command].split(","):
        assert column in " ".join(run(command, "--help").stdout.split())


@both
def test_report_is_json(command: str) -> None:
    """``--json`` prints command, mesh, parameters with defaults, the last table line, files and seconds."""
    answer = run(command, "ball.off", "--steps", "4", "--every", "2", "-o", "f.pvd", "--csv", "f.csv", "--json")
    report = json.loads(answer.stdout)
    assert report["command"] == command
    assert report["mesh"]["vertices"] == 42
    assert (report["dt"], report["steps"], report["every"]) == (0.0005, 4, 2)
    assert report["last"] == table("f.csv")[-1]
    assert {"f.pvd", "f.vtp.series", "f.csv"} <= set(report["files"])
    assert all(Path(name).is_file() for name in report["files"])
    assert {"read", "compute and write"} <= set(report["seconds"])


@both
def test_quiet_says_nothing(command: str) -> None:
    """``-q`` prints nothing; the series is written."""
    answer = run(command, "ball.off", *SHORT, "--no-png", "-q")
    assert answer.exit_code == 0
    assert answer.output == ""
    assert len(series(f"ball.{command}/ball.{command}.pvd")) == 4


@both
def test_bytes_repeat(command: str, folder: Path) -> None:
    """Two runs write the same bytes."""
    for name in ("one", "two"):
        (folder / name).mkdir()
        run(command, "ball.off", *SHORT, "-o", f"{name}/flow.pvd", "--csv", f"{name}/flow.csv", "-q")
    assert contents(folder / "one") == contents(folder / "two")


@both
def test_defaults_in_the_help(command: str) -> None:
    """The help states the handout's defaults: 1980 steps of 0.0005, with a frame every 66."""
    words = " ".join(run(command, "--help").stdout.split())
    for name, default in (("--dt T", "0.0005"), ("--steps N", "1980"), ("--every K", "66")):
        assert f"[default: {default}]" in words.partition(name)[2][:80]


# -- films -------------------------------------------------------------------------------------------------------


@needs_opengl
@both
def test_width(command: str) -> None:
    """Each panel of a film has the requested width: one panel for ``advect``, two for ``fluid``."""
    assert run(command, "ball.off", *SHORT, "--width", "150", "--gif", "small.gif").exit_code == 0
    with Image.open("small.gif") as gif:
        assert gif.size[0] == 150 * (1 if command == "advect" else 2)


@needs_opengl
@both
def test_gif_and_sheet(command: str) -> None:
    """A GIF has as many frames as the series, all different; the contact sheet holds all of them."""
    answer = run(command, "ball.off", *FILM, "--gif", "flow.gif", "--png", "flow.png")
    assert answer.exit_code == 0
    assert "flow.gif" in answer.stdout
    with Image.open("flow.gif") as gif, Image.open("flow.png") as sheet:
        assert gif.n_frames == 4
        size, pictures = gif.size, []
        for k in range(gif.n_frames):
            gif.seek(k)
            pictures.append(np.asarray(gif.convert("RGB")).astype(int))
        assert sheet.width % (size[0] // 2) == 0
    for one, other in pairwise(pictures):
        body = np.abs(one - other)[60:].max(axis=2)  # below the title, which has the time
        assert (body > 40).mean() > 0.002


@needs_opengl
def test_mp4() -> None:
    """An MP4 has as many frames as the series."""
    ffmpeg = pytest.importorskip("imageio_ffmpeg")
    assert run("advect", "ball.off", *SHORT, "--mp4", "flow.mp4", "-q").exit_code == 0
    assert ffmpeg.count_frames_and_secs("flow.mp4")[0] == 4


# -- computation -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("step", [("--dt", "0.03"), ("--cfl", "0.7", "--force", "none")])
def test_until_is_met_exactly(step: tuple[str, ...]) -> None:
    """``--until`` ends at exactly that time, for any step."""
    run("fluid", "ball.off", "-o", "ball.fluid.pvd", *step, "--until", "0.1", "--every", "2", "--csv", "f.csv", "-q")
    assert times("ball.fluid.pvd")[-1] == 0.1
    assert table("f.csv")[-1]["time"] == 0.1


def test_courant_number() -> None:
    """With ``--cfl`` each whole step has that Courant number, by the fastest face."""
    run(
        "fluid",
        "ball.off",
        "-o",
        "ball.fluid.pvd",
        "--cfl",
        "0.5",
        "--force",
        "none",
        "--steps",
        "4",
        "--every",
        "1",
        "--csv",
        "f.csv",
        "-q",
    )
    first = series("ball.fluid.pvd")[0]
    dt = 0.5 * BALL.mean_edge_length / np.linalg.norm(first["velocity"], axis=1).max()
    assert times("ball.fluid.pvd")[1] == pytest.approx(dt, rel=1e-12)
    np.testing.assert_allclose([row["courant"] for row in table("f.csv")], 0.5, rtol=0.05)


def test_force() -> None:
    """``--force none`` keeps a fluid at rest; the default jet accelerates it near the top only."""
    write(Result(BALL, [Field("rest", "face", np.zeros((80, 3)))]), "rest.vtp")
    for name, force in (("none", ["--force", "none"]), ("jet", ["--force", "jet"]), ("default", [])):
        run("fluid", "ball.off", "--init", "rest.vtp:rest", *SHORT, *force, "-o", f"{name}.pvd", "--csv", f"{name}.csv")
    assert {row["energy"] for row in table("none.csv")} == {0.0}
    assert table("jet.csv")[-1]["energy"] > 1e-3
    assert Path("jet.csv").read_bytes() == Path("default.csv").read_bytes()
    speed = np.linalg.norm(series("jet.pvd")[1]["velocity"], axis=1)
    assert speed[BALL.face_centers[:, 2] > 0.7].mean() > 3 * speed[BALL.face_centers[:, 2] < 0].mean()


@pytest.mark.parametrize(
    ("scheme", "kept"),
    [
        (["conservative"], (1 - 1e-9, 1 + 1e-9)),
        (["fast", "--no-filter"], (1 - 1e-6, 1 + 1e-6)),
        (["handout"], (0.001, 0.5)),
        (["handout", "--advection", "increment"], (0.9, 1 - 1e-6)),
    ],
)
def test_schemes(scheme: list[str], kept: tuple[float, float]) -> None:
    """Each scheme keeps its share of the energy; only the handout's damping is remarked."""
    pace = ("--dt", "0.002", "--steps", "5", "--every", "5")
    free = ("--scheme", *scheme, "--init", "random:3", "--force", "none")
    answer = run("fluid", "ball.off", *free, *pace, "--csv", "f.csv", "--no-png")
    assert answer.exit_code == 0
    rows = table("f.csv")
    assert kept[0] <= rows[-1]["energy"] / rows[0]["energy"] <= kept[1]
    assert ("damps" in answer.stdout) == (scheme[0] == "handout")
    assert max(row["divergence"] for row in rows) < 1e-9


@pytest.mark.parametrize("arguments", [["advect", "--field"], ["fluid", "--force", "none", "--init"]])
def test_downstream(arguments: list[str]) -> None:
    """A blob in a rigid rotation about z is a quarter of a turn ahead after a quarter of a turn."""
    save_off(FINE, "fine.off")
    start = int(FINE.vertices[:, 0].argmax())
    command, *field = arguments
    quarter = repr(np.pi / 2 / 32)
    run(
        command,
        "fine.off",
        *field,
        "rigid:z",
        "--color",
        f"blob:{start}",
        "--dt",
        quarter,
        "--steps",
        "32",
        "-o",
        "f.pvd",
    )
    first, last = (series("f.pvd")[k] for k in (0, -1))
    angles = []
    for frame in (first, last):
        center = (frame["color"] * FINE.vertex_areas) @ FINE.vertices
        angles.append(np.arctan2(center[1], center[0]))
    assert angles[0] == pytest.approx(0, abs=0.6)
    assert angles[1] - angles[0] == pytest.approx(np.pi / 2, abs=0.15)


@pytest.mark.parametrize(("command", "option"), [("advect", "--field"), ("fluid", "--init")])
def test_arrays_from_files(command: str, option: str) -> None:
    """FILE:ARRAY gives the same flow as the built-in field with the same values."""
    z = np.array([0.0, 0.0, 1.0])
    fields = [
        Field("by_face", "face", rigid_field(BALL, z)),
        Field("by_vertex", "vertex", np.cross(z, BALL.vertices)),
        Field("hue", "vertex", hue_stripes(BALL)),
        Field("one", "vertex", BALL.vertices[:, [0]]),
    ]
    write(Result(BALL, fields), "in.vtp")
    assert run(command, "ball.off", option, "rigid:z", "--color", "handout", *SHORT, "-o", "own.pvd").exit_code == 0
    for name in ("by_face", "by_vertex"):
        given = (option, f"in.vtp:{name}", "--color", "in.vtp:hue")
        assert run(command, "ball.off", *given, *SHORT, "-o", f"{name}.pvd", "-q").exit_code == 0
        for expected, found in zip(series("own.pvd"), series(f"{name}.pvd"), strict=True):
            for array in ("color", "velocity"):
                np.testing.assert_allclose(found[array], expected[array], atol=1e-12)
    assert run(command, "ball.off", "--color", "in.vtp:one", *SHORT, "-o", "one.pvd", "-q").exit_code == 0
    np.testing.assert_array_equal(series("one.pvd")[0]["color"], BALL.vertices[:, 0])


@pytest.mark.parametrize("mesh", ["fan.off", "moebius.off"])
def test_advect_needs_no_manifold(mesh: str) -> None:
    """``advect`` accepts non-manifold and one-sided meshes."""
    spoiled_inputs()
    assert run("advect", mesh, *SHORT, "-o", "f.pvd", "-q").exit_code == 0
    assert len(series("f.pvd")) == 4


OPEN = ("advect", "plate.off", "--field", "rigid:z", "--color", "x", "--dt", "0.02", "--every", "10", "-o", "f.pvd")


def test_advect_through_a_boundary() -> None:
    """By default the color keeps its range; the exponential is warned about and, once it grows, stopped."""
    plate = grid(12, 12)
    save_off(plate, "plate.off")
    low, high = np.ptp(plate.vertices[:, 0]) * np.array([0, 1]) + plate.vertices[:, 0].min()
    answer = run(*OPEN, "--steps", "400", "--csv", "f.csv", "--json")
    report = json.loads(answer.stdout)
    assert (report["integrator"], report["remarks"]) == ("bounded", [])
    assert all(low <= row["color_min"] <= row["color_max"] <= high for row in table("f.csv"))
    series_option = ("--integrator", "expm")
    words = run(*OPEN, "--steps", "60", *series_option).stdout
    assert not missing(words, "warning ... leaves its range from step ... times the width ... --integrator bounded")
    answer = run(*OPEN, "--steps", "4000", *series_option)
    assert (answer.exit_code, answer.stdout) == (1, "")
    assert not missing(answer.stderr, "grows without bound ... at step")
    assert all(np.isfinite(frame["color"]).all() for frame in series("f.pvd"))


def test_fluid_that_gains_energy() -> None:
    """A flow that gains energy without a force is stopped; its frames are whole. Growth below is a warning."""
    mesh, V = jagged(18)
    save_off(mesh, "jagged.off")
    np.save("V.npy", V)
    arguments = ("fluid", "jagged.off", "--init", "V.npy", "--scheme", "stable-fluids", "--force", "none", "--cfl", "2")
    answer = run(*arguments, "--steps", "12", "--every", "1", "-o", "f.pvd")
    assert (answer.exit_code, answer.stdout) == (1, "")
    assert not missing(answer.stderr, "gains energy ... at step ... shorter time step")
    assert len(series("f.pvd")) > 1
    mesh, V = jagged(86)
    save_off(mesh, "jagged.off")
    np.save("V.npy", V)
    answer = run(*arguments[:4], "--force", "none", "--cfl", "2", "--steps", "12", "--json")
    assert answer.exit_code == 0
    assert any(
        not missing(line, "warning ... enstrophy ... from step ... times the bound")
        for line in json.loads(answer.stdout)["remarks"]
    )


# -- interrupt and restart ---------------------------------------------------------------------------------------

LONG = ("--dt", "0.001", "--steps", "400", "--every", "50")


def interrupted(output: str, *options: str) -> "subprocess.CompletedProcess[str]":
    """Start a long run, and interrupt it once its third frame exists."""
    command = [sys.executable, "-m", "geomhw_cli", "fluid", "ball.off", *LONG, "-o", output, *options]
    process = subprocess.Popen(
        command,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        # Background processes of a shell inherit ignored interrupts.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    with process:
        third = Path(output).with_suffix(".00002.vtp")
        give_up = time.monotonic() + 30
        while not third.exists() and process.poll() is None and time.monotonic() < give_up:
            time.sleep(0.002)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=30)
    return subprocess.CompletedProcess(command, process.returncode, out, err)


@pytest.mark.skipif(sys.platform == "win32", reason="no SIGINT to send")
@needs_opengl
def test_interrupt_and_restart(folder: Path) -> None:
    """After Ctrl-C the series is valid; the restarted run ends in the bytes of an uninterrupted one."""
    for name in ("stopped", "whole"):
        (folder / name).mkdir()
    done = interrupted("stopped/flow.pvd", "--csv", "stopped/flow.csv")
    assert done.returncode == 130
    assert done.stdout == ""
    assert "Traceback" not in done.stderr
    assert len(done.stderr.strip().splitlines()) <= 1
    assert 2 <= len(series("stopped/flow.pvd")) < 9
    assert not [name for name in files(folder / "stopped") if name.startswith(".")]

    films = ("--csv", "stopped/flow.csv", "--gif", "film.gif")
    again = ("--restart", "stopped/flow.restart.npz", "-o", "stopped/flow.pvd", *films)
    assert run("fluid", "ball.off", *LONG, *again).exit_code == 0
    run("fluid", "ball.off", *LONG, "-o", "whole/flow.pvd", "--csv", "whole/flow.csv", "-q")
    assert len(series("stopped/flow.pvd")) == 9
    assert files(folder / "stopped") == files(folder / "whole")
    assert contents(folder / "stopped") == contents(folder / "whole")
    with Image.open("film.gif") as film:
        assert film.n_frames == 9


@both
def test_interrupt_amid_a_frame(command: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C during a frame takes effect after the frame: indices and table agree, no other file is left."""
    written = series_module._series

    def stop(frames: list[series_module.Frame]) -> str:
        if len(frames) == 2:
            signal.raise_signal(signal.SIGINT)
        return written(frames)

    monkeypatch.setattr(series_module, "_series", stop)
    answer = run(command, "ball.off", *SHORT, "-o", "flow.pvd", "--csv", "flow.csv", "--gif", "flow.gif")
    assert answer.exit_code == 130
    assert answer.stdout == ""
    assert [row["time"] for row in table("flow.csv")] == times("flow.pvd")
    assert len(times("flow.pvd")) == 2
    state = ["flow.restart.npz"] if command == "fluid" else []
    frames = ["flow.00000.vtp", "flow.00001.vtp"]
    assert files(folder) == sorted(["ball.off", "flow.csv", "flow.pvd", "flow.vtp.series", *frames, *state])


@pytest.mark.parametrize("options", [[], ["--scheme", "fast"], ["--scheme", "handout"], ["--viscosity", "0.01"]])
@pytest.mark.parametrize("pace", [["--dt", "0.01"], ["--cfl", "0.3", "--force", "none"]])
def test_a_run_in_two_parts(options: list[str], pace: list[str], folder: Path) -> None:
    """A run in two parts gives the bytes of a single run, for each scheme and pace."""
    for name in ("parts", "whole"):
        (folder / name).mkdir()
    same = (*options, *pace, "--every", "3", "-q")
    run("fluid", "ball.off", *same, "--steps", "7", "-o", "parts/flow.pvd", "--csv", "parts/flow.csv")
    assert len(series("parts/flow.pvd")) == 4
    on = ("--restart", "parts/flow.restart.npz", "-o", "parts/flow.pvd", "--csv", "parts/flow.csv")
    assert run("fluid", "ball.off", *same, "--steps", "11", *on).exit_code == 0
    run("fluid", "ball.off", *same, "--steps", "11", "-o", "whole/flow.pvd", "--csv", "whole/flow.csv")
    assert contents(folder / "parts") == contents(folder / "whole")


def test_restart_from_the_start() -> None:
    """A run stopped before its second regular frame restarts from the beginning."""
    steps = ("--dt", "0.01", "--every", "3", "-q")
    run("fluid", "ball.off", "-o", "ball.fluid.pvd", *steps, "--steps", "2")
    assert run("fluid", "ball.off", *steps, "--steps", "6", "--restart", "ball.fluid.restart.npz").exit_code == 0
    np.testing.assert_allclose(times("ball.fluid.pvd"), [0, 0.03, 0.06], rtol=1e-14)


def test_color_of_bytes() -> None:
    """RGB stored as bytes is scaled to [0, 1]."""
    write(Result(BALL, [Field("rgb", "vertex", np.full((42, 3), 51, dtype=np.uint8))]), "in.vtp")
    run("advect", "ball.off", "-o", "ball.advect.pvd", "--color", "in.vtp:rgb", *SHORT, "-q")
    np.testing.assert_allclose(series("ball.advect.pvd")[0]["color"], 0.2, rtol=1e-12)


def test_restart_of_a_run_that_is_done() -> None:
    """A restart of a finished run adds no frame, but writes the other requested files."""
    steps = ("--dt", "0.01", "--steps", "6", "--every", "3")
    run("fluid", "ball.off", "-o", "ball.fluid.pvd", *steps, "-q")
    again = run("fluid", "ball.off", *steps, "--restart", "ball.fluid.restart.npz", "--csv", "f.csv")
    assert again.exit_code == 0
    assert [row["step"] for row in table("f.csv")] == [0, 3, 6]
    assert len(series("ball.fluid.pvd")) == 3


def test_a_field_that_is_zero_on_the_mesh(folder: Path) -> None:
    """A rotation about an axis within a flat mesh moves nothing there; the command says so."""
    save_off(grid(4, 4), "flat.off")
    answers = [run("advect", "flat.off", "--steps", "2", "--no-png", "--field", f"rotation:{axis}") for axis in "xz"]
    assert [answer.exit_code for answer in answers] == [0, 0]
    assert ["nothing moves" in answer.output for answer in answers] == [True, False]
    answers = [run("fluid", "flat.off", "--steps", "2", "--no-png", "--init", f"rotation:{axis}") for axis in "xz"]
    assert ["nothing moves" in answer.output for answer in answers] == [True, False]
