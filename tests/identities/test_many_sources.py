"""Distances from many sources equal those from single sources, for all options."""

import numpy as np
import pytest

from geomhw.errors import FieldError
from geomhw.geodesic.edge_path_bound import EdgePathBound
from geomhw.geodesic.edge_paths import edge_path_distance
from geomhw.geodesic.heat_method import HeatDistance
from geomhw.io import read_mesh
from geomhw.mesh.named_points import face_point, vertex_points
from geomhw.mesh.primitives import grid, icosphere, strip, torus
from geomhw.mesh.surface_points import SurfacePoints, concatenate
from geomhw.mesh.triangle_mesh import TriangleMesh
from support.meshes import ZOO, sheared, split_diagonals, two_spheres, zoo_mesh
from support.reference import needs_reference, reference

OPTIONS = {
    "plain": {},
    "sqrt-h": {"time": "sqrt-h"},
    "short": {"time": "0.05*h2"},
    "long": {"time": "50*h2"},
    "robust": {"robust": True, "refine": False},
    "refined": {"refine": True},
    "cold": {"boundary": "dirichlet"},
    "average": {"boundary": "average", "robust": True},
    "iterated": {"solver": "multigrid"},
}


def some_sources(mesh: TriangleMesh, count: int = 12) -> list[SurfacePoints]:
    """Return vertices that have faces, off the boundary where possible."""
    used = np.setdiff1d(np.arange(mesh.n_vertices), mesh.unreferenced_vertices)
    inner = np.setdiff1d(used, mesh.boundary_vertices)
    chosen = np.unique(np.random.default_rng(0).choice(inner if len(inner) else used, count))
    return [vertex_points(mesh, [v]) for v in chosen.tolist()]


def assert_rows_agree(mesh: TriangleMesh, queries: list[SurfacePoints], **options: object) -> None:
    """Check rows against single sources, to 1e-9 of the largest distance."""
    solver = HeatDistance(mesh, queries=1000, **({"time": "h2"} | options))  # type: ignore[arg-type]
    rows = solver.rows(queries)
    for row, query in zip(rows, queries, strict=True):
        expected = np.asarray(solver.from_sources(query)["distance"])
        size = expected[np.isfinite(expected)].max()
        np.testing.assert_allclose(row, expected, rtol=0, atol=1e-9 * size)


@pytest.mark.parametrize("name", sorted(ZOO))
@pytest.mark.parametrize("options", OPTIONS)
def test_rows(name: str, options: str) -> None:
    """Rows equal single distances on every mesh of the zoo, or raise as they do."""
    mesh = zoo_mesh(name)
    if OPTIONS[options].get("boundary") == "dirichlet" and len(mesh.boundary_vertices) == mesh.n_vertices:
        with pytest.raises(FieldError, match="kept cold"):
            HeatDistance(mesh, "h2", queries=1000, boundary="dirichlet").rows(some_sources(mesh))
        return
    assert_rows_agree(mesh, some_sources(mesh), **OPTIONS[options])


def test_rows_of_all_vertices() -> None:
    """Rows agree for more sources than a block, and on the boundary."""
    mesh = grid(11, 9)
    every = [vertex_points(mesh, [v]) for v in range(mesh.n_vertices)]
    assert_rows_agree(mesh, every, boundary="average")
    assert_rows_agree(torus(16, 10), [vertex_points(torus(16, 10), [v]) for v in range(160)])


def test_rows_beyond_the_reach_of_doubles() -> None:
    """Rows where heat underflows are solved again with scaling, without effect on the others."""
    mesh = strip(1000)
    middle = int(np.abs(mesh.vertices[:, 0] - mesh.vertices[:, 0].mean()).argmin())
    assert_rows_agree(mesh, [vertex_points(mesh, [v]) for v in (0, 1, middle, middle + 1, 2001)])
    solver = HeatDistance(mesh, "h2", queries=9)
    assert solver._many_sources is not None
    np.testing.assert_array_equal(solver._many_sources(np.array([0, middle]))[1], [False, True])


def test_rows_of_other_sources() -> None:
    """Rows of several vertices and of points within faces keep their order."""
    mesh = icosphere(3)
    points = [
        vertex_points(mesh, [5]),
        face_point(mesh, 17),
        vertex_points(mesh, [5, 600]),
        vertex_points(mesh, [0]),
    ]
    assert_rows_agree(mesh, [*points, concatenate(points[:2])])
    assert_rows_agree(mesh, [*points, concatenate(points[:2])], robust=True)


def test_rows_on_hostile_meshes() -> None:
    """Rows agree on slivers, faces of zero area and several components."""
    for mesh, options in ((sheared(), {"robust": True}), (split_diagonals(), {"robust": True}), (sheared(), {})):
        assert_rows_agree(mesh, some_sources(mesh), refine=False, **options)
    rows = HeatDistance(two_spheres(), "h2", queries=9).rows([vertex_points(two_spheres(), [v]) for v in (0, 200)])
    np.testing.assert_array_equal(np.isinf(rows).sum(axis=1), [163, 163])


def test_one_row_does_not_depend_on_the_others() -> None:
    """A row depends on the other sources by rounding only; repeated runs are bit-identical."""
    mesh = torus(30, 20)
    queries = some_sources(mesh, 70)
    solver = HeatDistance(mesh, "h2", queries=1000)
    rows = solver.rows(queries)
    np.testing.assert_array_equal(HeatDistance(mesh, "h2", queries=1000).rows(queries), rows)
    np.testing.assert_allclose(solver.rows(queries[3:5]), rows[3:5], rtol=0, atol=1e-13 * rows.max())


@needs_reference
@pytest.mark.parametrize("file", ["kitten.obj", "fandisk.obj", "moomoo.off"])
@pytest.mark.parametrize("options", ["plain", "robust"])
def test_rows_on_real_meshes(file: str, options: str) -> None:
    """Rows agree on real meshes."""
    mesh = read_mesh(reference(f"meshes/closed/{file}"))
    assert_rows_agree(mesh, some_sources(mesh, 5), **OPTIONS[options])


# -- the bound along edges --------------------------------------------------------------------------------------------


def bounded(mesh: TriangleMesh, phi: np.ndarray, sources: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return functions clamped by `EdgePathBound`, and by a search along edges each."""
    found = np.array(phi)
    expected = np.stack(
        [np.minimum(found[:, c], edge_path_distance(mesh, sources[[c]])) for c in range(len(sources))], axis=1
    )
    EdgePathBound(mesh)(found, sources)
    return found, expected


@pytest.mark.parametrize("name", ["sphere", "torus", "grid", "strip", "crumpled_torus", "tetrahedron", "annulus"])
@pytest.mark.parametrize("stretch", [0.9, 1.0, 1.01, 1.1, 2.0, -1.0])
def test_bound_along_edges(name: str, stretch: float) -> None:
    """The bound equals the search along edges, for functions below, at and above the distance."""
    mesh = zoo_mesh(name)
    rng = np.random.default_rng(1)
    sources = rng.integers(0, mesh.n_vertices, 6)
    straight = np.linalg.norm(mesh.vertices[:, None] - mesh.vertices[sources], axis=2)
    for bumps in (0.0, 0.02, 0.5):
        phi = stretch * straight * (1 + bumps * np.sin(9 * mesh.vertices[:, :1] + np.arange(6)))
        found, expected = bounded(mesh, phi, sources)
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * np.abs(phi).max())


def test_bound_along_a_line_of_edges() -> None:
    """A slope of 1 + 1e-3 along the edges of a grid is clamped there; elsewhere nothing changes."""
    mesh = grid(20, 20)
    phi = 1.001 * np.linalg.norm(mesh.vertices - mesh.vertices[0], axis=1)[:, None]
    found, expected = bounded(mesh, phi, np.array([0]))
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12)
    assert np.count_nonzero(found < phi) >= 40
    assert np.count_nonzero(found == phi) > 300
