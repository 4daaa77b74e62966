"""Series, films and states that fail halfway leave the former files; damaged ones are refused."""

from pathlib import Path

import numpy as np
import pytest

from geomhw.errors import FieldError, FormatError, RenderError
from geomhw.io import read_cloud, write_cloud
from geomhw.io.artifacts import series
from geomhw.io.artifacts.checkpoints import read_checkpoint, write_checkpoint
from geomhw.io.artifacts.films import require_mp4, write_gif, write_mp4
from geomhw.io.artifacts.series import SeriesWriter, read_series
from geomhw.results import Cloud, Field
from support.program import contents
from support.series_files import frame, pictures, points


@pytest.mark.parametrize("broken", ["write", "_pvd", "_series"])
def test_failure_leaves_a_valid_series(broken: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """When a frame or index fails, both indices stay valid, and the frame can be added again."""
    writer = SeriesWriter(tmp_path / "a.pvd")
    writer.add(0.0, frame(0))
    before = contents(tmp_path)

    def fail(*given: object, **settings: object) -> str:
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


def test_points_that_are_none(tmp_path: Path) -> None:
    """Wrong numbers of rows, face fields, other formats and damaged files are refused."""
    for location, rows in (("vertex", 2), ("face", 3)):
        with pytest.raises(FieldError, match="'u'"):
            Cloud(np.zeros((3, 3)), [Field("u", location, np.zeros(rows))])  # type: ignore[arg-type]
    with pytest.raises(FormatError, match=r"\.ply"):
        write_cloud(points(0), tmp_path / "a.ply")
    (tmp_path / "a.vtp").write_text("<VTKFile")
    with pytest.raises(FormatError, match=r"a\.vtp.*whole VTK XML file"):
        read_cloud(tmp_path / "a.vtp")
    with pytest.raises(FormatError, match="no such file"):
        read_cloud(tmp_path / "b.vtp")


@pytest.mark.parametrize(
    "text",
    ["", "no xml", '<VTKFile><DataSet timestep="soon" file="a"/></VTKFile>', '<VTKFile><DataSet file="a"/></VTKFile>'],
)
def test_no_series(text: str, tmp_path: Path) -> None:
    """Damaged and missing series are refused with their names."""
    (tmp_path / "a.pvd").write_text(text)
    for name in ("a.pvd", "b.pvd"):
        with pytest.raises(FormatError, match=name):
            read_series(tmp_path / name)


@pytest.mark.parametrize("film", ["a.gif", "a.mp4"])
def test_a_film_that_fails(film: str, tmp_path: Path) -> None:
    """A film without frames or with a failure halfway keeps the former file."""
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
    """The package without its ffmpeg program counts as missing."""
    ffmpeg = pytest.importorskip("imageio_ffmpeg")

    def none() -> str:
        raise RuntimeError("No ffmpeg exe could be found.")

    monkeypatch.setattr(ffmpeg, "get_ffmpeg_exe", none)
    with pytest.raises(RenderError, match="imageio-ffmpeg"):
        require_mp4()


def test_no_state(tmp_path: Path) -> None:
    """Other files and truncated states are refused in one line with the file name."""
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
