"""Sources within faces and nearest to places in space, over MPI ranks against one process."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from geomhw.distributed import (
    distribute,
    distributed_distance,
    distributed_transport,
    face_sources,
    near_sources,
    open_sliced,
    source_stars,
    vertex_sources,
)
from geomhw.errors import ArgumentError
from geomhw.geodesic import HeatDistance
from geomhw.mesh import TriangleMesh, nearest_points
from geomhw.mesh.named_points import face_points, vertex_points
from geomhw.mesh.primitives import grid, icosphere, strip
from geomhw.mesh.surface_points import SurfacePoints, concatenate
from geomhw.transport import VectorHeat
from support.meshes import book, two_spheres
from support.rank_meshes import RANKS, in_order, saved

INSIDE, ON_EDGE = [0.2, 0.3, 0.5], [0.0, 0.4, 0.6]
#: Mesh, source vertices, faces, barycentric coordinates.
CASES: dict[str, tuple[Any, list[int], list[int], list[list[float]]]] = {
    "inside a face": (lambda: icosphere(4), [], [100], [INSIDE]),
    "on an edge": (lambda: icosphere(4), [], [100], [ON_EDGE]),
    "two in one face": (lambda: icosphere(3), [], [100, 100], [INSIDE, [0.6, 0.3, 0.1]]),
    "faces and vertices": (lambda: icosphere(4), [7, 8, 900], [100, 4000], [INSIDE, ON_EDGE]),
    "a vertex beside a face": (lambda: icosphere(3), [int(icosphere(3).faces[100, 0])], [100], [INSIDE]),
    "strip": (lambda: strip(1000, 2), [], [3], [INSIDE]),
    "two components": (two_spheres, [], [5], [INSIDE]),
    "two components, a source each": (two_spheres, [200], [5], [INSIDE]),
    "an edge of several faces": (book, [], [0], [ON_EDGE]),
    "boundary": (lambda: grid(12, 12), [], [0], [ON_EDGE]),
}


def points_on(mesh: Any, vertices: list[int], faces: list[int], weights: list[list[float]]) -> SurfacePoints:
    parts = [vertex_sources(mesh, np.array(vertices))] if vertices else []
    return concatenate([*parts, face_sources(mesh, np.array(faces), weights)])


def points_alone(mesh: TriangleMesh, vertices: list[int], faces: list[int], weights: Any) -> SurfacePoints:
    parts = [vertex_points(mesh, vertices)] if vertices else []
    return concatenate([*parts, face_points(mesh, faces, weights)])


@pytest.mark.parametrize("bound", [True, False], ids=["bounded", "unbounded"])
@pytest.mark.parametrize("name", CASES)
def test_distances(name: str, bound: bool, folder: Path) -> None:
    """Distances from points in faces differ by at most 1e-8 of the largest from those of one process."""
    make, *spots = CASES[name]
    whole = make()
    mesh = distribute(RANKS, open_sliced(RANKS, saved(whole, folder)))
    result = distributed_distance(mesh, points_on(mesh, *spots), "h2", bound)
    expected = HeatDistance(whole, "h2", solver="direct", bound=bound).from_sources(points_alone(whole, *spots))
    found, known = in_order(mesh, result.fields["distance"]), expected["distance"]
    finite = np.isfinite(known)
    assert np.array_equal(np.isfinite(found), finite)
    assert np.abs(found[finite] - known[finite]).max() <= 1e-8 * known[finite].max()
    assert np.abs(in_order(mesh, result.fields["heat"]) - expected["heat"]).max() <= 1e-8 * expected["heat"].max()
    assert result.report["farthest"]["distance"] == pytest.approx(expected.report["farthest"]["distance"], rel=1e-8)


@pytest.mark.parametrize("weights", [INSIDE, ON_EDGE])
def test_vectors(weights: list[float], folder: Path) -> None:
    """Vectors from a point in a face, near it, where they meet no others."""
    whole = icosphere(4)
    mesh = distribute(RANKS, open_sliced(RANKS, saved(whole, folder)))
    points, vectors = points_on(mesh, [], [100], [weights]), [[0.3, 0.5, -0.7]]
    result = distributed_transport(mesh, source_stars(mesh, points.corners), points, vectors, ["h2"])
    expected = VectorHeat(whole, "h2", solver="direct").from_sources(points_alone(whole, [], [100], [weights]), vectors)
    near = whole.vertices @ whole.face_normals[100] > -0.8
    for name in ("diffused", "transported"):
        found, known = in_order(mesh, result.fields[name]), np.asarray(expected[name])
        assert np.abs(found - known)[near].max() <= 1e-8 * np.abs(known).max()
    assert result.report["sources"] == expected.report["sources"]


def test_near(folder: Path) -> None:
    """The nearest points to places in space are those of one process, also on edges and at vertices."""
    whole = icosphere(3)
    mesh = distribute(RANKS, open_sliced(RANKS, saved(whole, folder)))
    ends = whole.vertices[whole.edges[[3, 500]]].mean(axis=1)
    places = np.concatenate([np.random.default_rng(1).normal(size=(20, 3)), 1.2 * whole.vertices[[5, 400]], 1.1 * ends])
    found, distances, diagonal = near_sources(mesh, places)
    expected = nearest_points(whole, places)
    assert np.array_equal(found.faces[:22], expected.faces[:22])
    assert found.faces[20] == -1
    assert np.abs(found.positions(whole) - expected.positions(whole)).max() <= 1e-12
    assert np.allclose(distances, np.linalg.norm(places - expected.positions(whole), axis=1), rtol=0, atol=1e-12)
    assert diagonal == pytest.approx(np.linalg.norm(np.ptp(whole.vertices, axis=0)))


@pytest.mark.parametrize(("faces", "weights"), [([5000], INSIDE), ([-1], INSIDE), ([3], [0.5, 0.2, 0.1])])
def test_no_such_point(faces: list[int], weights: list[float], folder: Path) -> None:
    """All ranks raise the error of one process for a face or coordinates that do not exist."""
    whole = icosphere(2)
    mesh = distribute(RANKS, open_sliced(RANKS, saved(whole, folder)))
    with pytest.raises(ArgumentError) as error:
        face_sources(mesh, np.array(faces), [weights])
    with pytest.raises(ArgumentError) as alone:
        face_points(whole, faces, [weights])
    assert str(error.value) == str(alone.value)
    with pytest.raises(ArgumentError, match="away from the mesh"):
        near_sources(mesh, [[1e9, 0, 0]])
