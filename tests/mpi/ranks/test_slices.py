"""Files that are read in slices: each format, no rank with the whole mesh, and files that cannot be sliced."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import pyvista

from geomhw.distributed import LocalResult, distribute, distributed_distance, off_slices, open_sliced, write_distributed
from geomhw.errors import FormatError, MeshError
from geomhw.io import read_mesh, write
from geomhw.mesh import TriangleMesh
from geomhw.mesh.primitives import icosphere
from geomhw.results import Result
from support.off_files import SAME
from support.rank_meshes import RANKS, in_order

BALL = icosphere(3)


def text_off(mesh: TriangleMesh, path: Path) -> None:
    rows = [" ".join(map(repr, point)) for point in mesh.vertices.tolist()]
    rows += [" ".join(map(str, [3, *face])) for face in mesh.faces.tolist()]
    path.write_text("\n".join([f"OFF # a ball\n\n{mesh.n_vertices} {mesh.n_faces} 0", *rows]))


def binary_off(mesh: TriangleMesh, path: Path, colors: int = 0) -> None:
    faces = np.zeros((mesh.n_faces, 5 + colors), dtype=">i4")
    faces[:, 0], faces[:, 1:4], faces[:, 4] = 3, mesh.faces, colors
    counts = np.array([mesh.n_vertices, mesh.n_faces, 0], dtype=">i4").tobytes()
    path.write_bytes(b"OFF BINARY\n" + counts + mesh.vertices.astype(">f4").tobytes() + faces.tobytes())


def ply(mesh: TriangleMesh, path: Path) -> None:
    write(Result(mesh), path)


def vtk(mesh: TriangleMesh, path: Path) -> None:
    """Write by VTK: appended raw bytes, 32-bit heads, without compression."""
    from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter, vtkXMLUnstructuredGridWriter

    surface = pyvista.PolyData.from_regular_faces(mesh.vertices, mesh.faces)
    surface["height"] = mesh.vertices[:, 2]
    is_grid = path.suffix == ".vtu"
    writer = vtkXMLUnstructuredGridWriter() if is_grid else vtkXMLPolyDataWriter()
    writer.SetInputData(surface.cast_to_unstructured_grid() if is_grid else surface)
    writer.SetFileName(str(path))
    writer.SetDataModeToAppended()
    writer.EncodeAppendedDataOff()
    writer.SetCompressorTypeToNone()
    writer.Write()


FORMATS: dict[str, Any] = {
    "a.ply": ply,
    "text.off": text_off,
    "binary.off": binary_off,
    "colors.off": lambda mesh, path: binary_off(mesh, path, 3),
    "a.vtu": vtk,
    "a.vtp": vtk,
}


@pytest.fixture
def short_chunks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Chunks of text far below the size of the file."""
    monkeypatch.setattr(off_slices, "CHUNK", 1000)


@pytest.mark.usefixtures("short_chunks")
@pytest.mark.parametrize("name", FORMATS)
def test_formats(name: str, folder: Path) -> None:
    """Any range of rows is that of the whole file; each rank reads and has its share."""
    if RANKS.rank == 0:
        FORMATS[name](BALL, folder / name)
    RANKS.comm.Barrier()
    whole = read_mesh(folder / name)
    file = open_sliced(RANKS, folder / name)
    assert (file.n_vertices, file.n_faces) == (BALL.n_vertices, BALL.n_faces)
    for begin, end in [(0, 3), (17, 300), (300, 302), (600, 642), (0, 642)]:
        assert np.array_equal(file.read_vertices(begin, end), whole.vertices[begin:end])
        assert np.array_equal(file.read_faces(2 * begin, 2 * end - 4), whole.faces[2 * begin : 2 * end - 4])
    read = {"vertices": 0, "faces": 0}

    class Counting(type(file)):  # type: ignore[misc]
        def read_vertices(self, begin: int, end: int) -> Any:
            read["vertices"] += end - begin
            return super().read_vertices(begin, end)

        def read_faces(self, begin: int, end: int) -> Any:
            read["faces"] += end - begin
            return super().read_faces(begin, end)

    file.__class__ = Counting
    mesh = distribute(RANKS, file)
    assert read["vertices"] <= BALL.n_vertices / RANKS.size + 1
    assert read["faces"] <= BALL.n_faces / RANKS.size + 1
    assert RANKS.sum(mesh.n_own) == BALL.n_vertices
    border = 8 * np.sqrt(BALL.n_vertices) if RANKS.size > 1 else 0
    assert len(mesh.faces) <= BALL.n_faces / RANKS.size + 2 * border
    assert np.array_equal(in_order(mesh, mesh.part.vertices), whole.vertices)


@pytest.mark.usefixtures("short_chunks")
@pytest.mark.parametrize("dialect", SAME)
def test_off_dialects(dialect: str, folder: Path) -> None:
    """Every dialect of OFF that is read at once is read in slices, or refused with the remedy."""
    path = folder / "moo.off"
    if RANKS.rank == 0:
        path.write_bytes(SAME[dialect].encode())
    RANKS.comm.Barrier()
    if dialect in ("old Macintosh", "quad"):
        with pytest.raises(FormatError, match="binary PLY"):
            open_sliced(RANKS, path).read_faces(0, 1)
        return
    whole, file = read_mesh(path), open_sliced(RANKS, path)
    assert np.array_equal(file.read_vertices(0, 4), whole.vertices)
    assert np.array_equal(file.read_faces(0, 2), whole.faces)


def test_own_gathered_file(folder: Path) -> None:
    """A file that ranks have gathered is read in slices again."""
    for name in ("a.ply", "a.vtu"):
        if name == "a.ply" and RANKS.rank == 0:
            ply(BALL, folder / name)
        RANKS.comm.Barrier()
        mesh = distribute(RANKS, open_sliced(RANKS, folder / name))
        found = distributed_distance(mesh, np.array([7]))
        write_distributed(LocalResult(mesh, found.fields), [folder / "a.vtu"])
        assert found.report["farthest"]["vertex"] == BALL.vertices.dot(BALL.vertices[7]).argmin()


DAMAGES = ["short", "short header", "vertex", "quad", "nan"]


@pytest.mark.parametrize("damage", DAMAGES)
@pytest.mark.parametrize("name", ["text.off", "binary.off", "a.vtu", "a.vtp"])
def test_damage(name: str, damage: str, folder: Path) -> None:
    """All ranks raise the same error of one sentence."""
    path = folder / name
    if RANKS.rank == 0:
        points, faces = BALL.vertices.copy(), BALL.faces.copy()
        broken = object.__new__(TriangleMesh)
        if damage == "vertex":
            faces[100, 1] = 5000
        if damage == "nan":
            points[40] = np.nan
        object.__setattr__(broken, "vertices", points)
        object.__setattr__(broken, "faces", faces)
        FORMATS[name](BALL if name.startswith("a.") else broken, path)
        data = path.read_bytes()
        if name.startswith("a."):
            data = data.replace(BALL.vertices[40].tobytes(), points[40].tobytes())
            kind = np.int64 if BALL.faces[100].astype(np.int64).tobytes() in data else np.int32
            data = data.replace(BALL.faces[100].astype(kind).tobytes(), faces[100].astype(kind).tobytes())
        if damage.startswith("short"):
            data = data[: len(data) * 9 // 10] if damage == "short" else data[:15]
        if damage == "quad" and name == "text.off":
            data = data.replace(b"\n3 ", b"\n2 ", 1)
        elif damage == "quad" and name == "binary.off":
            start = len(data) - 20 * 700
            data = data[:start] + b"\0\0\0\4" + data[start + 4 :]
        elif damage == "quad":
            kind = np.int64 if np.int64(3 * 702).tobytes() + np.int64(3 * 703).tobytes() in data else np.int32
            ends = (3 * np.arange(702, 704)).astype(kind)
            data = data.replace(ends.tobytes(), (ends + np.array([1, 0])).astype(kind).tobytes())
        path.write_bytes(data)
    RANKS.comm.Barrier()
    with pytest.raises((FormatError, MeshError)) as error:
        distribute(RANKS, open_sliced(RANKS, path))
    assert len(set(RANKS.comm.allgather(str(error.value)))) == 1
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("kind", ["compressed", "base64", "text", "inline", "two pieces"])
def test_unsliceable_vtk(kind: str, folder: Path) -> None:
    """VTK files of other encodings are refused with the remedy."""
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridWriter

    path = folder / "a.vtu"
    if RANKS.rank == 0:
        writer = vtkXMLUnstructuredGridWriter()
        grid = pyvista.PolyData.from_regular_faces(BALL.vertices, BALL.faces).cast_to_unstructured_grid()
        writer.SetInputData(grid)
        writer.SetFileName(str(path))
        if kind != "compressed":
            writer.SetCompressorTypeToNone()
        if kind != "base64":
            writer.EncodeAppendedDataOff()
        if kind == "text":
            writer.SetDataModeToAscii()
        elif kind == "inline":
            writer.SetDataModeToBinary()
        if kind == "two pieces":
            writer.SetNumberOfPieces(2)
        writer.Write()
    RANKS.comm.Barrier()
    with pytest.raises(FormatError, match=r"slices.*binary PLY"):
        distribute(RANKS, open_sliced(RANKS, path))
