"""The page for the browser: what it stores, and what a browser makes of it."""

import base64
import json
import re
import shutil
import subprocess
import zlib
from pathlib import Path
from typing import Any

import nibabel
import numpy as np
import pytest
from numpy.typing import NDArray

from geomhw.errors import FieldError
from geomhw.io import read_png, write
from geomhw.mesh.primitives import icosphere
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.render import page
from geomhw.results import Cloud, Field, Result
from support.program import run

BALL = icosphere(3)
BROWSER = shutil.which("chromium") or shutil.which("google-chrome")


def scene_of(text: str) -> dict[str, Any]:
    """Return the description in a page."""
    found = re.search(r'<script type="application/json" id="scene">(.*?)</script>', text, re.DOTALL)
    assert found
    return json.loads(found[1])


def stored(text: str, place: dict[str, str]) -> NDArray[Any]:
    """Return an array of a page."""
    found = re.search(rf'id="{place["id"]}">([^<]*)</script>', text)
    assert found
    return np.frombuffer(zlib.decompress(base64.b64decode(found[1])), f"<{place['type']}")


def array_of(text: str, name: str) -> NDArray[Any]:
    """Return the values of an array in a page."""
    (item,) = [item for item in scene_of(text)["arrays"] if item["name"] == name]
    return stored(text, item["data"]).astype(float) * item["scale"]


@pytest.mark.parametrize("scale", [1e-300, 1e-20, 1.0, 1e20, 1e300])
def test_positions_and_values_in_single_precision(scale: float) -> None:
    """Positions and values are right to a relative 1e-7 at any scale; NaN and inf stay."""
    values = scale * np.sin(5 * BALL.vertices[:, 0])
    values[:3] = np.nan, np.inf, -np.inf
    size = float(np.clip(scale, 1e-29, 1e29))
    mesh = TriangleMesh(size * (BALL.vertices + 3), BALL.faces)
    text = page([Result(mesh, [Field("w", "vertex", values), Field("index", "face", np.arange(BALL.n_faces))])])
    scene = scene_of(text)
    positions = stored(text, scene["positions"]).reshape(-1, 3) * scene["size"] + scene["center"]
    np.testing.assert_allclose(positions, mesh.vertices, rtol=0, atol=2e-7 * size)
    np.testing.assert_array_equal(stored(text, scene["faces"]).reshape(-1, 3), mesh.faces)
    np.testing.assert_allclose(array_of(text, "w"), values, rtol=0, atol=1e-7 * scale)
    np.testing.assert_array_equal(array_of(text, "index"), np.arange(BALL.n_faces))


def test_one_file_without_network() -> None:
    """The page loads nothing, is at most three times its data in single precision, and quotes every name."""
    ball = icosphere(5)
    name = "</script><b>&\"'@title@"
    text = page([Result(ball, [Field(name, "vertex", np.sin(9 * ball.vertices[:, 2]))])], title=name)
    assert not re.search(r"https?://|\bsrc=|<link(?! rel=\"icon\" href=\"data:)", text)
    assert text.count("</script>") == text.count("<script")
    assert "<b>" not in text
    assert scene_of(text)["arrays"][0]["name"] == name
    assert len(text) < 3 * (4 * (ball.vertices.size + ball.faces.size + ball.n_vertices)) + 40_000


@pytest.mark.parametrize(
    ("name", "options", "up"),
    [
        ("m.surf.gii", "", 2),
        ("lh.pial", "", 2),
        ("m.ply", "", 1),
        ("m.glb", "", 1),
        ("m.surf.gii", "--up y", 1),
        ("m.surf.gii", "--view 0,90", 1),
    ],
)
def test_up_is_that_of_the_format(name: str, options: str, up: int, folder: Path) -> None:
    """What points up by definition of a format points up at the start, for a cortex z; options choose another axis."""
    mesh = icosphere(3)
    tall = TriangleMesh(mesh.vertices * [1.0, 2.0, 1.0], mesh.faces)
    save_as(name, tall)
    answer = run("geodesic", name, "-o", "d.vtp", "--html", "m.html", *options.split())
    assert answer.exit_code == 0, answer.stderr
    assert np.abs(scene_of(Path("m.html").read_text())["axes"][1]).argmax() == up
    if not options:
        assert run("advect", name, "--steps", "1", "-o", "a.pvd", "--html", "a.html").exit_code == 0
        assert scene_of(Path("a.html").read_text())["axes"] == scene_of(Path("m.html").read_text())["axes"]
        assert run("view", name, "-o", "v.html").exit_code == 0
        assert scene_of(Path("v.html").read_text())["axes"] == scene_of(Path("m.html").read_text())["axes"]


def save_as(name: str, mesh: TriangleMesh) -> None:
    """Write a mesh in the format of a name, also in one that the program only reads."""
    if name == "lh.pial":
        nibabel.freesurfer.write_geometry(name, mesh.vertices, mesh.faces)
    else:
        write(Result(mesh, []), name)


def test_series_share_what_does_not_change() -> None:
    """An array that changes is stored for each frame, any other once; an array that a frame lacks is left out."""
    frames = [
        Result(BALL, [Field("still", "vertex", BALL.vertices[:, 0]), Field("w", "vertex", k + BALL.vertices[:, 1])])
        for k in range(3)
    ]
    text = page(frames, [0.0, 0.5, 2.0], clouds={"tracers": [Cloud(np.full((2, 3), float(k))) for k in range(3)]})
    assert [(item["name"], item["frames"]) for item in scene_of(text)["arrays"]] == [("still", 1), ("w", 3)]
    np.testing.assert_allclose(array_of(text, "w").reshape(3, -1)[2], 2 + BALL.vertices[:, 1], atol=3e-7)
    assert scene_of(text)["times"] == [0, 0.5, 2]
    assert scene_of(text)["points"][0]["frames"] == 3
    bare = page([*frames[:2], Result(BALL, [frames[2].fields[0]])], [0.0, 1.0, 2.0])
    assert [item["name"] for item in scene_of(bare)["arrays"]] == ["still"]
    with pytest.raises(FieldError, match="frame 1 has another mesh"):
        page([frames[0], Result(icosphere(2), [])], [0.0, 1.0])
    with pytest.raises(FieldError, match="1 frames and 2 times"):
        page(frames[:1], [0.0, 1.0])


@pytest.mark.usefixtures("folder")
def test_command() -> None:
    """`geomhw view` writes one file; what cannot be shown is one sentence."""
    write(Result(BALL, [Field("distance", "vertex", BALL.vertices[:, 2])]), "ball.vtp")
    write(Result(BALL, []), "bare.vtp")
    assert run("view", "ball.vtp", "-o", "ball.html").output == "wrote     ball.html\n"
    assert scene_of(Path("ball.html").read_text("utf-8"))["active"] == "distance"
    run("advect", "ball.vtp", "--steps", "4", "--every", "2", "--tracers", "5", "-o", "a.pvd", "-q")
    answer = json.loads(run("view", "a.pvd", "--array", "color", "-o", "a.html", "--json").stdout)
    assert answer == {"command": "view", "file": "a.pvd", "frames": 3, "files": ["a.html"]}
    assert [item["name"] for item in scene_of(Path("a.html").read_text("utf-8"))["points"]] == ["tracers"]
    before = sorted(path.name for path in Path().iterdir())
    for arguments, code, words in (
        (["ball.vtp", "-o", "c.html", "--array", "heat"], 1, ["no array 'heat'", "distance"]),
        (["bare.vtp", "-o", "c.html", "--array", "heat"], 1, ["no array 'heat'"]),
        (["ball.vtp", "-o", "c.png"], 2, [".html"]),
        (["ball.vtp", "-o", "missing/c.html"], 1, ["missing"]),
    ):
        answer = run("view", *arguments)
        assert answer.exit_code == code
        assert all(word in answer.stderr for word in words)
        assert answer.stderr.count("Error") == 1
    assert sorted(path.name for path in Path().iterdir()) == before


def test_no_display(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Without -o and a display, the message says how to get a page."""
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr("sys.platform", "linux")
    write(Result(BALL, []), "ball.vtp")
    answer = run("view", "ball.vtp")
    assert answer.exit_code == 1
    assert "give -o page.html" in answer.stderr


def browse(address: str, *options: str) -> tuple[str, str]:
    """Load a page in a browser without a window; return what it prints and the messages of its console."""
    command = [str(BROWSER), "--headless", "--no-sandbox", "--disable-gpu", "--use-angle=swiftshader"]
    command += ["--enable-unsafe-swiftshader", "--disable-background-networking", "--disable-component-update"]
    command += ["--disable-sync", "--no-first-run", "--enable-logging=stderr", "--window-size=800,600"]
    command += [f"--user-data-dir={Path('profile').resolve()}", "--virtual-time-budget=20000", *options, address]
    answer = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)
    console = [line for line in answer.stderr.splitlines() if "CONSOLE" in line and "GL Driver Message" not in line]
    return answer.stdout, "\n".join(console)


@pytest.mark.skipif(BROWSER is None, reason="no Chromium is installed")
def test_in_a_browser(folder: Path) -> None:
    """The page draws the colors of an array, reads the values where it is clicked, and shows another time."""
    height = BALL.vertices[:, 1]
    frames = [
        Result(BALL, [Field("distance", "vertex", height + k), Field("speed", "face", np.arange(1280.0))])
        for k in (0, 0.5)
    ]
    Path("page.html").write_text(page(frames, [0.0, 0.25]), encoding="utf-8")
    address = Path("page.html").resolve().as_uri()
    text, console = browse(f"{address}#click=0.5,0.5&frame=1", "--dump-dom")
    assert console == ""
    assert 'data-state="ready"' in text
    cells = re.findall(r"<td>([^<]*)</td>", text)
    values = dict(zip(cells[::2], cells[1::2], strict=True))
    vertex, face = int(values["vertex"]), int(values["face"])
    assert vertex in BALL.faces[face]
    assert float(values["distance"]) == pytest.approx(height[vertex] + 0.5, rel=1e-6)
    assert float(values["speed"]) == face
    assert "t = 0.25" in text
    pictures = []
    for number, choices in enumerate(("array=distance", "array=distance&turn=0,1.5", "array=speed")):
        browse(f"{address}#{choices}", f"--screenshot={number}.png")
        pictures.append(np.asarray(read_png(f"{number}.png"))[120:480, 280:520].astype(int))
    apart = [np.abs(pictures[0] - other).mean() for other in pictures[1:]]
    assert min(apart) > 10  # turned, and by another array
    assert np.ptp(pictures[0][:, 120], axis=0).max() > 80  # the height changes from below to above
    assert np.abs(pictures[0][:, 120] - pictures[0][:, 119]).max() < 30


@pytest.mark.usefixtures("folder")
def test_pages_beside_pictures() -> None:
    """``--html`` leaves a page with the result and its sources, curves on their mesh, and a series with tracers."""
    write(Result(BALL, []), "ball.vtp")
    run("geodesic", "ball.vtp", "--source", "3", "-o", "d.vtp", "--html", "d.html")
    scene = scene_of(Path("d.html").read_text("utf-8"))
    assert scene["active"] == "distance"
    text = Path("d.html").read_text("utf-8")
    source = stored(text, scene["points"][0]["data"]) * scene["size"] + scene["center"]
    np.testing.assert_allclose(source, BALL.vertices[3], atol=1e-6)
    run("path", "ball.vtp", "--from", "0", "--to", "7", "-o", "p.vtp", "--html", "p.html")
    text = Path("p.html").read_text("utf-8")
    ends = stored(text, scene_of(text)["curves"][0]["data"]).reshape(-1, 2, 3)
    np.testing.assert_array_equal(ends[1:, 0], ends[:-1, 1])
    assert run("view", "ball.vtp", "--with", "p.vtp", "-o", "q.html").exit_code == 0
    assert len(scene_of(Path("q.html").read_text("utf-8"))["curves"]) == 1
    answer = run(
        "advect", "ball.vtp", "--steps", "4", "--every", "2", "--tracers", "5", "-o", "a.pvd", "--html", "a.html"
    )
    assert "wrote     a.html" in answer.stdout
    scene = scene_of(Path("a.html").read_text("utf-8"))
    assert (len(scene["times"]), scene["points"][0]["frames"]) == (3, 3)
    assert run("geodesic", "ball.vtp", "-o", "d.vtp", "--html", "d.pdf").exit_code == 2
