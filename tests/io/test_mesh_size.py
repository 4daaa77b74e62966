"""Numbers of vertices and faces from the first bytes of a file are those of the mesh."""

from pathlib import Path

import numpy as np
import pytest

from geomhw.errors import GeomhwError
from geomhw.io import mesh_size, read_mesh, write
from geomhw.io.mesh_size import HEAD, MeshSize
from geomhw.mesh.primitives import icosphere
from geomhw.results import Result
from support.program import save_off

BALL = icosphere(2)
V, F = BALL.vertices, BALL.faces


def binary_off() -> bytes:
    """Return the binary form of an OFF file."""
    faces = np.column_stack([np.full(len(F), 3), F, np.zeros(len(F), int)]).astype(">i4")
    return (
        b"OFF BINARY\n" + np.array([len(V), len(F), 0], ">i4").tobytes() + V.astype(">f4").tobytes() + faces.tobytes()
    )


def binary_stl() -> bytes:
    """Return the binary form of an STL file whose title begins like a text."""
    facet = np.zeros(len(F), np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")]))
    facet["corners"] = V[F]
    return b"solid of a program".ljust(80) + np.uint32(len(F)).tobytes() + facet.tobytes()


def freesurfer() -> bytes:
    """Return a surface of triangles."""
    head = b"\xff\xff\xfecreated by nobody\n\n" + np.array([len(V), len(F)], ">i4").tobytes()
    return head + V.astype(">f4").tobytes() + F.astype(">i4").tobytes()


FILES = {"binary.off": binary_off, "binary.stl": binary_stl, "lh.white": freesurfer}
WRITTEN = ["ball.off", "ball.ply", "ball.vtp", "ball.vtu", "ball.vtk", "ball.gii", "ball.glb", *FILES]


@pytest.fixture(params=WRITTEN)
def path(request: pytest.FixtureRequest, folder: Path) -> Path:
    """Write the ball in a format."""
    file = folder / request.param
    if request.param in FILES:
        file.write_bytes(FILES[request.param]())
    elif file.suffix == ".off":
        save_off(BALL, str(file))
        file.write_text(f"# a comment of 9 9 9\n{file.read_text().replace('OFF', 'OFF # and 7 7', 1)}")
    else:
        write(Result(BALL), [file])
    return file


def test_counts_are_those_of_the_mesh(path: Path) -> None:
    """Both counts, without the rest of the file."""
    mesh = read_mesh(path)
    expected = MeshSize(mesh.n_vertices, mesh.n_faces, "header")
    assert (mesh.n_vertices, mesh.n_faces) == (len(V), len(F))
    assert mesh_size(path) == expected
    if path.suffix not in (".glb", ".gii", ".stl"):  # of glTF, the header is all the JSON; of STL, the size tells text
        path.write_bytes(path.read_bytes()[:600])
        assert mesh_size(path) == expected


def test_any_first_bytes(path: Path) -> None:
    """Files that end early, and changed bytes, give counts or an error, and positive ones."""
    data, rng = path.read_bytes(), np.random.default_rng(0)
    for k in range(200):
        changed = bytearray(data[: int(rng.integers(1, 500))] if k % 2 else data)
        changed[int(rng.integers(len(changed)))] = int(rng.integers(256))
        path.write_bytes(changed)
        try:
            size = mesh_size(path)
        except GeomhwError:
            continue
        assert size.vertices >= 0 <= size.faces


def test_formats_without_counts(folder: Path) -> None:
    """The file size gives the number of vertices of an OBJ, within a factor of two, and says so."""
    lines = [*("v {:.6f} {:.6f} {:.6f}".format(*v) for v in V), *(f"f {a} {b} {c}" for a, b, c in F + 1)]
    Path("ball.obj").write_text("\n".join(lines))
    size = mesh_size("ball.obj")
    assert size.source == "file size"
    assert len(V) / 2 < size.vertices < 2 * len(V)


def test_nothing_beyond_the_first_bytes_is_read(folder: Path) -> None:
    """A file of 10 GB that is all hole but for its header."""
    with Path("huge.ply").open("wb") as stream:
        stream.write(b"ply\nformat binary_little_endian 1.0\nelement vertex 200000000\nproperty float x\n")
        stream.write(b"element face 400000000\nproperty list uchar int vertex_indices\nend_header\n")
        stream.truncate(10**10)
    assert mesh_size("huge.ply") == MeshSize(200_000_000, 400_000_000, "header")
    assert HEAD <= 1 << 16
