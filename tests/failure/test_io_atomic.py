"""Atomic writing: after any failure the former files are there, and no others."""

import errno
import os

import numpy as np
import pytest

from geomhw.errors import FormatError
from geomhw.io import check_outputs, replacing, write, write_png
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.results import Field, Result
from support.messages import missing
from support.program import contents

MESH = TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
RESULT = Result(MESH, [Field("u", "vertex", np.ones(3)), Field("v", "face", np.ones((1, 3)))])
NAMES = ["a.vtk", "b.vtp", "c.vtu", "d.ply"]


@pytest.mark.parametrize("error", [KeyboardInterrupt, ValueError, SystemExit])
def test_an_interrupt_leaves_what_was_there(tmp_path, error):
    """An exception while files are written restores the former files."""
    (tmp_path / "a.txt").write_text("old")

    def fail():
        with replacing([tmp_path / "a.txt", tmp_path / "b.txt"]) as temporaries:
            assert all(path.name.startswith(".") and path.suffix == ".txt" for path in temporaries)
            temporaries[0].write_text("new")
            raise error

    with pytest.raises(error):
        fail()
    assert contents(tmp_path) == {"a.txt": b"old"}


def test_a_full_disk_is_one_sentence(tmp_path, monkeypatch):
    """A full disk gives one line, and keeps the former files."""
    (tmp_path / "a.vtp").write_text("old")

    def full(result, stream):
        stream.write(b"part")
        raise OSError(errno.ENOSPC, "No space left on device", stream.name)

    monkeypatch.setitem(write.__globals__["_WRITERS"], ".ply", full)
    with pytest.raises(FormatError, match=r"^cannot write b\.ply.*No space left on device.*room"):
        write(RESULT, [tmp_path / "a.vtp", tmp_path / "b.ply"])
    assert contents(tmp_path) == {"a.vtp": b"old"}


def test_a_folder_that_may_not_be_written_to(tmp_path, monkeypatch):
    """A folder without permission gives one line."""

    def refuse(path, *_):
        raise PermissionError(errno.EACCES, "Permission denied", os.fspath(path))

    monkeypatch.setattr(os, "open", refuse)
    with pytest.raises(FormatError, match=r"^cannot write a\.vtp.*Permission denied.*folder"):
        write(RESULT, tmp_path / "a.vtp")
    assert contents(tmp_path) == {}


@pytest.mark.parametrize("failing", [0, 1, 2])
def test_a_rename_that_fails_undoes_those_before_it(tmp_path, monkeypatch, failing):
    """A rename that fails undoes those before it."""
    (tmp_path / "a.vtk").write_text("old a")
    (tmp_path / "c.vtu").write_text("old c")
    rename, calls = os.replace, []

    def once(source, target):
        calls.append(target)
        if len(calls) == failing + 1:
            raise PermissionError(errno.EPERM, "Operation not permitted", os.fspath(source))
        rename(source, target)

    monkeypatch.setattr(os, "replace", once)
    with pytest.raises(FormatError, match="Operation not permitted"):
        write(RESULT, [tmp_path / name for name in NAMES[:3]])
    assert contents(tmp_path) == {"a.vtk": b"old a", "c.vtu": b"old c"}


def refused(paths, inputs=()) -> str:
    with pytest.raises(FormatError) as caught:
        check_outputs(paths, inputs)
    return str(caught.value)


def test_bad_outputs_are_named(tmp_path, monkeypatch):
    """Unknown extensions, missing folders, folders and duplicate outputs are refused."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder.vtp").mkdir()
    assert not missing(refused(["a.xyz"]), "cannot write a.xyz ... '.xyz' ... known are .vtk .vtp .vtu .ply")
    assert not missing(refused(["a"]), "cannot write a: ... no extension")
    assert "no folder none" in refused(["none/a.vtp"])
    assert not missing(refused(["folder.vtp"]), "folder.vtp ... it is a folder")
    assert "two of the outputs" in refused(["a.vtp", "b.vtp", f"{tmp_path}/a.vtp"])
    assert "two of the outputs" in refused(["a.vtp", "a.vtp"])
    with pytest.raises(FormatError, match="it is a folder"), replacing(["folder.vtp"]):
        pass


def test_an_input_is_never_an_output(tmp_path, monkeypatch):
    """An output that is an input, under any of its names, is refused."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "in.ply").write_text("ply")
    (tmp_path / "symbolic.ply").symlink_to("in.ply")
    os.link("in.ply", "hard.ply")
    for name in ["in.ply", "./in.ply", f"{tmp_path}/in.ply", "symbolic.ply", "hard.ply"]:
        assert not missing(refused([name], ["in.ply"]), f"cannot write {name} ... input in.ply")
    assert "two of the outputs" in refused(["in.ply", "hard.ply"])
    assert refused(["new.ply"], ["new.ply"])


@pytest.mark.parametrize("image", [np.zeros((4, 4, 3)), np.zeros((4, 4), np.uint8), np.zeros((0, 4, 3), np.uint8)])
def test_what_is_no_picture_is_refused(tmp_path, image):
    """An array that is no 8-bit RGB picture is refused."""
    with pytest.raises(FormatError, match="a picture must be"):
        write_png(tmp_path / "a.png", image)
    assert contents(tmp_path) == {}
