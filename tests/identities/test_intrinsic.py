"""Identities of intrinsic triangulations: flips, Delaunay weights, tufted covers, mollification."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.spatial import Delaunay

from geomhw.geodesic.edge_paths import edge_path_distance
from geomhw.geodesic.heat_method import HeatDistance
from geomhw.intrinsic.delaunay import intrinsic_delaunay
from geomhw.intrinsic.divided_faces import divided_faces
from geomhw.intrinsic.intrinsic_mesh import IntrinsicMesh, mollified
from geomhw.intrinsic.robust import RobustTriangulation
from geomhw.intrinsic.tufted_cover import tufted_cover
from geomhw.io import read_mesh
from geomhw.mesh.geometry import corner_sum, heron_areas
from geomhw.mesh.polyhedral import PolyhedralSurface
from geomhw.mesh.primitives import grid, icosphere, moebius_band
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.divergence import divergence
from geomhw.operators.gradient import gradient
from geomhw.operators.laplacian import stiffness
from geomhw.operators.mass import consistent_mass, lumped_mass
from support.hostile import far_away
from support.meshes import ZOO, book, sheared, spiky, zoo_mesh
from support.reference import needs_reference, reference


def turned_over(mesh: TriangleMesh) -> TriangleMesh:
    """Flip every third face."""
    faces = mesh.faces.copy()
    faces[::3] = faces[::3, ::-1]
    return TriangleMesh(mesh.vertices, faces)


def flattened() -> TriangleMesh:
    """Return a sphere pressed to a disc of two layers, with a ring of faces of zero area."""
    ball = icosphere(3)
    return TriangleMesh(ball.vertices * [1, 1, 0], ball.faces)


HOSTILE: dict[str, Callable[[], TriangleMesh]] = {
    **{name: lambda name=name: zoo_mesh(name) for name in ZOO},  # type: ignore[misc]
    "spiky": spiky,
    "needle": lambda: TriangleMesh(icosphere(3).vertices * [1, 0.02, 0.02], icosphere(3).faces),
    "sheared": sheared,
    "book": book,
    "moebius": lambda: moebius_band(30, 5),
    "turned_over": lambda: turned_over(spiky()),
    "flattened": flattened,
    "on_a_line": lambda: TriangleMesh(icosphere(2).vertices * [1, 0, 0], icosphere(2).faces),
}
_made: dict[str, tuple[TriangleMesh, RobustTriangulation]] = {}


@pytest.fixture(params=HOSTILE)
def robust(request: pytest.FixtureRequest) -> tuple[TriangleMesh, RobustTriangulation]:
    """Each mesh of the zoo, and worse ones, with its robust triangulation."""
    if request.param not in _made:
        mesh = HOSTILE[request.param]()
        _made[request.param] = mesh, RobustTriangulation.of(mesh)
    return _made[request.param]


def unflipped(mesh: TriangleMesh, sheets: int) -> IntrinsicMesh:
    """Return the triangulation before the flips."""
    grown = mollified(IntrinsicMesh.of(mesh))[0]
    return tufted_cover(grown) if sheets == 2 else grown


def angle_sums(surface: PolyhedralSurface) -> np.ndarray:
    return corner_sum(surface.angles, surface.faces, surface.n_vertices)


def test_flips_keep_the_surface(robust: tuple[TriangleMesh, RobustTriangulation]) -> None:
    """Flips keep area and the angle sum round each vertex."""
    mesh, done = robust
    before, after = unflipped(mesh, done.surface.sheets), done.surface
    # The area of a sliver with excess 1e-5 has the rounding of a length divided by the excess.
    assert after.face_areas.sum() == pytest.approx(before.face_areas.sum(), rel=1e-10 if done.mollification else 1e-12)
    turns = angle_sums(before).max()
    np.testing.assert_allclose(
        angle_sums(after), angle_sums(before), rtol=0, atol=turns * (1e-9 if done.mollification else 1e-11)
    )
    assert after.vertex_areas.sum() == pytest.approx(before.face_areas.sum() / after.sheets, rel=1e-9)


def test_flips_keep_the_complex(robust: tuple[TriangleMesh, RobustTriangulation]) -> None:
    """Each edge has two sides; flips keep the Euler characteristic and the components."""
    mesh, done = robust
    before, after = unflipped(mesh, done.surface.sheets), done.surface
    table = after.edge_table
    assert (np.bincount(table.of_faces.ravel(), minlength=after.n_edges) == 2).all()
    ends = np.stack([np.roll(after.faces, -1, axis=1), np.roll(after.faces, -2, axis=1)], axis=2)
    np.testing.assert_array_equal(np.sort(ends, axis=2), table.vertices[table.of_faces])
    assert after.euler_characteristic == before.euler_characteristic
    assert after.n_components == mesh.n_components
    np.testing.assert_array_equal(after.unreferenced_vertices, mesh.unreferenced_vertices)


def test_no_weight_is_negative(robust: tuple[TriangleMesh, RobustTriangulation]) -> None:
    """All cotan weights are nonnegative, so the stiffness is an M-matrix."""
    _, done = robust
    S = stiffness(done.surface)
    largest = S.diagonal().max()
    assert done.surface.edge_cotan_weights.min() > -1e-12 * largest
    assert (S - sp.diags_array(S.diagonal())).max() < 1e-12 * largest


def test_operators_on_it(robust: tuple[TriangleMesh, RobustTriangulation]) -> None:
    """Div G = -S, constants have no gradient, and masses hold the area, also with loops and multiple edges."""
    mesh, done = robust
    surface = done.surface
    G, S = gradient(surface), stiffness(surface)
    size = abs(S).max()
    assert abs(divergence(surface) @ G + S).max() < 1e-10 * size
    ones = np.ones(surface.n_vertices)
    assert np.abs(G @ ones).max() < 1e-10 * abs(G).max()
    np.testing.assert_allclose(consistent_mass(surface) @ ones, lumped_mass(surface) @ ones, rtol=1e-12)
    if not done.mollification:
        assert (lumped_mass(surface) @ ones).sum() == pytest.approx(mesh.face_areas.sum(), rel=1e-12)


def test_edges_may_end_where_they_start() -> None:
    """These triangulations have edges from a vertex to itself, and several edges between two vertices."""
    for mesh in (spiky(), sheared()):
        surface = RobustTriangulation.of(mesh).surface
        assert (surface.edges[:, 0] == surface.edges[:, 1]).any()
        assert len(np.unique(surface.edges, axis=0)) < surface.n_edges


def test_random_diagonals_of_a_flat_grid() -> None:
    """Random diagonals of a flat grid are flipped to the planar Delaunay triangulation."""
    n, rng = 14, np.random.default_rng(4)
    square = grid(n, n, n, n)
    points = square.vertices.copy()
    inner = np.setdiff1d(np.arange(len(points)), square.boundary_vertices)
    points[inner, :2] += rng.uniform(-0.2, 0.2, (len(inner), 2))
    j, i = np.indices((n, n)).reshape(2, -1)
    a = j * (n + 1) + i
    quads = np.stack([a, a + 1, a + n + 2, a + n + 1], axis=1)
    quads = np.where(rng.random(len(quads))[:, None] < 0.5, quads, np.roll(quads, 1, axis=1))
    mesh = TriangleMesh(points, quads[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3))
    done = RobustTriangulation.of(mesh)
    expected = np.unique(np.sort(Delaunay(points[:, :2]).simplices, axis=1), axis=0)
    np.testing.assert_array_equal(np.unique(np.sort(done.surface.faces, axis=1), axis=0), expected)
    # On a flat convex piece an intrinsic edge is the straight one.
    start, end = points[done.surface.edges].transpose(1, 0, 2)
    np.testing.assert_allclose(done.surface.lengths, np.linalg.norm(end - start, axis=1), rtol=1e-13)
    kept = np.isin(mesh.edges @ [1, 1000], done.surface.edges @ [1, 1000])
    assert done.flips == 2 * np.count_nonzero(~kept)


def test_a_quad_is_flipped_once() -> None:
    """The long diagonal of a rhombus is flipped to the short one, once."""
    rhombus = TriangleMesh([[-1, 0, 0], [1, 0, 0], [0, 0.1, 0], [0, -0.1, 0]], [[0, 1, 2], [1, 0, 3]])
    done = RobustTriangulation.of(rhombus)
    assert done.flips == 2
    np.testing.assert_allclose(np.sort(done.surface.lengths)[:2], 0.2, rtol=1e-14)


def test_delaunay_is_left_alone() -> None:
    """On a Delaunay mesh nothing changes, to the last bit."""
    ball = icosphere(3)
    done = RobustTriangulation.of(ball)
    assert (done.flips, done.mollification) == (0, 0)
    np.testing.assert_array_equal(done.surface.faces, ball.faces)
    np.testing.assert_array_equal(done.surface.lengths, ball.edge_lengths)
    assert abs(stiffness(done.surface) - stiffness(ball)).max() < 1e-13


@pytest.mark.parametrize("name", ["grid", "annulus", "two_spheres", "strip", "crumpled_torus"])
def test_two_sides_are_the_mesh_twice(name: str) -> None:
    """Averaged over the tufted cover, stiffness, mass and edge paths are those of the mesh."""
    mesh = zoo_mesh(name)
    double = tufted_cover(IntrinsicMesh.of(mesh))
    assert double.is_closed
    assert double.is_oriented
    S = stiffness(mesh)
    assert abs(stiffness(double) - S).max() < 1e-12 * abs(S).max()
    np.testing.assert_allclose(double.vertex_areas, mesh.vertex_areas, rtol=1e-13)
    source = np.array([3])
    np.testing.assert_allclose(edge_path_distance(double, source), edge_path_distance(mesh, source), rtol=1e-14)


@pytest.mark.parametrize("factor", [2.0**-20, 2.0**20])
def test_scale_does_not_matter(factor: float) -> None:
    """Flips and mollification are the same on a mesh scaled by a power of two."""
    for mesh in (spiky(), flattened()):
        one = RobustTriangulation.of(mesh)
        other = RobustTriangulation.of(TriangleMesh(mesh.vertices * factor, mesh.faces))
        assert other.mollification == one.mollification * factor
        assert other.flips == one.flips
        np.testing.assert_array_equal(other.surface.lengths, factor * one.surface.lengths)


def test_mollification_is_the_least() -> None:
    """Mollification gives the flattest face an excess of 1e-5 h, and leaves good meshes unchanged."""
    flat = IntrinsicMesh.of(flattened())
    grown, epsilon = mollified(flat)
    sides = grown.lengths[grown.gluing.of_faces]
    excess = sides.sum(axis=1) - 2 * sides.max(axis=1)
    assert excess.min() == pytest.approx(1e-5 * flat.mean_edge_length, rel=1e-8)
    np.testing.assert_allclose(grown.lengths - flat.lengths, epsilon, rtol=1e-9)
    good = IntrinsicMesh.of(icosphere(2))
    assert mollified(good) == (good, 0.0)


def test_heron_on_needles() -> None:
    """Heron's formula is accurate to rounding on needles, and gives zero where sides do not close."""
    areas = heron_areas(np.array([[3.0, 4, 5], [1.0, 1.0, 1e-12], [1.0, 1.0, 3.0]]))
    np.testing.assert_allclose(areas, [6, 5e-13, 0], rtol=1e-15)


def test_flips_repeat() -> None:
    """The same mesh gives the same triangulation, to the last bit."""
    one, other = (intrinsic_delaunay(IntrinsicMesh.of(spiky()))[0] for _ in range(2))
    np.testing.assert_array_equal(one.lengths, other.lengths)
    np.testing.assert_array_equal(one.faces, other.faces)


@needs_reference
@pytest.mark.parametrize(
    ("name", "flips"),
    [("camelhead.off", 12000), ("ogre.obj", 30000), ("lego.ply", 150), ("triple_vierbein.obj", 0)],
)
def test_real_meshes(name: str, flips: int) -> None:
    """Flips on real meshes end within the stated number of flips."""
    from geomhw.io import read_mesh

    done = RobustTriangulation.of(read_mesh(reference(f"meshes/hostile/{name}")))
    weights = done.surface.edge_cotan_weights
    assert weights.min() > -1e-12 * weights.max()
    assert flips <= done.flips <= 1.3 * flips


@pytest.mark.parametrize("refine", [True, False])
def test_far_away(refine: bool) -> None:
    """On a torus whose trapezoids may have either diagonal, a translation by 1e6 sizes changes no choice."""
    mesh = read_mesh(Path(__file__).parents[2] / "data" / "torus.off")
    far = TriangleMesh(*far_away((mesh.vertices, mesh.faces)))
    near, moved = (HeatDistance(m, "h2", robust=True, refine=refine).from_vertices([0]) for m in (mesh, far))
    np.testing.assert_allclose(moved["distance"], near["distance"], atol=1e-8 * near["distance"].max())


@pytest.mark.parametrize("name", ["mesh", "tufted cover", "loops"])
def test_divided_faces_are_the_same_surface(name: str) -> None:
    """Operators on faces divided into four, restricted to functions that are linear on each face, are those given."""
    surface: PolyhedralSurface = icosphere(2) if name == "mesh" else tufted_cover(IntrinsicMesh.of(book()))
    if name == "loops":
        surface = RobustTriangulation.of(spiky()).surface
    fine, n = divided_faces(surface), surface.n_vertices
    i, j = surface.edges.T
    middles = np.arange(n, fine.n_vertices)
    at = np.concatenate([np.arange(n), middles, middles]), np.concatenate([np.arange(n), i, j])
    linear = sp.csr_array((np.r_[np.ones(n), np.full(2 * len(middles), 0.5)], at))
    for operator in (stiffness, consistent_mass):
        expected = operator(surface).toarray()
        np.testing.assert_allclose(
            (linear.T @ operator(fine) @ linear).toarray(), expected, atol=1e-12 * np.abs(expected).max()
        )
