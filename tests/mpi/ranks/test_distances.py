"""Distances over MPI ranks against those of one process; every rank runs every test (``make test-mpi``)."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mpi4py import MPI

from geomhw.distributed import distribute, distributed_distance, open_sliced
from geomhw.distributed.poisson import DirichletProblem
from geomhw.errors import ArgumentError, FormatError, MeshError
from geomhw.geodesic import HeatDistance
from geomhw.mesh import TriangleMesh
from geomhw.mesh.primitives import grid, icosphere, strip
from support.meshes import book, two_spheres
from support.rank_meshes import RANKS, camelhead, genus_two, in_order, saved, with_loose_vertex
from support.reference import REFERENCE

CASES: dict[str, tuple[Any, list[int], str]] = {
    "sphere": (lambda: icosphere(5), [7], "h2"),
    "sphere, short time": (lambda: icosphere(4), [7], "0.1*h2"),
    "sphere, long time": (lambda: icosphere(4), [7], "20*h2"),
    "sphere, several sources": (lambda: icosphere(4), [7, 100, 101, 2000], "h2"),
    "strip": (lambda: strip(3000, 2), [0], "h2"),
    "strip, long time": (lambda: strip(3000, 2), [0], "30*h2"),
    "two components": (two_spheres, [7], "h2"),
    "two components, a source each": (two_spheres, [7, 200], "h2"),
    "genus 2": (genus_two, [5], "h2"),
    "grid with a boundary": (lambda: grid(20, 20), [3], "h2"),
    "edges of several faces": (book, [3], "h2"),
    "loose vertex": (with_loose_vertex, [5], "h2"),
    "fewer vertices than ranks": (lambda: TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]), [1], "h2"),
    "camelhead": (camelhead, [100], "h2"),
}
#: Sweeps per vertex or iterations of rounds, and iterations of the Poisson equation, on one rank.
COUNTS = {
    "sphere": (38, 10),
    "strip": (34, 13),
    "two components": (21, 7),
    "camelhead": ([13, 11, 10, 11, 15, 15, 12, 12, 6], 15),
    "genus 2": (31.6, 9),
}
#: The same iterations with GAMG.
GAMG_COUNTS = {"sphere": 17, "genus 2": 21, "camelhead": 69}


@pytest.mark.parametrize("bound", [True, False], ids=["bounded", "unbounded"])
@pytest.mark.parametrize("name", CASES)
def test_equal_to_one_process(name: str, bound: bool, folder: Path) -> None:
    """Distances differ by at most 1e-8 of the largest from those of factorizations in one process."""
    if name == "camelhead" and not REFERENCE:
        pytest.skip("the reference meshes are missing")
    make, sources, time = CASES[name]
    whole = make()
    mesh = distribute(RANKS, open_sliced(RANKS, saved(whole, folder)))
    result = distributed_distance(mesh, np.array(sources), time, bound)
    expected = HeatDistance(whole, time, solver="direct", bound=bound).from_vertices(sources)
    found, known = in_order(mesh, result.fields["distance"]), expected["distance"]
    assert np.array_equal(np.isfinite(found), np.isfinite(known))
    finite = np.isfinite(known)
    largest = known[finite].max()
    assert np.abs(found[finite] - known[finite]).max() <= 1e-8 * largest
    assert result.report["unreachable_vertices"] == expected.report["unreachable_vertices"]
    assert result.report["mean_distance"] == pytest.approx(expected.report["mean_distance"], rel=1e-8)
    assert result.report["farthest"]["distance"] == pytest.approx(expected.report["farthest"]["distance"], rel=1e-8)
    heat = in_order(mesh, result.fields["heat"])
    assert np.abs(heat - expected["heat"]).max() <= 1e-8 * expected["heat"].max()
    if name in COUNTS:
        of_heat, poisson = result.report["heat"], result.report["poisson"]["iterations"]
        counts = of_heat["per_vertex"] if of_heat["method"] == "sweeps" else of_heat["iterations"]
        assert np.abs(np.subtract(counts, COUNTS[name][0])).max() <= 2
        assert abs(poisson - COUNTS[name][1]) <= 2


@pytest.fixture
def gamg() -> Iterator[None]:
    """The preconditioner as with PETSC_OPTIONS."""
    options = RANKS.petsc.Options()
    options.setValue("pc_type", "gamg")
    yield
    options.delValue("pc_type")


@pytest.mark.usefixtures("gamg")
@pytest.mark.parametrize("name", GAMG_COUNTS)
def test_gamg(name: str, folder: Path) -> None:
    """With GAMG, distances are as accurate, in about equally many iterations on any number of ranks."""
    if name == "camelhead" and not REFERENCE:
        pytest.skip("the reference meshes are missing")
    make, sources, time = CASES[name]
    whole = make()
    mesh = distribute(RANKS, open_sliced(RANKS, saved(whole, folder)))
    result = distributed_distance(mesh, np.array(sources), time)
    known = HeatDistance(whole, time, solver="direct").from_vertices(sources)["distance"]
    assert np.abs(in_order(mesh, result.fields["distance"]) - known).max() <= 1e-8 * known.max()
    assert result.report["poisson"]["preconditioner"] == "gamg"
    assert abs(result.report["poisson"]["iterations"] - GAMG_COUNTS[name]) <= 3


def test_without_hypre() -> None:
    """Where PETSc is without hypre, the preconditioner is GAMG."""

    class WithoutHypre:
        kind = ""

        def setOperators(self, matrix: Any) -> None:
            pass

        def setType(self, kind: str) -> None:
            if kind == "hypre":
                raise RANKS.petsc.Error(86)
            self.kind = kind

    found, problem = WithoutHypre(), object.__new__(DirichletProblem)
    problem._ranks, problem.matrix = RANKS, None
    problem.precondition(found)
    assert found.kind == "gamg"


def test_no_rank_has_the_whole_mesh(folder: Path) -> None:
    """Each rank has its share of vertices, exactly, and of faces, with a layer of ghosts."""
    whole = icosphere(5)
    mesh = distribute(RANKS, open_sliced(RANKS, saved(whole, folder)))
    assert RANKS.sum(mesh.n_own) == whole.n_vertices
    assert abs(mesh.n_own - whole.n_vertices / RANKS.size) <= 1
    border = 8 * np.sqrt(whole.n_vertices) if RANKS.size > 1 else 0
    assert len(mesh.ghosts) <= border
    assert len(mesh.faces) <= whole.n_faces / RANKS.size + 2 * border
    assert len(mesh.vertices) == mesh.n_own + len(mesh.ghosts)


def test_faces_and_copies(folder: Path) -> None:
    """A copy of a face changes nothing, also where its corners have another order."""
    plain = icosphere(3)
    doubled = TriangleMesh(plain.vertices, np.concatenate([plain.faces, plain.faces[5:9, ::-1]]))
    found = []
    for k, whole in enumerate((plain, doubled)):
        (folder / str(k)).mkdir(exist_ok=True)
        mesh = distribute(RANKS, open_sliced(RANKS, saved(whole, folder / str(k))))
        found.append(in_order(mesh, distributed_distance(mesh, np.array([7])).fields["distance"]))
    assert np.abs(found[0] - found[1]).max() <= 1e-10


@pytest.mark.parametrize(
    ("size", "stretch", "reason"),
    [
        (1.5, 1.0, "h²; only one process compares it with √h"),
        (1.5, 4.0, "h², since cotan weights are negative"),
        (0.1, 4.0, "h²"),
    ],
)
def test_automatic_time(size: float, stretch: float, reason: str, folder: Path) -> None:
    """``auto`` is h², and √h is compared with it in one process only, where cotan weights leave the choice."""
    ball = icosphere(3)
    mesh = TriangleMesh(ball.vertices * [1, 1, stretch], ball.faces)
    whole = TriangleMesh(mesh.vertices * (size / mesh.mean_edge_length), mesh.faces)
    part = distribute(RANKS, open_sliced(RANKS, saved(whole, folder)))
    found = distributed_distance(part, np.array([7])).report["time"]
    assert found["reason"] == reason
    if "process" not in reason:
        assert HeatDistance(whole).time.reason == reason


@pytest.mark.parametrize("sources", [[5000], [-1], [162]])
def test_no_such_source(sources: list[int], folder: Path) -> None:
    """All ranks raise the same error for a source that does not exist or belongs to no face."""
    mesh = distribute(RANKS, open_sliced(RANKS, saved(with_loose_vertex(), folder)))
    with pytest.raises(ArgumentError, match=f"source {sources[0]} ") as error:
        distributed_distance(mesh, np.array(sources))
    assert len(set(RANKS.comm.allgather(str(error.value)))) == 1


def test_faces_without_area(folder: Path) -> None:
    """All ranks raise an error that names the face by its vertices."""
    ball = icosphere(2)
    points = ball.vertices.copy()
    points[ball.faces[7, 0]] = points[ball.faces[7, 1]]
    mesh = distribute(RANKS, open_sliced(RANKS, saved(TriangleMesh(points, ball.faces), folder)))
    with pytest.raises(MeshError, match="zero area"):
        distributed_distance(mesh, np.array([50]))


@pytest.mark.parametrize("damage", ["text", "quad", "short", "vertex", "coordinate", "twice"])
def test_damaged_files(damage: str, folder: Path) -> None:
    """All ranks raise an error of one sentence for a file that is damaged, or not of triangles only."""
    path = saved(grid(9, 9), folder)
    if RANKS.rank == 0:
        data = bytearray(path.read_bytes())
        face = len(data) - 13 * 162
        if damage == "text":
            data = bytearray(data.replace(b"binary_little_endian", b"ascii"))
        elif damage == "quad":
            data[face] = 4
        elif damage == "short":
            del data[-20:]
        elif damage in ("vertex", "twice"):
            data[face + 1 : face + 5] = (
                (1000).to_bytes(4, "little") if damage == "vertex" else data[face + 5 : face + 9]
            )
        else:
            data[face - 8 : face] = np.array([np.nan]).tobytes()
        path.write_bytes(data)
    RANKS.comm.Barrier()
    with pytest.raises((FormatError, MeshError)) as error:
        distribute(RANKS, open_sliced(RANKS, path))
    assert len(set(RANKS.comm.allgather(str(error.value)))) == 1


def test_error_of_one_rank() -> None:
    """An error on one rank is raised on all."""

    def fail_on_last() -> None:
        with RANKS.agreeing():
            if RANKS.rank == RANKS.size - 1:
                raise MeshError("here")

    with pytest.raises(MeshError, match="here"):
        fail_on_last()


def test_several_ranks() -> None:
    """The ranks are those of mpirun."""
    assert MPI.COMM_WORLD.Get_size() == RANKS.size
