"""Identities and invariances on meshes and fields that hypothesis makes up; what is written comes back."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp
from conftest import ZOO, annulus
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from test_commands import save_off

from geomhw.flow.helmholtz import HelmholtzDecomposition
from geomhw.flow.initial_fields import random_field
from geomhw.flow.tangent_fields import energy
from geomhw.fluid.conservative import ConservativeScheme
from geomhw.fluid.run import Plan, run
from geomhw.geodesic.heat_method import heat_distance
from geomhw.io import (
    SeriesWriter,
    read,
    read_checkpoint,
    read_csv,
    read_mesh,
    read_series,
    write,
    write_checkpoint,
    write_csv,
)
from geomhw.io.artifacts.matrices import UNNAMED, read_arrays, write_matrix
from geomhw.mesh.primitives import grid, icosphere, strip, torus
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.connection_laplacian import connection_stiffness
from geomhw.operators.divergence import divergence
from geomhw.operators.gradient import gradient
from geomhw.operators.laplacian import stiffness
from geomhw.operators.mass import lumped_mass
from geomhw.options import Location
from geomhw.results import Field, Result
from geomhw.transport.vector_heat import VectorHeat, random_tangent

seeds = st.integers(0, 2**32 - 1)
BASES = [ZOO["tetrahedron"](), icosphere(1), torus(7, 5), grid(4, 3), strip(5), annulus()]
CLOSED = [icosphere(1), torus(9, 6)]


@st.composite
def surfaces(draw: st.DrawFn, bases: Sequence[TriangleMesh] = BASES, shake: float = 0.25) -> TriangleMesh:
    """A small surface, every vertex shaken by up to a quarter of an edge, turned, scaled and moved."""
    base = draw(st.sampled_from(bases))
    chance = np.random.default_rng(draw(seeds))
    moved = base.vertices + shake * base.mean_edge_length * chance.uniform(-1, 1, base.vertices.shape)
    size = 10.0 ** draw(st.integers(-6, 6))
    return TriangleMesh(size * (moved + chance.normal(size=3)), base.faces)


@st.composite
def rotations(draw: st.DrawFn) -> np.ndarray:
    """A rotation matrix."""
    Q, R = np.linalg.qr(np.random.default_rng(draw(seeds)).normal(size=(3, 3)))
    Q *= np.sign(np.diag(R))
    return Q * np.sign(np.linalg.det(Q))


# -- operators and methods --------------------------------------------------------------------------------------------


@given(surfaces())
def test_operators(mesh: TriangleMesh) -> None:
    """Div G = -S; S is symmetric, positive semidefinite and constants are in its kernel; areas add up."""
    S, scale = stiffness(mesh), abs(stiffness(mesh)).max()
    assert abs(divergence(mesh) @ gradient(mesh) + S).max() < 1e-12 * scale
    assert abs(S - S.T).max() == 0
    assert np.linalg.eigvalsh(S.toarray()).min() > -1e-12 * scale
    assert np.abs(S @ np.ones(mesh.n_vertices)).max() < 1e-12 * scale
    assert lumped_mass(mesh).sum() == pytest.approx(mesh.face_areas.sum(), rel=1e-13)


@given(surfaces(CLOSED))
def test_connection(mesh: TriangleMesh) -> None:
    """Symmetric, and positive semidefinite on the edges' weights if those are not negative."""
    C = connection_stiffness(mesh)
    scale = abs(C).max()
    assert abs(C - C.T).max() < 1e-12 * scale
    weights = -sp.triu(stiffness(mesh), 1).data
    if weights.min() >= 0:
        assert np.linalg.eigvalsh(C.toarray()).min() > -1e-12 * scale


@given(surfaces(), rotations(), st.integers(-8, 8), seeds)
def test_distance_is_that_of_the_surface(mesh: TriangleMesh, Q: np.ndarray, power: int, seed: int) -> None:
    """Renumbering vertices and faces, a rigid motion and a change of units change numbers as they should."""
    chance = np.random.default_rng(seed)
    size, source = 10.0**power, int(chance.choice(mesh.faces.ravel()))
    names = chance.permutation(mesh.n_vertices)  # new number of each vertex
    order = chance.permutation(mesh.n_faces)
    vertices = np.empty_like(mesh.vertices)
    vertices[names] = size * (mesh.vertices - mesh.vertices.mean(axis=0)) @ Q.T
    turned = names[mesh.faces][np.arange(mesh.n_faces)[:, None], (np.arange(3) + chance.integers(3)) % 3]
    other = TriangleMesh(vertices, turned[order])
    one = heat_distance(mesh, [source], "h2")
    two = heat_distance(other, [int(names[source])], "h2")[names]
    np.testing.assert_allclose(two, size * one, rtol=0, atol=1e-8 * size * one[np.isfinite(one)].max())
    assert one[source] == 0
    assert (one >= 0).all()


@given(surfaces(), seeds)
def test_transport_keeps_lengths(mesh: TriangleMesh, seed: int) -> None:
    """Every transported vector is as long as that at the source."""
    source = int(np.random.default_rng(seed).choice(mesh.faces.ravel()))
    vector = 3.0 * random_tangent(mesh, source, seed)
    moved = VectorHeat(mesh).from_vertices([source], [vector])["transported"]
    used = np.unique(mesh.faces)
    np.testing.assert_allclose(np.linalg.norm(moved[used], axis=1), np.linalg.norm(vector), rtol=1e-12)


@given(surfaces(), seeds)
def test_parts_of_a_field(mesh: TriangleMesh, seed: int) -> None:
    """They add up to the field, and their energies to its energy."""
    result = HelmholtzDecomposition(mesh)(np.random.default_rng(seed).normal(size=(mesh.n_faces, 3)))
    parts = [result[name] for name in ("curl_free", "coexact", "harmonic")]
    total = energy(mesh, result["field"])
    np.testing.assert_allclose(sum(parts), result["field"], atol=1e-9 * np.abs(result["field"]).max())
    assert sum(energy(mesh, part) for part in parts) == pytest.approx(total, rel=1e-9)


@given(surfaces(CLOSED, shake=0.1), seeds)
def test_flow_keeps_energy(mesh: TriangleMesh, seed: int) -> None:
    """Ten steps at Courant number 0.05, short enough for meshes as coarse as these."""
    scheme = ConservativeScheme(mesh)
    start = scheme.start(random_field(mesh, seed % 1000), np.zeros(mesh.n_vertices))
    before = energy(mesh, scheme.velocity(start))
    assume(before > 0)
    end = [moment.state for moment in run(scheme, start, Plan(cfl=0.05, steps=10, every=10), None)][-1]
    assert energy(mesh, scheme.velocity(end)) == pytest.approx(before, rel=1e-9)


# -- files ------------------------------------------------------------------------------------------------------------

TYPES = ["<f8", "<f4", "i1", "u1", "<i2", "<u2", "<i4", "<u4", "<i8", "<u8"]
coordinates = st.floats(allow_nan=False, allow_infinity=False)
names = st.text(st.characters(blacklist_categories=("Cs", "Cc", "Zl", "Zp")), min_size=1, max_size=9)


@st.composite
def results(draw: st.DrawFn, types: Sequence[str] = TYPES, texts: st.SearchStrategy[str] = names) -> Result:
    """Any faces over any finite points, with arrays of any type, one to four components wide, on all places."""
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
    """To the last bit of every number, NaN with NaN; single precision is read as double."""
    assert found.mesh.vertices.tobytes() == made.mesh.vertices.tobytes()
    np.testing.assert_array_equal(found.mesh.faces, made.mesh.faces)
    there = {(field.name, field.location): np.asarray(field.values) for field in found.fields}
    assert there.keys() == {(field.name, field.location) for field in made.fields}
    for field in made.fields:
        np.testing.assert_array_equal(there[field.name, field.location], field.values)


@pytest.mark.parametrize("extension", ["vtk", "vtp", "vtu"])
@given(results())
def test_vtk_files(tmp_path_factory: pytest.TempPathFactory, extension: str, made: Result) -> None:
    """All that was written is read."""
    path = tmp_path_factory.mktemp("files") / f"a.{extension}"
    write(made, path)
    assert_same(read(path), made)


@given(results(["<f8", "i1", "u1", "<i2", "<u2", "<i4", "<u4"], st.text("abcdefgh", min_size=1, max_size=5)))
def test_ply_files(tmp_path_factory: pytest.TempPathFactory, made: Result) -> None:
    """All but the arrays of the whole mesh; vectors of two and four components become scalars."""
    path = tmp_path_factory.mktemp("files") / "a.ply"
    kept = [field for field in made.fields if field.location != "mesh" and np.shape(field.values)[1:] in ((), (3,))]
    made = Result(made.mesh, kept)
    write(made, path)
    assert_same(read(path), made)


@given(results())
def test_text_files(tmp_path_factory: pytest.TempPathFactory, made: Result) -> None:
    """Coordinates with the shortest digits that read back as the same number."""
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
    """Every number, whole or not, NaN and infinities."""
    path = tmp_path_factory.mktemp("files") / "a.csv"
    write_csv(path, [{"a": a, "b, c": b} for a, b in rows])
    found = read_csv(path)
    for name, column in zip(("a", "b, c"), zip(*rows, strict=True), strict=True):
        np.testing.assert_array_equal(found[name], np.array(column))


@pytest.mark.parametrize("extension", ["npz", "mtx"])
@given(arrays.arrays(np.float64, st.tuples(st.integers(1, 6), st.integers(1, 6)), elements=coordinates))
def test_matrices(tmp_path_factory: pytest.TempPathFactory, extension: str, dense: np.ndarray) -> None:
    """Every entry that is not zero, to the last bit."""
    path = tmp_path_factory.mktemp("files") / f"a.{extension}"
    write_matrix(path, sp.csr_array(dense))
    np.testing.assert_array_equal(read_arrays(path)[UNNAMED].toarray(), dense)


@given(
    arrays.arrays(st.sampled_from(TYPES), arrays.array_shapes(max_dims=3, max_side=4)), st.dictionaries(names, numbers)
)
def test_states(tmp_path_factory: pytest.TempPathFactory, values: np.ndarray, description: dict[str, float]) -> None:
    """Arrays and description."""
    path = tmp_path_factory.mktemp("files") / "a.npz"
    write_checkpoint(path, description, {"values": values})
    told, found = read_checkpoint(path)
    assert found["values"].dtype == values.dtype
    np.testing.assert_array_equal(found["values"], values)
    np.testing.assert_equal(told, description)


@given(names.filter(lambda name: "/" not in name and name.strip(" .")), st.lists(coordinates, min_size=1, max_size=4))
def test_series(tmp_path_factory: pytest.TempPathFactory, name: str, times: list[float]) -> None:
    """Times to the last bit, and files of any name."""
    path = tmp_path_factory.mktemp("files") / f"{name}.pvd"
    writer = SeriesWriter(path)
    for time in times:
        writer.add(time, Result(BASES[0]))
    frames = read_series(path)
    assert [frame.time for frame in frames] == times
    assert all((Path(path.parent) / frame.file).exists() for frame in frames)
