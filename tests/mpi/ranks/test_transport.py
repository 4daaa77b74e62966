"""Tangent vectors over MPI ranks against those of one process; every rank runs every test (``make test-mpi``)."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from geomhw.distributed import distribute, distributed_transport, open_sliced, source_stars
from geomhw.errors import MeshError
from geomhw.mesh import TriangleMesh
from geomhw.mesh.named_points import vertex_points
from geomhw.mesh.primitives import grid, icosphere, strip
from geomhw.transport import VectorHeat
from support.hostile import arrays, flipped, hourglass
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
    "camelhead": (camelhead, [100], ONE, "h2"),
}


@pytest.mark.parametrize("name", CASES)
def test_equal_to_one_process(name: str, folder: Path) -> None:
    """Vectors differ by at most 1e-8 of their length from those of factorizations, away from the cut locus."""
    if name == "camelhead" and not REFERENCE:
        pytest.skip("the reference meshes are missing")
    make, sources, vectors, time = CASES[name]
    whole = make()
    mesh = distribute(RANKS, open_sliced(RANKS, saved(whole, folder)))
    points = vertex_points(whole, sources)
    result = distributed_transport(mesh, source_stars(mesh, points.corners), points, vectors, [time])
    method = VectorHeat(whole, time, solver="direct")
    expected = method.from_vertices(sources, vectors)
    found, known = in_order(mesh, result.fields["transported"]), np.asarray(expected["transported"])
    assert np.array_equal(found.any(axis=1), known.any(axis=1))
    length = np.linalg.norm(known, axis=1)
    clear = (length > 0) & away_from_the_cut_locus(method, points, vectors)
    assert clear.sum() > 0.9 * (length > 0).sum()
    assert (np.linalg.norm(found - known, axis=1)[clear] / length[clear]).max() <= 1e-8
    diffused, size = in_order(mesh, result.fields["diffused"]), np.linalg.norm(expected["diffused"], axis=1)
    assert np.linalg.norm(diffused - expected["diffused"], axis=1).max() <= 1e-8 * size.max()
    for key in ("unreachable_vertices", "vertices_without_normal"):
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


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: TriangleMesh(*flipped(arrays(icosphere(3)))), "oriented"),
        (lambda: TriangleMesh(*hourglass()), "several fans"),
        (book, "more than two"),
    ],
)
def test_meshes_without_a_tangent_plane_are_refused(make: Callable[[], TriangleMesh], words: str, folder: Path) -> None:
    """All ranks refuse a mesh on which vectors do not pass somewhere, with the reason."""
    whole = make()
    mesh = distribute(RANKS, open_sliced(RANKS, saved(whole, folder)))
    points = vertex_points(whole, [0])
    with pytest.raises(MeshError, match=words):
        distributed_transport(mesh, source_stars(mesh, points.corners), points, ONE, ["h2"])


def away_from_the_cut_locus(method: VectorHeat, points: Any, vectors: Any) -> Any:
    """Mask of the vertices at which vectors that arrive on different ways do not cancel."""
    heat = method._heat.from_impulse(points.impulse(method.mesh.n_vertices))
    y0 = method._domain.source_field(points, np.asarray(vectors))
    log = method._diffused(y0, heat)[1].log
    return log - np.where(np.isfinite(heat.log), heat.log, 0.0) > np.log(0.05 * np.linalg.norm(vectors, axis=1).min())
