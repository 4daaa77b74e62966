"""Fast marching: exact on flat surfaces, close to exact distances on all others, from any kind of source."""

import numpy as np
import pytest
from attack.families import FAMILIES, random_mesh

from geomhw.curves import trace_polyline
from geomhw.geodesic.edge_paths import edge_path_distance
from geomhw.geodesic.exact import ExactDistance
from geomhw.geodesic.fast_marching import FastMarchingDistance
from geomhw.geodesic.front import Extent
from geomhw.geodesic.marching import GROWTH, TOLERANCE, empty_march, propagate
from geomhw.geodesic.marching_sources import start
from geomhw.geodesic.vertex_angles import no_angles
from geomhw.mesh import curve_points
from geomhw.mesh.named_points import face_point, region_points, vertex_points
from geomhw.mesh.primitives import grid, icosphere
from geomhw.mesh.surface_points import SurfacePoints, concatenate
from geomhw.mesh.triangle_mesh import TriangleMesh
from support.exact import cylinder
from support.meshes import zoo_mesh

FLAT = ["patch", "anisotropic_patch", "needle_fan", "scattered", "band", "slivers", "pages"]
CURVED = sorted(set(FAMILIES) - set(FLAT))


def errors(mesh: TriangleMesh, sources: SurfacePoints) -> np.ndarray:
    """Relative errors against exact distances, where these are positive; both reach the same vertices."""
    exact = np.asarray(ExactDistance(mesh).from_sources(sources)["distance"])
    found = np.asarray(FastMarchingDistance(mesh).from_sources(sources)["distance"])
    np.testing.assert_array_equal(np.isfinite(found), np.isfinite(exact))
    assert not found[exact == 0].any()
    far = np.isfinite(exact) & (exact > 0)
    return found[far] / exact[far] - 1


def some_vertex(mesh: TriangleMesh, seed: int) -> SurfacePoints:
    """A vertex of the surface."""
    return vertex_points(mesh, [int(np.random.default_rng(seed).choice(np.unique(mesh.faces)))])


@pytest.mark.parametrize("family", FLAT)
def test_flat(family: str) -> None:
    """On flat pieces, also glued along edges of three faces, distances are exact up to rounding."""
    for seed in range(8):
        mesh = TriangleMesh(*random_mesh(family, seed))
        np.testing.assert_allclose(errors(mesh, some_vertex(mesh, seed)), 0, atol=1e-6)


def test_cylinder() -> None:
    """On a closed cylinder distances are exact, but where paths on both sides meet."""
    mesh, expected = cylinder()
    found = np.asarray(FastMarchingDistance(mesh).from_vertices([0])["distance"])
    assert np.quantile(abs(found - expected), 0.8) < 1e-12
    assert abs(found - expected).max() < 0.01 * expected.max()


@pytest.mark.parametrize("family", CURVED)
def test_random_meshes(family: str) -> None:
    """On coarse and rough random meshes, open, one-sided and non-manifold ones too, the mean error is below 1.5 %."""
    means = []
    for seed in range(6):
        mesh = TriangleMesh(*random_mesh(family, seed))
        found = abs(errors(mesh, some_vertex(mesh, seed)))
        means.append(found.mean() if len(found) else 0.0)
    assert max(means) < 0.015
    assert np.mean(means) < 0.004


@pytest.mark.parametrize("family", ["terrain", "pinched_torus", "touching", "maze", "slivers"])
def test_bounds(family: str) -> None:
    """Distances lie between the straight line and the shortest path along edges."""
    for seed in range(6):
        mesh = TriangleMesh(*random_mesh(family, seed))
        v = some_vertex(mesh, seed).vertices
        found = np.asarray(FastMarchingDistance(mesh).from_vertices(v)["distance"])
        reached = np.isfinite(found)
        chord = np.linalg.norm(mesh.vertices - mesh.vertices[v], axis=1)
        assert (found >= chord * (1 - 1e-12)).all()
        assert (found[reached] <= edge_path_distance(mesh, v)[reached] * (1 + 1e-8)).all()


@pytest.mark.parametrize("name", ["crumpled_torus", "genus_two", "annulus"])
def test_zoo(name: str) -> None:
    """Mean errors are below 0.4 %."""
    mesh = zoo_mesh(name)
    assert abs(errors(mesh, vertex_points(mesh, [3]))).mean() < 4e-3


def test_convergence_on_the_sphere() -> None:
    """The error against exact distances falls at least in proportion to the edge length."""
    means = []
    for level in (3, 4, 5):
        mesh = icosphere(level)
        means.append(abs(errors(mesh, face_point(mesh, 11, (0.5, 0.2, 0.3)))).mean())
    assert means[0] < 1e-3
    assert means[1] < means[0] / 2
    assert means[2] < means[1] / 2


@pytest.mark.parametrize("weights", [(0.2, 0.3, 0.5), (0.5, 0.5, 0.0), (1e-9, 0.3, 0.7), (0.98, 0.01, 0.01)])
def test_points_within_faces(weights: tuple[float, float, float]) -> None:
    """From points within faces, on edges, and near both, all of them at once too."""
    mesh = TriangleMesh(*random_mesh("patch", 3))
    points = [face_point(mesh, f, weights) for f in range(0, mesh.n_faces, 7)]
    for point in points:
        np.testing.assert_allclose(errors(mesh, point), 0, atol=1e-9)
    found = errors(mesh, concatenate(points))
    assert np.quantile(abs(found), 0.8) < 1e-9
    assert abs(found).mean() < 0.003


def test_filled_region() -> None:
    """Distances from a square are 0 inside, to its sides straight, and to its corners from these."""
    mesh = grid(12, 12)
    x, y = mesh.vertices[:, :2].T
    inside = np.flatnonzero((abs(x - 0.5) < 0.26) & (abs(y - 0.5) < 0.26))
    found = np.asarray(FastMarchingDistance(mesh).from_sources(region_points(mesh, inside))["distance"])
    expected = np.hypot(np.maximum(abs(x - 0.5) - 0.25, 0), np.maximum(abs(y - 0.5) - 0.25, 0))
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_curve_as_a_source() -> None:
    """Segments across faces are sources as for exact distances; on long triangles beside them, rays are less exact."""
    mesh = TriangleMesh(*random_mesh("patch", 5))
    path = trace_polyline(mesh, np.array([[0.3, 0.4, 0.0], [0.7, 0.5, 0.0]])).path
    line = curve_points(mesh, path.faces, path.weights)
    assert len(line.segments)
    found = abs(errors(mesh, line))
    assert found.mean() < 0.006
    assert np.median(found) < 1e-9


def test_limit_and_targets() -> None:
    """Up to a limit distances are those without one, and inf beyond; targets and all nearer vertices are final."""
    mesh = zoo_mesh("crumpled_torus")
    solver = FastMarchingDistance(mesh)
    whole = np.asarray(solver.from_vertices([3])["distance"])
    limit = 0.4 * whole.max()
    np.testing.assert_array_equal(
        solver.from_vertices([3], limit=limit)["distance"], np.where(whole <= limit, whole, np.inf)
    )
    targets = [40, 77]
    found = np.asarray(solver.from_vertices([3], targets=targets)["distance"])
    np.testing.assert_array_equal(found[targets], whole[targets])
    np.testing.assert_allclose(found[np.isfinite(found)], whole[np.isfinite(found)], rtol=1e-9)
    assert not np.isfinite(found).all()


def test_matrix() -> None:
    """Each entry is the distance from one of its two vertices, within a limit nearly always; none is missing."""
    mesh = zoo_mesh("crumpled_torus")
    solver = FastMarchingDistance(mesh)
    rows = np.stack([solver.from_vertices([v])["distance"] for v in range(mesh.n_vertices)])
    for limit in (np.inf, 0.3 * rows.max()):
        D = solver.matrix(limit)
        np.testing.assert_array_equal(D.toarray(), D.toarray().T)
        entries = D.tocoo()
        either = [rows[entries.row, entries.col], rows[entries.col, entries.row]]
        other = np.min(abs(either - entries.data), axis=0)
        assert (other > 1e-12).mean() <= (0.005 if limit < np.inf else 0)
        assert (other <= 0.02 * entries.data).all()
        near = (rows < 0.97 * limit) & (0.97 * limit > rows.T)
        assert (D.toarray()[near] > 0).sum() == near.sum() - mesh.n_vertices


@pytest.mark.parametrize("scale", [1e-20, 1e20])
@pytest.mark.parametrize("family", ["sphere", "patch", "touching", "anisotropic_patch"])
def test_scale_and_orientation(family: str, scale: float) -> None:
    """Scaled meshes, and meshes turned inside out, have the same distances."""
    vertices, faces = random_mesh(family, 2)
    mesh = TriangleMesh(vertices, faces)
    v = some_vertex(mesh, 0).vertices
    expected = np.asarray(FastMarchingDistance(mesh).from_vertices(v)["distance"])
    scaled = FastMarchingDistance(TriangleMesh(vertices * scale, faces)).from_vertices(v)["distance"] / scale
    np.testing.assert_allclose(scaled, expected, rtol=1e-9)
    turned = FastMarchingDistance(TriangleMesh(vertices, faces[:, ::-1])).from_vertices(v)["distance"]
    np.testing.assert_allclose(turned, expected, rtol=1e-9)


def test_numbering() -> None:
    """Renumbering the vertices and faces of smooth meshes changes distances by less than their errors."""
    for family in ("ring", "moebius", "klein"):
        vertices, faces = random_mesh(family, 1)
        rng = np.random.default_rng(0)
        order, place = rng.permutation(len(vertices)), np.empty(len(vertices), dtype=int)
        place[order] = np.arange(len(vertices))
        v = int(faces[0, 0])
        expected = np.asarray(FastMarchingDistance(TriangleMesh(vertices, faces)).from_vertices([v])["distance"])
        renumbered = TriangleMesh(vertices[order], place[faces][rng.permutation(len(faces))])
        found = np.asarray(FastMarchingDistance(renumbered).from_vertices([int(place[v])])["distance"])[place]
        np.testing.assert_allclose(found, expected, rtol=2e-3)


def test_visits_end() -> None:
    """On very long triangles, where distances are corrected often, each vertex is visited a bounded number of times."""
    from scipy.spatial import Delaunay

    points = np.random.default_rng(1).random((3000, 2))
    vertices = np.column_stack([points * [1, 0.01], 0.003 * np.sin(9 * points[:, 0])])
    mesh = TriangleMesh(vertices, Delaunay(points).simplices)
    solver, sources = FastMarchingDistance(mesh), np.array([5])
    march, angles = empty_march(solver.surface), no_angles(solver.surface)
    start(solver.surface, angles, march, sources)
    propagate(solver.surface, angles, march, Extent(np.inf, 0.0, np.zeros(mesh.n_vertices)), sources[:0])
    visits = np.log(march.tolerance / TOLERANCE) / np.log(GROWTH)
    assert visits.min() >= 1
    assert visits.max() <= 50
    assert visits.mean() < 5
