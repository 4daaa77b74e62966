"""Tangent vectors over MPI ranks against those of one process; every rank runs every test (``make test-mpi``)."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from geomhw.distributed import distribute, distributed_transport, open_sliced, source_orientation, source_stars
from geomhw.errors import ConvergenceError, MeshError
from geomhw.mesh import TriangleMesh, face_point
from geomhw.mesh.named_points import vertex_points
from geomhw.mesh.primitives import grid, icosphere, moebius_band, strip
from geomhw.options import Connection
from geomhw.transport import VectorHeat
from geomhw.transport.source_vectors import source_frames, tangent_vectors, unit_vectors
from support.hostile import arrays, doubled, flipped, hourglass, joined, klein_bottle, moved, pinched_meshes, turned
from support.meshes import book, two_spheres
from support.rank_meshes import RANKS, camelhead, folded_sheet, genus_two, in_order, saved, with_loose_vertex
from support.reference import REFERENCE

ONE, TWO = [[0.3, 0.5, -0.7]], [[0.3, 0.5, -0.7], [2.0, 0.1, 0.4]]
#: Mesh, source vertices, vectors, diffusion time.
CASES: dict[str, tuple[Any, list[int], list[list[float]], str]] = {
    "sphere": (lambda: icosphere(5), [7], ONE, "h2"),
    "sphere, long time": (lambda: icosphere(4), [7], ONE, "20*h2"),
    "sphere, two lengths": (lambda: icosphere(4), [7, 900], TWO, "h2"),
    "sphere, two lengths, long time": (lambda: icosphere(4), [7, 900], TWO, "20*h2"),
    "strip": (lambda: strip(3000, 2), [0], ONE, "h2"),
    "strip, long time": (lambda: strip(3000, 2), [0], ONE, "30*h2"),
    "two components": (two_spheres, [7], ONE, "h2"),
    "two components, a source each": (two_spheres, [7, 200], TWO, "h2"),
    "genus 2": (genus_two, [5], ONE, "h2"),
    "grid with a boundary": (lambda: grid(20, 20), [3], ONE, "h2"),
    "loose vertex": (with_loose_vertex, [5], ONE, "h2"),
    "fewer vertices than ranks": (lambda: TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]), [1], ONE, "h2"),
    "fold": (folded_sheet, [20], ONE, "h2"),
    "fold, long time": (folded_sheet, [20], ONE, "20*h2"),
    "faces turned": (lambda: TriangleMesh(*flipped(arrays(icosphere(4)))), [7, 900], TWO, "h2"),
    "faces turned, long time": (lambda: TriangleMesh(*flipped(arrays(icosphere(4)))), [7], ONE, "20*h2"),
    "faces turned, two components": (lambda: TriangleMesh(*flipped(arrays(two_spheres()))), [7, 200], TWO, "h2"),
    "faces turned, fold": (lambda: TriangleMesh(*flipped(arrays(folded_sheet()))), [20], ONE, "h2"),
    "pinched": (lambda: TriangleMesh(*hourglass()), [3], ONE, "h2"),
    "edges of three faces": (book, [3], ONE, "h2"),
    "edges of three faces, a source there": (book, [0], ONE, "h2"),
    "edges of three faces, turned": (lambda: TriangleMesh(*flipped(arrays(book()))), [40], ONE, "20*h2"),
    "one-sided": (lambda: moebius_band(60, 6), [9], ONE, "h2"),
    "one-sided, long time": (lambda: moebius_band(60, 6), [9], ONE, "20*h2"),
    "one-sided, closed": (lambda: TriangleMesh(*klein_bottle()), [5], ONE, "h2"),
    "one-sided, beside a sphere": (
        lambda: TriangleMesh(*joined(arrays(moebius_band(40, 4)), moved(arrays(icosphere(3)), offset=5.0))),
        [9, 400],
        TWO,
        "h2",
    ),
    "camelhead": (camelhead, [100], ONE, "h2"),
}


INTRINSIC = ["sphere", "sphere, long time", "grid with a boundary", "genus 2", "loose vertex", "faces turned"]
INTRINSIC += ["pinched", "edges of three faces", "one-sided", "one-sided, long time", "fewer vertices than ranks"]
INTRINSIC += ["camelhead"]


@pytest.mark.parametrize("name", INTRINSIC)
def test_intrinsic_connection(name: str, folder: Path) -> None:
    """The same with the intrinsic connection."""
    compare(name, folder, "intrinsic")


@pytest.mark.parametrize("name", CASES)
def test_equal_to_one_process(name: str, folder: Path) -> None:
    """Vectors differ by at most 1e-8 of their length from those of factorizations, away from the cut locus."""
    compare(name, folder, "normals")


def compare(name: str, folder: Path, connection: Connection) -> None:
    if name == "camelhead" and not REFERENCE:
        pytest.skip("the reference meshes are missing")
    make, sources, vectors, time = CASES[name]
    whole = make()
    mesh = distribute(RANKS, open_sliced(RANKS, saved(whole, folder)))
    points = vertex_points(whole, sources)
    result = distributed_transport(mesh, source_stars(mesh, points.corners), points, vectors, [time], connection)
    method = VectorHeat(whole, time, connection, solver="direct")
    expected = method.from_vertices(sources, vectors)
    found, known = in_order(mesh, result.fields["transported"]), np.asarray(expected["transported"])
    assert np.array_equal(found.any(axis=1), known.any(axis=1))
    length = np.linalg.norm(known, axis=1)
    clear = (length > 0) & away_from_the_cut_locus(method, points, vectors)
    assert clear.sum() > 0.9 * (length > 0).sum()
    assert (np.linalg.norm(found - known, axis=1)[clear] / length[clear]).max() <= 1e-8
    diffused, size = in_order(mesh, result.fields["diffused"]), np.linalg.norm(expected["diffused"], axis=1)
    assert np.linalg.norm(diffused - expected["diffused"], axis=1).max() <= 1e-8 * size.max()
    crossings = ("non_manifold_edges", "non_manifold_vertices", "vertices_without_normal")
    for key in ("unreachable_vertices", *crossings):
        assert result.report.get(key) == expected.report.get(key)
    assert np.allclose(result.report["vectors"], expected.report["vectors"], rtol=0, atol=1e-12)
    assert result.report["sources"] == expected.report["sources"]


def test_gamg(folder: Path) -> None:
    """In rounds, the scalar preconditioner of each component may be GAMG."""
    options = RANKS.petsc.Options()
    options.setValue("pc_type", "gamg")
    try:
        test_equal_to_one_process("sphere, long time", folder)
    finally:
        options.delValue("pc_type")


def test_intrinsic_connection_needs_normals(folder: Path) -> None:
    """All ranks refuse the intrinsic connection at vertices without a normal, where no frame fixes a direction."""
    whole = folded_sheet()
    mesh = distribute(RANKS, open_sliced(RANKS, saved(whole, folder)))
    points = vertex_points(whole, [20])
    with pytest.raises(MeshError, match="no normal"):
        distributed_transport(mesh, source_stars(mesh, points.corners), points, ONE, ["h2"], "intrinsic")


def test_indefinite_systems(folder: Path) -> None:
    """Where M + tK has a negative eigenvalue, all ranks raise an error that names the remedy, which works."""
    whole = TriangleMesh(*pinched_meshes()["pinched_bands"])
    assert np.linalg.eigvalsh(VectorHeat(whole, "20*h2", "intrinsic")._matrix.toarray())[0] < 0
    mesh = distribute(RANKS, open_sliced(RANKS, saved(whole, folder)))
    points = vertex_points(whole, [0])
    stars = source_stars(mesh, points.corners)
    with pytest.raises(ConvergenceError, match="take a shorter time"):
        distributed_transport(mesh, stars, points, ONE, ["20*h2"], "intrinsic")
    expected = VectorHeat(whole, "h2", "intrinsic", solver="direct").from_vertices([0], ONE)["diffused"]
    found = in_order(mesh, distributed_transport(mesh, stars, points, ONE, ["h2"], "intrinsic").fields["diffused"])
    assert np.abs(found - expected).max() <= 1e-8 * np.linalg.norm(expected, axis=1).max()


def half_turned(mesh: TriangleMesh, first: int) -> TriangleMesh:
    """The mesh with every other face reversed, from the given one on."""
    faces = mesh.faces.copy()
    faces[first::2] = faces[first::2, ::-1]
    return TriangleMesh(mesh.vertices, faces)


SIDES = {
    "sphere": lambda: icosphere(3),
    "a third turned": lambda: TriangleMesh(*turned(arrays(icosphere(3)))),
    "most turned": lambda: TriangleMesh(*turned((icosphere(3).vertices, icosphere(3).faces[:, ::-1]))),
    "half turned": lambda: half_turned(icosphere(3), 0),
    "other half turned": lambda: half_turned(icosphere(3), 1),
    "two components, half turned": lambda: half_turned(two_spheres(), 1),
    "at random": lambda: TriangleMesh(*flipped(arrays(genus_two()), seed=3)),
    "edges of three faces": lambda: TriangleMesh(*flipped(arrays(book()))),
    "one-sided": lambda: TriangleMesh(*flipped(arrays(moebius_band(40, 4)))),
    "pinched": lambda: TriangleMesh(*flipped(hourglass())),
    "copies of faces": lambda: TriangleMesh(*doubled(turned(arrays(icosphere(3))), slice(0, 300), flip=True)),
}


@pytest.mark.parametrize("name", SIDES)
def test_angles_at_sources(name: str, folder: Path) -> None:
    """Angles are counterclockwise about the normals of the whole mesh, though only faces round the sources are used."""
    whole = SIDES[name]()
    mesh = distribute(RANKS, open_sliced(RANKS, saved(whole, folder)))
    for points in (vertex_points(whole, np.arange(0, whole.n_vertices, 7)), face_point(whole, 5)):
        stars = source_stars(mesh, points.corners)
        frames = source_frames(stars.mesh, stars.points(points))
        found = unit_vectors(frames, 30.0 * source_orientation(mesh, stars, points))
        assert np.abs(found - unit_vectors(source_frames(whole, points), 30.0)).max() < 1e-12


def test_sides_of_single_sources(folder: Path) -> None:
    """The same for sources one by one: their few faces rarely have the majority of the mesh."""
    whole = TriangleMesh(*flipped(arrays(icosphere(2))))
    mesh = distribute(RANKS, open_sliced(RANKS, saved(whole, folder)))
    turned_sides = 0
    for vertex in range(0, whole.n_vertices, 9):
        points = vertex_points(whole, [vertex])
        stars = source_stars(mesh, points.corners)
        side = source_orientation(mesh, stars, points)
        found = unit_vectors(source_frames(stars.mesh, stars.points(points)), 30.0 * side)
        assert np.abs(found - unit_vectors(source_frames(whole, points), 30.0)).max() < 1e-12
        turned_sides += int(side[0] < 0)
    assert turned_sides > 0


def away_from_the_cut_locus(method: VectorHeat, points: Any, vectors: Any) -> Any:
    """Mask of the vertices at which vectors that arrive on different ways do not cancel."""
    domain = method._domain
    fans, source = domain.split(points)
    fans, parts, _ = tangent_vectors(points, np.asarray(vectors), domain.base, fans, source)
    heat = method._heat.from_impulse(domain.impulse(fans))
    z = method._diffused(domain.source_field(fans, parts), heat)[1]
    clear = z.log - np.where(np.isfinite(heat.log), heat.log, 0.0) > np.log(0.05 * np.linalg.norm(parts, axis=1).min())
    return clear[domain.answering(z.log, z.sign)]
