"""Meshes, arrays, tables and series of hypothesis read back to the last bit."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from geomhw.io import read, read_mesh, write
from geomhw.io.artifacts.checkpoints import read_checkpoint, write_checkpoint
from geomhw.io.artifacts.matrices import UNNAMED, read_arrays, write_matrix
from geomhw.io.artifacts.series import SeriesWriter, read_series
from geomhw.io.artifacts.tables import read_csv, write_csv
from geomhw.mesh.primitives import grid, icosphere, strip, torus
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.options import Location
from geomhw.results import Field, Result
from support.meshes import ZOO, annulus
from support.program import save_off

BASES = [ZOO["tetrahedron"](), icosphere(1), torus(7, 5), grid(4, 3), strip(5), annulus()]

TYPES = ["<f8", "<f4", "i1", "u1", "<i2", "<u2", "<i4", "<u4", "<i8", "<u8"]
coordinates = st.floats(allow_nan=False, allow_infinity=False)
names = st.text(st.characters(blacklist_categories=("Cs", "Cc", "Zl", "Zp")), min_size=1, max_size=9)


@st.composite
def results(draw: st.DrawFn, types: Sequence[str] = TYPES, texts: st.SearchStrategy[str] = names) -> Result:
    """Any faces over finite points, with arrays of any type and one to four components at all locations."""
    n = draw(st.integers(3, 9))
    points = draw(arrays.arrays(np.float64, (n, 3), elements=coordinates))
    corners = st.lists(st.integers(0, n - 1), min_size=3, max_size=3, unique=True)
    mesh = TriangleMesh(points, draw(st.lists(corners, min_size=1, max_size=7)))
    fields = []
    places: list[tuple[Location, int]] = [("vertex", n), ("face", mesh.n_faces), ("mesh", draw(st.integers(1, 4)))]
    for place, rows in places:
        for name in draw(st.lists(texts, max_size=3, unique_by=str.strip)):
            width = draw(st.sampled_from([None, 2, 3, 4]))
            kind = draw(st.sampled_from(types))
            values = draw(arrays.arrays(kind, (rows,) if width is None else (rows, width)))
            fields.append(Field(name, place, values))
    return Result(mesh, fields)


def assert_same(found: Result, made: Result) -> None:
    """Check that mesh and fields are equal to the last bit, NaN included."""
    assert found.mesh.vertices.tobytes() == made.mesh.vertices.tobytes()
    np.testing.assert_array_equal(found.mesh.faces, made.mesh.faces)
    there = {(field.name, field.location): np.asarray(field.values) for field in found.fields}
    assert there.keys() == {(field.name, field.location) for field in made.fields}
    for field in made.fields:
        np.testing.assert_array_equal(there[field.name, field.location], field.values)


@pytest.mark.parametrize("extension", ["vtk", "vtp", "vtu"])
@given(results())
def test_vtk_files(tmp_path_factory: pytest.TempPathFactory, extension: str, made: Result) -> None:
    """Everything written to VTK files is read back."""
    path = tmp_path_factory.mktemp("files") / f"a.{extension}"
    write(made, path)
    assert_same(read(path), made)


@given(results(["<f8", "i1", "u1", "<i2", "<u2", "<i4", "<u4"], st.text("abcdefgh", min_size=1, max_size=5)))
def test_ply_files(tmp_path_factory: pytest.TempPathFactory, made: Result) -> None:
    """Everything but mesh arrays, and arrays of two or four components, is read back from PLY files."""
    path = tmp_path_factory.mktemp("files") / "a.ply"
    kept = [field for field in made.fields if field.location != "mesh" and np.shape(field.values)[1:] in ((), (3,))]
    made = Result(made.mesh, kept)
    write(made, path)
    assert_same(read(path), made)


@given(results())
def test_text_files(tmp_path_factory: pytest.TempPathFactory, made: Result) -> None:
    """Coordinates written with their shortest digits are read back exactly."""
    folder = tmp_path_factory.mktemp("files")
    mesh = made.mesh
    rows = [f"v {x!r} {y!r} {z!r}\n" for x, y, z in mesh.vertices.tolist()]
    rows += [f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in mesh.faces.tolist()]
    (folder / "a.obj").write_text("".join(rows))
    save_off(mesh, str(folder / "a.off"))
    for name in ("a.obj", "a.off"):
        assert_same(Result(read_mesh(folder / name)), Result(mesh))


numbers = st.one_of(st.floats(), st.integers(-(10**17), 10**17))


@given(st.lists(st.tuples(numbers, numbers), min_size=1, max_size=9))
def test_tables(tmp_path_factory: pytest.TempPathFactory, rows: list[tuple[float, float]]) -> None:
    """Numbers of tables are read back, with NaN and infinities."""
    path = tmp_path_factory.mktemp("files") / "a.csv"
    write_csv(path, [{"a": a, "b, c": b} for a, b in rows])
    found = read_csv(path)
    for name, column in zip(("a", "b, c"), zip(*rows, strict=True), strict=True):
        np.testing.assert_array_equal(found[name], np.array(column))


@pytest.mark.parametrize("extension", ["npz", "mtx"])
@given(arrays.arrays(np.float64, st.tuples(st.integers(1, 6), st.integers(1, 6)), elements=coordinates))
def test_matrices(tmp_path_factory: pytest.TempPathFactory, extension: str, dense: np.ndarray) -> None:
    """Nonzero entries of matrices are read back exactly."""
    path = tmp_path_factory.mktemp("files") / f"a.{extension}"
    write_matrix(path, sp.csr_array(dense))
    np.testing.assert_array_equal(read_arrays(path)[UNNAMED].toarray(), dense)


@given(
    arrays.arrays(st.sampled_from(TYPES), arrays.array_shapes(max_dims=3, max_side=4)), st.dictionaries(names, numbers)
)
def test_states(tmp_path_factory: pytest.TempPathFactory, values: np.ndarray, description: dict[str, float]) -> None:
    """Arrays and description of a checkpoint are read back."""
    path = tmp_path_factory.mktemp("files") / "a.npz"
    write_checkpoint(path, description, {"values": values})
    told, found = read_checkpoint(path)
    assert found["values"].dtype == values.dtype
    np.testing.assert_array_equal(found["values"], values)
    np.testing.assert_equal(told, description)


@given(names.filter(lambda name: "/" not in name and name.strip(" .")), st.lists(coordinates, min_size=1, max_size=4))
def test_series(tmp_path_factory: pytest.TempPathFactory, name: str, times: list[float]) -> None:
    """Times of a series are read back exactly, under any file name."""
    path = tmp_path_factory.mktemp("files") / f"{name}.pvd"
    writer = SeriesWriter(path)
    for time in times:
        writer.add(time, Result(BASES[0]))
    frames = read_series(path)
    assert [frame.time for frame in frames] == times
    assert all((Path(path.parent) / frame.file).exists() for frame in frames)
