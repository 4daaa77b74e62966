"""Files that cannot be opened or parsed give one line; meshio neither prints nor exits."""

import os
import sys
import time

import meshio
import numpy as np
import pytest

from geomhw.errors import FormatError, GeomhwError, MeshError
from geomhw.io import READABLE, read, read_mesh
from geomhw.io.formats.meshio_worker import extract
from support.messages import missing
from support.stl_files import POINTS, facets


def message(path) -> str:
    with pytest.raises(GeomhwError) as caught:
        read(path)
    return str(caught.value)


@pytest.mark.parametrize("extension", READABLE)
def test_files_that_cannot_be_opened(tmp_path, extension):
    """Missing files, empty files and folders give one line with the path."""
    path = tmp_path / f"moo{extension}"
    assert not missing(message(path), f"{path} ... no such file")
    path.touch()
    assert not missing(message(path), f"{path} ... empty file")
    path.unlink()
    path.mkdir()
    assert not missing(message(path), f"{path} ... cannot be read ... it is a folder")


def test_extensions(tmp_path):
    """Unknown extensions are refused with the known ones; the case of letters does not matter."""
    assert not missing(message(tmp_path / "moo.xyz"), "'.xyz' ... known are .off .obj")
    assert not missing(message(tmp_path / "moo"), "no extension ... known are .off .obj")
    (tmp_path / "MOO.OFF").write_text("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
    assert read_mesh(str(tmp_path / "MOO.OFF")).n_faces == 1


def test_no_permission(tmp_path, monkeypatch):
    """A file without permission gives one line."""

    def refuse(self, mode):
        raise PermissionError(13, "Permission denied", os.fspath(self))

    (tmp_path / "moo.off").touch()
    monkeypatch.setattr("pathlib.Path.open", refuse)
    assert not missing(message(tmp_path / "moo.off"), "moo.off ... cannot be read ... permission denied")


@pytest.mark.parametrize("extension", READABLE)
@pytest.mark.parametrize("data", [b"\0\xff\x80" * 50, b"hello world\n1 2 3\n", b"solid\n", b"$MeshFormat\n4.1 0 8\n"])
def test_rubbish_is_one_quiet_sentence(tmp_path, capfd, extension, data):
    """Random bytes in each format give one line, and nothing is printed."""
    path = tmp_path / f"moo{extension}"
    path.write_bytes(data)
    said = message(path)
    assert path.name in said
    assert "\n" not in said
    assert capfd.readouterr() == ("", "")


def test_meshio_that_exits_is_caught(tmp_path, capfd, monkeypatch):
    """When meshio prints and exits, neither reaches the caller."""

    def leave(*_):
        print("chatter")
        print("chatter", file=sys.stderr)
        sys.exit(1)

    monkeypatch.setattr(meshio, "read", leave)
    (tmp_path / "moo.msh").write_text("$Nodes\n")
    with pytest.raises(FormatError, match=r"^moo\.msh cannot be read as Gmsh$"):
        extract(tmp_path / "moo.msh", "Gmsh")
    assert capfd.readouterr() == ("", "")


def test_meshio_that_finds_no_end_is_ended(tmp_path):
    """meshio's Nastran reader loops at the end of some files; it is stopped after 1 s of computing."""
    (tmp_path / "moo.bdf").write_text("BEGIN BULK\n")
    submit = time.monotonic()
    told = message(tmp_path / "moo.bdf")
    assert time.monotonic() - submit < 30
    assert not missing(told, "moo.bdf cannot be read as Nastran ... after 1 s")


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="limits on memory are Linux's")
def test_meshio_that_asks_for_all_memory_gets_none(tmp_path):
    """A header that promises 2⁴⁰ points gets no memory."""
    (tmp_path / "moo.mesh").write_text(f"MeshVersionFormatted 2\nDimension 3\nVertices\n{2**40}\n0 0 0 0\n")
    assert message(tmp_path / "moo.mesh").startswith("moo.mesh cannot be read as Medit: ")


def test_volumes_and_lines_are_refused(tmp_path):
    """Volume cells and lines without faces are refused."""
    path = tmp_path / "moo.mesh"
    meshio.Mesh(POINTS, [("tetra", [[0, 1, 2, 3]])]).write(path)
    assert not missing(message(path), "moo.mesh ... volume cells (tetra) ... no faces")
    meshio.Mesh(POINTS, [("line", [[0, 1]])]).write(path)
    assert not missing(message(path), "moo.mesh ... no triangles or polygons ... only line")


def test_stl_errors(tmp_path):
    """Each kind of damaged STL file is refused with its reason."""
    path = tmp_path / "moo.stl"
    one = facets(POINTS[:3])
    for data, part in {
        b"\x01" * 50: "'solid' ... header of 84 bytes",
        one.replace(b"solid", b"SOLUS")[:-10]: "1 triangles ... 0.8",
        facets(): "holds no triangles",
        b"solid x\nendsolid\n": "holds no triangles",
        b"solid x\nvertex 0 0 0\nvertex 1 0 0\n": "line 2 ... 2 corners",
        b"solid x\nvertex 0 0 0\nvertex 1 zero 0\n": "line 3 ... 'zero' is not a number",
        facets([[0, 0, 0], [np.nan, 0, 0], [0, 1, 0]]): "vertex 1 ... not a finite number",
        facets(POINTS[[0, 1, 1]]): "face 0",
    }.items():
        path.write_bytes(data)
        assert not missing(message(path), f"moo.stl ... {part}")


def test_what_the_mesh_refuses_has_the_file_in_front(tmp_path):
    """An error of the mesh names the file first."""
    path = tmp_path / "moo.stl"
    path.write_bytes(facets([[0, 0, 0], [np.inf, 0, 0], [0, 1, 0]]))
    with pytest.raises(MeshError, match=r"^moo\.stl: vertex 1"):
        read(path)


STRANGERS = {
    "gzip": (b"\x1f\x8b\x08\0", "compressed"),
    "zip": (b"PK\x03\x04", "archive"),
    "LFS": (b"version https://git-lfs.github.com/spec/v1\n", "LFS"),
    "HTML": (b"\n<!DOCTYPE html>\n", "HTML"),
}


@pytest.mark.parametrize("kind", STRANGERS)
@pytest.mark.parametrize("extension", READABLE)
def test_other_files_under_the_name_of_a_mesh(tmp_path, extension, kind):
    """Compressed files, archives, pointers and pages under the extension of a mesh are named as what they are."""
    start, word = STRANGERS[kind]
    path = tmp_path / f"moo{extension}"
    path.write_bytes(start + b"oid sha256:0123456789\n" * 20)
    assert word in message(path)


def test_compressed_extensions(tmp_path):
    """A compressed file is named as one by its extension."""
    assert "compressed" in message(tmp_path / "moo.off.gz")


@pytest.mark.parametrize("extension", READABLE)
def test_names_that_are_too_long(tmp_path, extension):
    """A name that is too long gives one line that does not speak of writing."""
    text = message(tmp_path / ("a" * 300 + extension))
    assert "too long" in text
    assert "write" not in text
