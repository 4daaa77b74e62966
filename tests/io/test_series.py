"""Series, films, tables, states and matrices as files read back exactly."""

import csv
import json
import subprocess
from pathlib import Path

import numpy as np
import pytest
import pyvista as pv
import scipy.io
import scipy.sparse as sp
from PIL import Image

from geomhw.errors import FormatError
from geomhw.io import read, read_cloud, write_cloud
from geomhw.io.artifacts.checkpoints import read_checkpoint, write_checkpoint
from geomhw.io.artifacts.films import write_gif, write_mp4
from geomhw.io.artifacts.matrices import write_matrix
from geomhw.io.artifacts.series import Frame, SeriesWriter, read_series
from geomhw.io.artifacts.tables import write_csv
from geomhw.results import Cloud, Field
from support.series_files import DOUBLES, frame, pictures, points

# -- series ------------------------------------------------------------------------------------------------------


def test_series(tmp_path: Path) -> None:
    """Frames are numbered in order, both indices agree, and times are exact."""
    writer = SeriesWriter(tmp_path / "a.b.pvd")
    for k, time in enumerate(DOUBLES):
        writer.add(time, frame(k))
        assert read_series(writer.path) == writer.frames  # valid after each
    assert [(f.time, f.file) for f in writer.frames] == [(t, f"a.b.{k:05d}.vtp") for k, t in enumerate(DOUBLES)]
    index = json.loads((tmp_path / "a.b.vtp.series").read_text())
    assert [(f["time"], f["name"]) for f in index["files"]] == [(f.time, f.file) for f in writer.frames]
    assert [read(tmp_path / f.file)["u"][0] for f in writer.frames] == list(range(len(DOUBLES)))


def test_times_of_numpy(tmp_path: Path) -> None:
    """Times may be numpy numbers."""
    writer = SeriesWriter(tmp_path / "a.pvd")
    writer.add(np.float64(0.1), frame(0))
    assert read_series(writer.path) == [Frame(0.1, "a.00000.vtp")]


def test_names_with_markup(tmp_path: Path) -> None:
    """Names with XML markup are escaped."""
    writer = SeriesWriter(tmp_path / 'a & "b" <c>.pvd')
    writer.add(0.0, frame(0))
    assert read_series(writer.path) == writer.frames


def test_going_on(tmp_path: Path) -> None:
    """With the frames of an earlier run, numbering continues."""
    first = SeriesWriter(tmp_path / "a.pvd")
    for k in range(3):
        first.add(k, frame(k))
    second = SeriesWriter(tmp_path / "a.pvd", read_series(tmp_path / "a.pvd")[:2])
    second.add(9.0, frame(9))
    assert read_series(tmp_path / "a.pvd") == [*first.frames[:2], Frame(9.0, "a.00002.vtp")]
    assert len(first.frames) == 3


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
    """A series owns its indices and all its possible frames, in its folder only."""
    (tmp_path / "sub").mkdir()
    assert SeriesWriter(tmp_path / "a.pvd").writes(tmp_path / name) is ours


def test_points_as_they_were(tmp_path: Path) -> None:
    """Points without faces read back to the last bit, with their types; repeated writes give the same bytes."""
    for name in ("a.vtp", "b.vtp"):
        write_cloud(points(0.1), tmp_path / name)
    assert (tmp_path / "a.vtp").read_bytes() == (tmp_path / "b.vtp").read_bytes()
    found, expected = read_cloud(tmp_path / "a.vtp"), points(0.1)
    assert found.points.tobytes() == expected.points.tobytes()
    for field in expected.fields:
        assert found[field.name].dtype == np.asarray(field.values).dtype
        np.testing.assert_array_equal(found[field.name], field.values)
    with pytest.raises(KeyError, match=r"no field 'v'.*u, id, past, times"):
        found["v"]
    with pytest.raises(FormatError, match="no faces, only vertex cells"):
        read(tmp_path / "a.vtp")


def test_series_with_tracers(tmp_path: Path) -> None:
    """Tracers are part 1 of each time, with files and an index of their own."""
    writer = SeriesWriter(tmp_path / "a.pvd")
    for k, time in enumerate(DOUBLES):
        writer.add(time, frame(k), points(k))
        assert read_series(writer.path) == writer.frames  # valid after each
    assert [f.tracers for f in writer.frames] == [f"a.tracers.{k:05d}.vtp" for k in range(len(DOUBLES))]
    assert [read_cloud(tmp_path / str(f.tracers))["u"][0] for f in writer.frames] == list(range(len(DOUBLES)))
    index = json.loads((tmp_path / "a.tracers.vtp.series").read_text())
    assert [(f["time"], f["name"]) for f in index["files"]] == [(f.time, f.tracers) for f in writer.frames]
    assert "tracers" not in (tmp_path / "a.vtp.series").read_text()


def test_gif(tmp_path: Path) -> None:
    """A GIF has all frames in order, with colors to a few levels, loops forever, and is deterministic."""
    for name in ("a.gif", "b.gif"):
        write_gif(tmp_path / name, iter(pictures()), fps=10)
    assert (tmp_path / "a.gif").read_bytes() == (tmp_path / "b.gif").read_bytes()
    with Image.open(tmp_path / "a.gif") as film:
        assert (film.n_frames, film.size, film.info["loop"], film.info["duration"]) == (4, (63, 41), 0, 100)
        for k, picture in enumerate(pictures()):
            film.seek(k)
            assert np.abs(np.asarray(film.convert("RGB")).astype(int) - picture).max() <= 8


def test_mp4(tmp_path: Path) -> None:
    """An MP4 has all frames, padded to even sides, and is deterministic."""
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


# -- tables, states, matrices ------------------------------------------------------------------------------------


def test_table_keeps_all_digits(tmp_path: Path) -> None:
    """Doubles read back to the last bit, and integers stay integers."""
    rows = [{"step": k, "x": x, "y": np.float64(x)} for k, x in enumerate(DOUBLES)]
    write_csv(tmp_path / "a.csv", rows)
    with (tmp_path / "a.csv").open(newline="") as stream:
        found = list(csv.DictReader(stream))
    assert [row["step"] for row in found] == [str(k) for k in range(len(DOUBLES))]
    for column in ("x", "y"):
        assert np.array([float(row[column]) for row in found]).tobytes() == np.array(DOUBLES).tobytes()
    assert b"\r" not in (tmp_path / "a.csv").read_bytes()


def test_state_round_trip(tmp_path: Path) -> None:
    """Description and arrays read back exactly; equal states give equal bytes."""
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


@pytest.mark.parametrize("name", ["a.npz", "a.mtx"])
@pytest.mark.parametrize("kind", [float, complex])
def test_matrix_round_trip(name: str, kind: type, tmp_path: Path) -> None:
    """Entries read back to the last bit; equal matrices give equal bytes, however they were stored."""
    rng = np.random.default_rng(0)
    dense = np.where(rng.random((7, 5)) < 0.4, rng.normal(size=(7, 5)) * 10.0 ** rng.integers(-300, 300, (7, 5)), 0)
    dense = dense.astype(kind) * (1 if kind is float else 1 - 0.5j)
    row, column = np.nonzero(dense)
    starts = np.searchsorted(row, np.arange(8))
    backwards = np.lexsort((-column, row))  # each row from right to left
    shuffled = sp.csr_array((dense[row, column][backwards], column[backwards], starts), shape=dense.shape)
    for matrix, path in ((sp.csc_array(dense), tmp_path / name), (shuffled, tmp_path / f"other{name}")):
        write_matrix(path, matrix)
        found = sp.load_npz(path) if name.endswith("npz") else scipy.io.mmread(path, spmatrix=False)
        np.testing.assert_array_equal(found.toarray(), dense)
    assert (tmp_path / name).read_bytes() == (tmp_path / f"other{name}").read_bytes()


def test_gif_keeps_rare_colors(tmp_path: Path) -> None:
    """The ends of a thin color bar keep their colors in a GIF of a large pale picture."""
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


def test_polylines_come_back(tmp_path: Path) -> None:
    """Polylines and their arrays come back; points of other files are put in the order of the lines."""
    rng = np.random.default_rng(4)
    cloud = Cloud(rng.normal(size=(9, 3)), [Field("arc", "vertex", np.arange(9.0))], np.array([0, 4, 6, 9]))
    write_cloud(cloud, tmp_path / "lines.vtp")
    found = read_cloud(tmp_path / "lines.vtp")
    assert found.lines is not None
    np.testing.assert_array_equal(found.lines, cloud.lines)
    np.testing.assert_array_equal(found.points, cloud.points)
    np.testing.assert_array_equal(found["arc"], cloud["arc"])
    other = pv.PolyData(cloud.points, lines=np.array([3, 8, 0, 2, 2, 1, 0]))
    other.point_data["arc"] = np.arange(9.0)
    other.save(tmp_path / "other.vtp")
    found = read_cloud(tmp_path / "other.vtp")
    assert found.lines is not None
    assert (found.lines.tolist(), found["arc"].tolist()) == ([0, 3, 5], [8, 0, 2, 1, 0])
    np.testing.assert_array_equal(found.points, cloud.points[[8, 0, 2, 1, 0]])
