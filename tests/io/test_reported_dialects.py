"""Files as other programs write them: each gives its mesh with its remark, or the sentence that refuses it."""

import base64
import os
import zlib
from pathlib import Path

import numpy as np
import pytest
import pyvista

from geomhw.errors import FormatError
from geomhw.io import read, read_lines, read_series
from support.face_files import AREA, FACES, POINTS, WRITERS, check, obj, off, ply, stl, vtk
from support.messages import missing
from support.program import run
from support.stl_files import facets

SOLID = stl()
#: Name of a file, its contents, and vertices, triangles, area and remark; no vertices for a refusal.
DIALECTS: dict[str, tuple[str, bytes, tuple[int, int, float, str]]] = {
    "obj comment": ("m.obj", obj(head="# ends in \\\n").encode(), (4, 4, AREA, "")),
    "obj mtllib": ("m.obj", obj(head="mtllib a\\b\\\no c:\\\n").encode(), (4, 4, AREA, "")),
    "obj comment behind": ("m.obj", obj().replace("f 1 3 2", "f 1 3 2 # \\").encode(), (4, 4, AREA, "")),
    "obj continued": ("m.obj", obj().replace("f 1 3 2", "f 1 \\\n3 \\\n2").encode(), (4, 4, AREA, "")),
    "obj continued end": ("m.obj", obj()[:-1].encode() + b" \\", (4, 4, AREA, "")),
    "obj CRLF backslash": ("m.obj", obj(head="g a\\\r\n").encode(), (4, 4, AREA, "")),
    "obj some of two": ("m.obj", obj(["0 0", *POINTS[1:]]).encode(), (0, 0, 0, "line 1 ... 3 coordinates")),
    "off two": ("m.off", off(["0 0", "1 0", "0 1"], ["0 1 2"]).encode(), (3, 1, 0.5, "z is 0")),
    "ply two": (
        "m.ply",
        ply(["0 0", "1 0", "0 1"], ["0 1 2"]).replace("property float z\n", "").encode(),
        (3, 1, 0.5, "z is 0"),
    ),
    "off one line": ("m.off", off().replace("\n", " ").encode(), (4, 4, AREA, "")),
    "off a number a line": ("m.off", off().replace(" ", "\n").encode(), (4, 4, AREA, "")),
    "off normals on own lines": (
        "m.off",
        off([f"{point}\n0 0 1" for point in POINTS], head="NOFF").encode(),
        (4, 4, AREA, ""),
    ),
    **{
        f"off {head}": ("m.off", off([f"{p} {extra}" for p in POINTS], head=head).encode(), (4, 4, AREA, ""))
        for head, extra in {
            "CNOFF": "1 1 1 1 0 0 1", "NCOFF": "0 0 1 9 9 9 9", "NSTOFF": "0 0 1 .5 .5", "NCSTOFF": "0 0 1 9 9 9 9 0 0"
        }.items()
    },
    "off more lines": ("m.off", off(tail="9 9\n9\n").encode(), (4, 4, AREA, "2 lines ... line 11")),
    "off zero bytes": ("m.off", off().encode() + bytes(7), (4, 4, AREA, "7 bytes")),
    "off Ctrl-Z": ("m.off", off().encode() + b"\x1a", (4, 4, AREA, "1 bytes")),
    "ply more lines": ("m.ply", ply(tail="9 9 9\n").encode(), (4, 4, AREA, "1 line")),
    "ply words after": ("m.ply", ply(tail="end of file\n").encode(), (4, 4, AREA, "1 line")),
    "ply across lines": ("m.ply", ply().replace("1 0 0\n", "1\n0 0\n").encode(), (4, 4, AREA, "")),
    "ply more for vertices": ("m.ply", ply([f"{p} 7 8" for p in POINTS]).encode(), (4, 4, AREA, "8 numbers")),
    "ply zero bytes": ("m.ply", ply().encode() + bytes(2), (4, 4, AREA, "2 bytes")),
    "vtk numbers after": ("m.vtk", vtk(tail="1 2 3\n").encode(), (4, 4, AREA, "line 15")),
    "vtk small letters": (
        "m.vtk",
        vtk().replace("ASCII", "ascii").replace("DATASET POLYDATA", "dataset polydata")
        .replace("POINTS", "points").replace("POLYGONS", "polygons").encode(),
        (4, 4, AREA, ""),
    ),
    "vtk bits": ("m.vtk", vtk(tail="CELL_DATA 4\nSCALARS b bit\n1 0 1 1\n").encode(), (4, 4, AREA, "")),
    "vtk tensors": ("m.vtk", vtk(tail="POINT_DATA 4\nTENSORS t float\n" + "1 " * 36 + "\n").encode(), (4, 4, AREA, "")),
    "vtk variants": (
        "m.vtk", vtk(tail="FIELD f 2\nv 1 2 variant\n5 a b\n6 c\nw 1 1 int\n3\n").encode(), (4, 4, AREA, "'v'")
    ),
    "vtk strips and polygons": (
        "m.vtk", vtk(faces=FACES[2:], tail="TRIANGLE_STRIPS 1 5\n4 2 0 1 3\n").encode(), (4, 4, AREA, "")
    ),
    "stl BOM": ("m.stl", b"\xef\xbb\xbf" + SOLID.encode(), (4, 2, 1.0, "")),
    "stl blanks": ("m.stl", b"\r\n \t" + SOLID.encode(), (4, 2, 1.0, "")),
    "stl capitals": ("m.stl", SOLID.title().encode(), (4, 2, 1.0, "")),
    "stl one line": ("m.stl", SOLID.replace("\n", " ").encode(), (4, 2, 1.0, "")),
    "stl loops in a line": ("m.stl", SOLID.replace("loop\nvertex", "loop vertex").encode(), (4, 2, 1.0, "")),
    "stl two solids": ("m.stl", (SOLID + SOLID.replace("vertex ", "vertex 1")).encode(), (8, 4, 2.0, "")),
    "stl zero bytes": ("m.stl", SOLID.encode() + bytes(3), (4, 2, 1.0, "3 bytes")),
    "stl loop of four": (
        "m.stl",
        b"solid a\nfacet\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\nvertex 0 1 0\nendloop\nendfacet\n",
        (4, 2, 1.0, ""),
    ),
    "stl binary surplus": ("m.stl", facets(*np.eye(3)[None]) + b"Magics", (3, 1, 3**0.5 / 2, "6 bytes")),
    "stl binary short": ("m.stl", facets(*np.eye(3)[None])[:-9], (0, 0, 0, "1 triangles")),
    "stl thin facet": (
        "m.stl", facets(*np.eye(3)[None], np.array([[1, 0, 0], [1, 0, 0], [0, 1, 0]])), (3, 1, 3**0.5 / 2, "1 face")
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", DIALECTS)
def test_dialects(tmp_path: Path, name: str) -> None:
    """What other programs write is read, with a remark where something is left out."""
    file, data, right = DIALECTS[name]
    path = tmp_path / file
    path.write_bytes(data)
    check(path, *right)


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-le", "utf-16-be"])
@pytest.mark.parametrize("kind", [*WRITERS, "stl", "msh"])
def test_utf16_is_named(tmp_path: Path, kind: str, encoding: str) -> None:
    """Text in UTF-16 is refused by that name in every format."""
    path = tmp_path / f"m.{kind}"
    text = WRITERS[kind]() if kind in WRITERS else SOLID if kind == "stl" else "$MeshFormat\n2.2 0 8\n"
    path.write_bytes(text.encode(encoding))
    with pytest.raises(FormatError, match="UTF-16"):
        read(path)


@pytest.mark.parametrize("order", ["little", "big"])
def test_binary_off_with_colors(tmp_path: Path, order: str) -> None:
    """Binary OFF is big-endian, with colors of vertices and faces; another byte order is refused."""
    end = ">" if order == "big" else "<"
    points = np.array([[0, 0, 0, 1, 1, 1, 1], [1, 0, 0, 1, 1, 1, 1], [1, 1, 0, 1, 1, 1, 1], [0, 1, 0, 1, 1, 1, 1]])
    face = np.array([4, 0, 1, 2, 3, 3], end + "i4").tobytes() + np.array([1, 0, 0], end + "f4").tobytes()
    data = b"COFF BINARY\n" + np.array([4, 1, 0], end + "i4").tobytes() + points.astype(end + "f4").tobytes() + face
    path = tmp_path / "m.off"
    path.write_bytes(data)
    check(path, *((4, 2, 1.0, "") if order == "big" else (0, 0, 0, "vertices")))


@pytest.mark.parametrize("form", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_ply_strips(tmp_path: Path, form: str) -> None:
    """Triangle strips of PLY, several in a list, every second triangle turned."""
    strips = [0, 2, 1, 3, -1, 0, 3, 2]
    end = ">" if "big" in form else "<"
    points = np.array([row.split() for row in POINTS], end + "f4")
    head = f"ply\nformat {form} 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    head += "element tristrips 1\nproperty list int int vertex_indices\nend_header\n"
    binary = points.tobytes() + np.array([len(strips), *strips], end + "i4").tobytes()
    text = ("\n".join(POINTS) + f"\n{len(strips)} {' '.join(map(str, strips))}\n").encode()
    path = tmp_path / "m.ply"
    path.write_bytes(head.encode() + (text if form == "ascii" else binary))
    assert read(path).mesh.faces.tolist() == [[0, 2, 1], [3, 1, 2], [0, 3, 2]]


@pytest.mark.parametrize(
    ("strip", "faces", "remark"),
    [("4 0 1 2 3", [[0, 2, 1], [3, 1, 2]], "repeat"), ("3 0 1 3", [[0, 2, 1], [3, 1, 2], [0, 1, 3]], "label")],
)
def test_ply_faces_beside_strips(tmp_path: Path, strip: str, faces: list[list[int]], remark: str) -> None:
    """Strips that repeat the faces are left out; others are added, and arrays of faces are left out."""
    head = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    head += "element face 2\nproperty list uchar int vertex_indices\nproperty int label\n"
    head += "element tristrips 1\nproperty list int int vertex_indices\nend_header\n"
    path = tmp_path / "m.ply"
    path.write_text(head + "\n".join(POINTS) + f"\n3 0 2 1 7\n3 3 1 2 8\n{strip}\n")
    result = read(path)
    assert result.mesh.faces.tolist() == faces
    assert remark in " ".join(result.report["remarks"])
    assert len(result.fields) == (remark == "repeat")


@pytest.mark.parametrize("compression", ["lz4", "lzma", "zlib"])
@pytest.mark.parametrize("mode", ["appended", "binary"])
def test_compressed_vtp(tmp_path: Path, compression: str, mode: str) -> None:
    """Every compressor of VTK is read, in several blocks."""
    from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter

    surface = pyvista.Sphere(theta_resolution=90, phi_resolution=90)
    surface["noise"] = np.random.default_rng(1).random(surface.n_points)
    path, writer = tmp_path / "m.vtp", vtkXMLPolyDataWriter()
    writer.SetInputData(surface)
    writer.SetFileName(str(path))
    getattr(writer, f"SetCompressorTypeTo{compression.upper() if compression != 'zlib' else 'ZLib'}")()
    getattr(writer, f"SetDataModeTo{mode.title()}")()
    writer.Write()
    result = read(path)
    np.testing.assert_array_equal(result.mesh.vertices, surface.points)
    np.testing.assert_array_equal(result["noise"], surface["noise"])


def xml(pieces: str, kind: str = "PolyData", head: str = "") -> bytes:
    return f'<VTKFile type="{kind}" {head}><{kind}>{pieces}</{kind}></VTKFile>'.encode()


def piece(shift: int, values: str = "1 2", cells: str = "Polys") -> str:
    points = f"{shift} 0 0 {shift + 1} 0 0 {shift + 1} 1 0 {shift} 1 0"
    offsets, corners = ("4", "0 1 3 2") if cells == "Strips" else ("3 6", "0 1 2 0 2 3")
    values = values if cells == "Polys" else "7"
    return (
        f'<Piece NumberOfPoints="4"><CellData><DataArray type="Int32" Name="a">{values}</DataArray></CellData><Points>'
        f'<DataArray type="Float64" NumberOfComponents="3">{points}</DataArray></Points><{cells}>'
        f'<DataArray type="Int32" Name="connectivity">{corners}</DataArray>'
        f'<DataArray type="Int32" Name="offsets">{offsets}</DataArray></{cells}></Piece>'
    )


def test_several_pieces(tmp_path: Path) -> None:
    """Pieces are joined with their arrays; strips count once among the rows."""
    path = tmp_path / "m.vtp"
    path.write_bytes(xml(piece(0) + piece(5, "3 4") + piece(9, cells="Strips")))
    result = read(path)
    check(path, 12, 6, 3.0, "")
    assert result["a"].tolist() == [1, 2, 3, 4, 7, 7]
    path.write_bytes(xml(piece(0)) + b"\0\0\n")
    check(path, 4, 2, 1.0, "2 bytes")


def test_unpacked_size_is_checked_before_unpacking(tmp_path: Path) -> None:
    """An array that would unpack to another size than its rows is refused."""
    block = zlib.compress(bytes(1 << 20))
    head = np.array([1000, 1 << 20, 0, *[len(block)] * 1000], "<u4").tobytes()
    coded = base64.b64encode(head) + base64.b64encode(block * 1000)
    text = piece(0).replace("1 2<", coded.decode() + "<").replace('Name="a"', 'Name="a" format="binary"')
    path = tmp_path / "m.vtp"
    path.write_bytes(xml(text, head='compressor="vtkZLibDataCompressor"'))
    check(path, 0, 0, 0, "'a' ... rows ... 2")


@pytest.mark.parametrize("filler", [b"a", b">", b"a\n", b"a='b' "])
def test_long_tags_of_xml_are_refused(tmp_path: Path, filler: bytes) -> None:
    """A tag of megabytes is refused before it is parsed, wherever it hides."""
    for data in (b'<VTKFile type="' + filler * 100_000 + b'">', b"<VTKFile " + filler * 100_000 + b"/>"):
        path = tmp_path / "m.vtp"
        path.write_bytes(data)
        with pytest.raises(FormatError, match=r"m\.vtp .*(tag|whole)"):
            read(path)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no named pipes")
def test_only_regular_files_are_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Named pipes and devices are refused at once, from wherever they are named."""
    monkeypatch.chdir(tmp_path)
    Path("m.off").write_text(off())
    os.mkfifo("pipe")
    for name in ("p.off", "p.msh", "p.vtp", "p.npz", "p.npy", "p.csv", "p.json", "p.pvd"):
        Path(name).symlink_to("pipe")
    Path("z.vtp").symlink_to("/dev/zero")
    Path("z.pvd").write_text('<VTKFile><Collection><DataSet timestep="0" file="z.vtp"/></Collection></VTKFile>')
    for arguments, words in {
        ("info", "p.off"): "named pipe",
        ("info", "p.msh"): "named pipe",
        ("geodesic", "p.vtp"): "named pipe",
        ("info", "z.vtp"): "device",
        ("geodesic", "m.off", "--source", "@pipe"): "named pipe",
        ("advect", "m.off", "--color", "p.npy"): "no regular file",
        ("advect", "m.off", "--color", "p.csv:u"): "no regular file",
        ("fluid", "m.off", "--restart", "p.npz"): "named pipe",
        ("compare", "p.json", "p.json"): "named pipe",
        ("compare", "z.pvd", "z.pvd"): "device",
    }.items():
        answer = run(*arguments)
        assert answer.exit_code in (1, 2)
        assert words in answer.stderr
    with pytest.raises(FormatError, match="named pipe"):
        read_series("p.pvd")
    with pytest.raises(FormatError, match="named pipe"):
        read_lines("pipe")


def test_remarks_are_printed(tmp_path: Path) -> None:
    """Remarks of the reader are notes of every command, and in the JSON report."""
    path = tmp_path / "m.off"
    path.write_text(off(faces=[*FACES, "0 1"]))
    assert "1 face with fewer" in run("info", str(path)).stdout
    answer = run("geodesic", str(path), "--no-png", "-o", str(tmp_path / "a.vtk"))
    assert not missing(answer.stdout, "note ... 1 face with fewer than three")
