"""Writing is atomic and deterministic: the same bytes, permissions and links, and nothing left over."""

import errno
import os
import stat

import numpy as np
import pytest

from geomhw.io import check_outputs, write, write_png
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.results import Field, Result
from support.program import contents

MESH = TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
RESULT = Result(MESH, [Field("u", "vertex", np.ones(3)), Field("v", "face", np.ones((1, 3)))])
NAMES = ["a.vtk", "b.vtp", "c.vtu", "d.ply"]


def test_writing_twice_gives_the_same_bytes_and_nothing_else(tmp_path):
    """Writing twice gives the same bytes, and no other file."""
    write(RESULT, [tmp_path / name for name in NAMES])
    first = contents(tmp_path)
    assert sorted(first) == NAMES
    write(RESULT, [tmp_path / name for name in NAMES])
    assert contents(tmp_path) == first


@pytest.mark.parametrize("mask", [0o022, 0o077, 0o002])
def test_permissions_are_those_of_the_umask(tmp_path, mask):
    """Permissions follow the umask."""
    before = os.umask(mask)
    try:
        write(RESULT, tmp_path / "a.vtp")
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "a.vtp").stat().st_mode) == 0o666 & ~mask


def test_without_hard_links_the_old_files_are_copied(tmp_path, monkeypatch):
    """Where hard links fail, the former files are copied."""

    def refuse(*_):
        raise OSError(errno.EPERM, "no links here")

    (tmp_path / "a.vtk").write_text("old a")
    monkeypatch.setattr(os, "link", refuse)
    write(RESULT, [tmp_path / "a.vtk", tmp_path / "b.vtp"])
    assert sorted(contents(tmp_path)) == ["a.vtk", "b.vtp"]
    assert contents(tmp_path)["a.vtk"].startswith(b"# vtk")


def test_a_link_stays_a_link(tmp_path):
    """A link stays a link."""
    (tmp_path / "far").mkdir()
    (tmp_path / "far" / "real.vtp").write_text("old")
    (tmp_path / "link.vtp").symlink_to("far/real.vtp")
    write(RESULT, tmp_path / "link.vtp")
    assert (tmp_path / "link.vtp").is_symlink()
    assert (tmp_path / "far" / "real.vtp").read_bytes().startswith(b"<?xml")


def test_good_outputs_pass_the_check(tmp_path, monkeypatch):
    """Valid outputs pass the check, which writes nothing."""
    (tmp_path / "in.off").write_text("OFF")
    (tmp_path / "a.VTK").write_text("old")
    check_outputs([tmp_path / "a.VTK", tmp_path / "b.ply"], [tmp_path / "in.off", tmp_path / "missing.off"])
    check_outputs([tmp_path / "a.png"], extensions=[".png"])
    monkeypatch.chdir(tmp_path)
    check_outputs(["b.ply"])
    assert sorted(contents(tmp_path)) == ["a.VTK", "in.off"]


def test_png_bytes_are_the_same_every_time(tmp_path):
    """A picture has the same bytes each time, and reads back exactly."""
    from PIL import Image

    image = np.random.default_rng(0).integers(0, 256, (4, 7, 3), dtype=np.uint8)
    write_png(tmp_path / "a.png", image)
    first = contents(tmp_path)
    write_png(tmp_path / "a.png", image[:, ::-1][:, ::-1])
    assert contents(tmp_path) == first
    with Image.open(tmp_path / "a.png") as opened:
        np.testing.assert_array_equal(np.asarray(opened), image)
