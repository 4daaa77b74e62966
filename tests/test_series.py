"""Series, films, tables, states and matrices as files: whole or as they were, and read back to the last bit."""

import csv
import json
import subprocess
from pathlib import Path

import numpy as np
import pytest
import scipy.io
import scipy.sparse as sp
from PIL import Image

from geomhw.errors import FieldError, FormatError, RenderError
from geomhw.io import (
    Frame,
    SeriesWriter,
    read,
    read_checkpoint,
    read_cloud,
    read_series,
    require_mp4,
    write_checkpoint,
    write_cloud,
    write_csv,
    write_gif,
    write_matrix,
    write_mp4,
)
from geomhw.io.artifacts import series
from geomhw.mesh.primitives import icosphere
from geomhw.results import Cloud, Field, Result

BALL = icosphere(0)
#: Numbers that need all their digits, or few.
DOUBLES = [0.1, 1 / 3, 0.1 + 0.2, 5e-324, -1.7976931348623157e308, 1e22, 0.0, -0.0, 3.0]


def frame(value: float) -> Result:
    """One value everywhere."""
    return Result(BALL, [Field("u", "vertex", np.full(12, value))])


def contents(folder: Path) -> dict[str, bytes]:
    """Every file of a folder, hidden ones too."""
    return {path.name: path.read_bytes() for path in folder.iterdir()}


# -- series ------------------------------------------------------------------------------------------------------


def test_series(tmp_path: Path) -> None:
    """Frames in order, numbered from 0, both indices agreeing, times to the last bit."""
    writer = SeriesWriter(tmp_path / "a.b.pvd")
    for k, time in enumerate(DOUBLES):
        writer.add(time, frame(k))
        assert read_series(writer.path) == writer.frames  # valid after each
    assert [(f.time, f.file) for f in writer.frames] == [(t, f"a.b.{k:05d}.vtp") for k, t in enumerate(DOUBLES)]
    index = json.loads((tmp_path / "a.b.vtp.series").read_text())
    assert [(f["time"], f["name"]) for f in index["files"]] == [(f.time, f.file) for f in writer.frames]
    assert [read(tmp_path / f.file)["u"][0] for f in writer.frames] == list(range(len(DOUBLES)))


def test_times_of_numpy(tmp_path: Path) -> None:
    """A numpy number is a time as good as any."""
    writer = SeriesWriter(tmp_path / "a.pvd")
    writer.add(np.float64(0.1), frame(0))
    assert read_series(writer.path) == [Frame(0.1, "a.00000.vtp")]


def test_names_with_markup(tmp_path: Path) -> None:
    """A name may hold what XML does not like."""
    writer = SeriesWriter(tmp_path / 'a & "b" <c>.pvd')
    writer.add(0.0, frame(0))
    assert read_series(writer.path) == writer.frames


def test_going_on(tmp_path: Path) -> None:
    """With the frames of an earlier run given, the next is numbered after them."""
    first = SeriesWriter(tmp_path / "a.pvd")
    for k in range(3):
        first.add(k, frame(k))
    second = SeriesWriter(tmp_path / "a.pvd", read_series(tmp_path / "a.pvd")[:2])
    second.add(9.0, frame(9))
    assert read_series(tmp_path / "a.pvd") == [*first.frames[:2], Frame(9.0, "a.00002.vtp")]
    assert len(first.frames) == 3


@pytest.mark.parametrize("broken", ["write", "_pvd", "_series"])
def test_failure_leaves_a_valid_series(broken: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever fails in the middle, frame or index: both indices are as before, and the frame can be added anew."""
    writer = SeriesWriter(tmp_path / "a.pvd")
    writer.add(0.0, frame(0))
    before = contents(tmp_path)

    def fail(*given: object) -> str:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(series, broken, fail)
        with pytest.raises((FormatError, OSError)):
            writer.add(1.0, frame(1))
    after = contents(tmp_path)
    assert {name: after[name] for name in before} == before
    assert not [name for name in after if name.startswith(".")]
    writer.add(1.0, frame(1))
    assert [f.file for f in read_series(writer.path)] == ["a.00000.vtp", "a.00001.vtp"]


@pytest.mark.parametrize(
    ("name", "ours"),
    [
        ("a.pvd", True),
        ("a.vtp.series", True),
        ("a.00000.vtp", True),
        ("a.123456.vtp", True),
        ("a.0000.vtp", False),
        ("b.00000.vtp", False),
        ("xa.00000.vtp", False),
        ("a.vtp", False),
        ("sub/a.00000.vtp", False),
        ("sub/../a.00000.vtp", True),
        ("a.tracers.00000.vtp", True),
        ("a.tracers.vtp.series", True),
        ("a.tracers.vtp", False),
    ],
)
def test_which_files_are_of_a_series(name: str, ours: bool, tmp_path: Path) -> None:
    """Both indices and all frames that may ever come, in their folder only."""
    (tmp_path / "sub").mkdir()
    assert SeriesWriter(tmp_path / "a.pvd").writes(tmp_path / name) is ours


def points(value: float) -> Cloud:
    """Three points with arrays of all kinds, a wide one too."""
    fields = [
        Field("u", "vertex", np.full(3, value)),
        Field("id", "vertex", np.arange(3, dtype=np.int32)),
        Field("past", "vertex", np.arange(180, dtype=np.float32).reshape(3, 60)),
        Field("times", "mesh", np.array(DOUBLES)),
    ]
    return Cloud(np.array([[0.1, 1 / 3, -0.0], [1e300, 5e-324, 2.0], [0.0, value, 0.0]]), fields)


def test_points_as_they_were(tmp_path: Path) -> None:
    """Points without faces come back to the last bit, with the types of their arrays; the same bytes twice."""
    for name in ("a.vtp", "b.vtp"):
        write_cloud(points(0.1), tmp_path / name)
    assert (tmp_path / "a.vtp").read_bytes() == (tmp_path / "b.vtp").read_bytes()
    found, expected = read_cloud(tmp_path / "a.vtp"), points(0.1)
    assert found.points.tobytes() == expected.points.tobytes()
    for field in expected.fields:
        assert found[field.name].dtype == np.asarray(field.values).dtype
        np.testing.assert_array_equal(found[field.name], field.values)
    with pytest.raises(KeyError, match="no field 'v'; there are u, id, past, times"):
        found["v"]
    with pytest.raises(FormatError, match="no faces, only vertex cells"):
        read(tmp_path / "a.vtp")


def test_points_that_are_none(tmp_path: Path) -> None:
    """Rows for points that are not there, faces, another extension, a file that is no VTK file."""
    for location, rows in (("vertex", 2), ("face", 3)):
        with pytest.raises(FieldError, match="'u'"):
            Cloud(np.zeros((3, 3)), [Field("u", location, np.zeros(rows))])  # type: ignore[arg-type]
    with pytest.raises(FormatError, match=r"\.ply"):
        write_cloud(points(0), tmp_path / "a.ply")
    (tmp_path / "a.vtp").write_text("<VTKFile")
    with pytest.raises(FormatError, match="is not a whole VTK XML file"):
        read_cloud(tmp_path / "a.vtp")
    with pytest.raises(FormatError, match="no such file"):
        read_cloud(tmp_path / "b.vtp")


def test_series_with_tracers(tmp_path: Path) -> None:
    """Points as part 1 of each time, files and an index of their own; frames read back are those of the mesh."""
    writer = SeriesWriter(tmp_path / "a.pvd")
    for k, time in enumerate(DOUBLES):
        writer.add(time, frame(k), points(k))
        assert read_series(writer.path) == writer.frames  # valid after each
    assert [f.tracers for f in writer.frames] == [f"a.tracers.{k:05d}.vtp" for k in range(len(DOUBLES))]
    assert [read_cloud(tmp_path / str(f.tracers))["u"][0] for f in writer.frames] == list(range(len(DOUBLES)))
    index = json.loads((tmp_path / "a.tracers.vtp.series").read_text())
    assert [(f["time"], f["name"]) for f in index["files"]] == [(f.time, f.tracers) for f in writer.frames]
    assert "tracers" not in (tmp_path / "a.vtp.series").read_text()


@pytest.mark.parametrize(
    "text",
    ["", "no xml", '<VTKFile><DataSet timestep="soon" file="a"/></VTKFile>', '<VTKFile><DataSet file="a"/></VTKFile>'],
)
def test_no_series(text: str, tmp_path: Path) -> None:
    """What is no series is refused by name; so is a file that is not there."""
    (tmp_path / "a.pvd").write_text(text)
    for name in ("a.pvd", "b.pvd"):
        with pytest.raises(FormatError, match=name):
            read_series(tmp_path / name)


# -- films -------------------------------------------------------------------------------------------------------


def pictures(count: int = 4, size: tuple[int, int] = (41, 63)) -> list[np.ndarray]:
    """A white bar that moves over a red and blue ground."""
    images = []
    for k in range(count):
        image = np.zeros((*size, 3), dtype=np.uint8)
        image[: size[0] // 2, :, 0] = image[size[0] // 2 :, :, 2] = 200
        image[:, 10 * k : 10 * k + 10] = 255
        images.append(image)
    return images


def test_gif(tmp_path: Path) -> None:
    """All frames, of that size, in order, with colors to a few levels; endless; the same bytes twice."""
    for name in ("a.gif", "b.gif"):
        write_gif(tmp_path / name, iter(pictures()), fps=10)
    assert (tmp_path / "a.gif").read_bytes() == (tmp_path / "b.gif").read_bytes()
    with Image.open(tmp_path / "a.gif") as film:
        assert (film.n_frames, film.size, film.info["loop"], film.info["duration"]) == (4, (63, 41), 0, 100)
        for k, picture in enumerate(pictures()):
            film.seek(k)
            assert np.abs(np.asarray(film.convert("RGB")).astype(int) - picture).max() <= 8


def test_mp4(tmp_path: Path) -> None:
    """All frames, with odd sides made even, recognizable; the same bytes twice."""
    ffmpeg = pytest.importorskip("imageio_ffmpeg")
    for name in ("a.mp4", "b.mp4"):
        write_mp4(tmp_path / name, iter(pictures()))
    assert (tmp_path / "a.mp4").read_bytes() == (tmp_path / "b.mp4").read_bytes()
    decode = [ffmpeg.get_ffmpeg_exe(), "-v", "error", "-i", str(tmp_path / "a.mp4")]
    raw = subprocess.run([*decode, "-f", "rawvideo", "-pix_fmt", "rgb24", "-"], capture_output=True, check=True).stdout
    frames = np.frombuffer(raw, np.uint8).reshape(-1, 42, 64, 3).astype(int)
    assert len(frames) == 4
    for k, (found, picture) in enumerate(zip(frames, pictures(), strict=True)):
        assert found[20, 10 * k + 5].min() > 200
        assert np.abs(found[:41, :63] - picture).mean() < 3  # stretched by a pixel, it would be 6


@pytest.mark.parametrize("film", ["a.gif", "a.mp4"])
def test_a_film_that_fails(film: str, tmp_path: Path) -> None:
    """No frames, or a failure on the way: an error, and the former file is as it was, with nothing beside it."""
    if film.endswith("mp4"):
        pytest.importorskip("imageio_ffmpeg")
    write_film = {"a.gif": write_gif, "a.mp4": write_mp4}[film]
    (tmp_path / film).write_text("older")

    def fails():
        yield pictures()[0]
        raise KeyboardInterrupt

    with pytest.raises(FormatError, match="no frames"):
        write_film(tmp_path / film, [])
    with pytest.raises(KeyboardInterrupt):
        write_film(tmp_path / film, fails())
    assert contents(tmp_path) == {film: b"older"}


def test_mp4_without_the_program(monkeypatch: pytest.MonkeyPatch) -> None:
    """The package may be there without its ffmpeg: that is said as if it were not."""
    ffmpeg = pytest.importorskip("imageio_ffmpeg")

    def none() -> str:
        raise RuntimeError("No ffmpeg exe could be found.")

    monkeypatch.setattr(ffmpeg, "get_ffmpeg_exe", none)
    with pytest.raises(RenderError, match="imageio-ffmpeg"):
        require_mp4()


# -- tables, states, matrices ------------------------------------------------------------------------------------


def test_table_keeps_all_digits(tmp_path: Path) -> None:
    """Doubles read back to the last bit, Python's and numpy's alike; whole numbers stay whole."""
    rows = [{"step": k, "x": x, "y": np.float64(x)} for k, x in enumerate(DOUBLES)]
    write_csv(tmp_path / "a.csv", rows)
    with (tmp_path / "a.csv").open(newline="") as stream:
        found = list(csv.DictReader(stream))
    assert [row["step"] for row in found] == [str(k) for k in range(len(DOUBLES))]
    for column in ("x", "y"):
        assert np.array([float(row[column]) for row in found]).tobytes() == np.array(DOUBLES).tobytes()
    assert b"\r" not in (tmp_path / "a.csv").read_bytes()


def test_state_round_trip(tmp_path: Path) -> None:
    """Description and arrays come back as they were, and equal states give equal bytes, whatever the order of keys."""
    arrays = {"q": np.array(DOUBLES), "c": np.zeros((0, 3)), "k": np.arange(6).reshape(2, 3)}
    write_checkpoint(tmp_path / "a.npz", {"step": 3, "time": 0.1 + 0.2, "run": {"dt": None, "b": "x"}}, arrays)
    write_checkpoint(tmp_path / "b.npz", {"run": {"b": "x", "dt": None}, "time": 0.1 + 0.2, "step": 3}, arrays)
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()
    description, found = read_checkpoint(tmp_path / "a.npz")
    assert description == {"step": 3, "time": 0.1 + 0.2, "run": {"dt": None, "b": "x"}}
    assert list(found) == list(arrays)
    for name, values in arrays.items():
        assert (found[name].dtype, found[name].shape) == (values.dtype, values.shape)
        assert found[name].tobytes() == values.tobytes()


def test_no_state(tmp_path: Path) -> None:
    """Other files, and a state cut short, are refused in one line that names the file."""
    write_checkpoint(tmp_path / "good.npz", {"step": 1}, {"q": np.arange(100.0)})
    whole = (tmp_path / "good.npz").read_bytes()
    (tmp_path / "cut.npz").write_bytes(whole[: len(whole) // 2])
    (tmp_path / "empty.npz").write_bytes(b"")
    (tmp_path / "text.npz").write_text("not a state")
    np.save(tmp_path / "array.npy", np.ones(3))
    np.savez(tmp_path / "arrays.npz", q=np.ones(3))
    np.savez(tmp_path / "list.npz", description=np.array("[1, 2]"))
    np.savez(tmp_path / "words.npz", description=np.array("words"))
    for name in ("cut.npz", "empty.npz", "text.npz", "array.npy", "arrays.npz", "list.npz", "words.npz", "none.npz"):
        with pytest.raises(FormatError, match=name) as caught:
            read_checkpoint(tmp_path / name)
        assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", ["a.npz", "a.mtx"])
@pytest.mark.parametrize("kind", [float, complex])
def test_matrix_round_trip(name: str, kind: type, tmp_path: Path) -> None:
    """Entries come back to the last bit, however they were stored, and equal matrices give equal bytes."""
    rng = np.random.default_rng(0)
    dense = np.where(rng.random((7, 5)) < 0.4, rng.normal(size=(7, 5)) * 10.0 ** rng.integers(-300, 300, (7, 5)), 0)
    dense = dense.astype(kind) * (1 if kind is float else 1 - 0.5j)
    row, column = np.nonzero(dense)
    starts = np.searchsorted(row, np.arange(8))
    backwards = np.lexsort((-column, row))  # each row from right to left
    shuffled = sp.csr_array((dense[row, column][backwards], column[backwards], starts), shape=dense.shape)
    for matrix, path in ((sp.csc_array(dense), tmp_path / name), (shuffled, tmp_path / f"other{name}")):
        write_matrix(path, matrix)
        found = sp.load_npz(path) if name.endswith("npz") else scipy.io.mmread(path)
        np.testing.assert_array_equal(found.toarray(), dense)
    assert (tmp_path / name).read_bytes() == (tmp_path / f"other{name}").read_bytes()


def test_gif_keeps_rare_colors(tmp_path: Path) -> None:
    """A thin color bar below a large picture in pale shades keeps its strong ends, which median cut gives away."""
    y, x = np.mgrid[0:1:400j, 0:1:600j]
    pale = 200 + 50 * np.stack([np.sin(3 * x + y), np.cos(2 * y - x), np.sin(x * y * 5)], axis=2)
    bar = np.stack([x[0] * 160, 40 + 0 * x[0], (1 - x[0]) * 160], axis=1)
    picture = np.concatenate([pale, np.tile(bar, (4, 1, 1))]).astype(np.uint8)
    write_gif(tmp_path / "a.gif", [picture])
    with Image.open(tmp_path / "a.gif") as film:
        shown = np.asarray(film.convert("RGB")).astype(int)
    blocks = (shown - picture.astype(int)).reshape(101, 4, 150, 4, 3).mean(axis=(1, 3))  # as the eye takes dithering
    assert np.abs(blocks).max() <= 8
    assert np.abs((shown - picture)[-4:]).max() <= 40
