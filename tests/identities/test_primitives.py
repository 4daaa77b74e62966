"""Built-in meshes: counts, topology, orientation, and vertices on the exact surface."""

import numpy as np
import pytest

from geomhw.mesh import genus_two, implicit_surface, primitives
from support.meshes import volume

CLOSED = {
    "icosahedron": (primitives.icosphere(0), 0),
    "icosphere": (primitives.icosphere(3, radius=2.0), 0),
    "torus": (primitives.torus(40, 20), 1),
    "genus two": (genus_two(), 2),
    "contoured ball": (
        implicit_surface(lambda x, y, z: x**2 + y**2 + z**2 - 1, [-1.3] * 3, [1.2] * 3, 20),
        0,
    ),
}


def double_torus(p: np.ndarray) -> np.ndarray:
    x, y, z = p.T
    return (x * (x - 1) ** 2 * (x - 2) + y**2) ** 2 + z**2 - 0.15**2


@pytest.mark.parametrize("name", CLOSED)
def test_closed_surface(name):
    """Each surface is closed, manifold and oriented outward, with χ = 2 - 2g."""
    mesh, genus = CLOSED[name]
    assert mesh.is_closed
    assert mesh.is_edge_manifold
    assert mesh.is_oriented
    assert (mesh.euler_characteristic, mesh.genus) == (2 - 2 * genus, genus)
    assert volume(mesh) > 0


@pytest.mark.parametrize("name", CLOSED)
def test_triangles_are_well_shaped(name):
    """Angles are above 15°, and fewer than 1 % of the cotan weights are negative."""
    mesh = CLOSED[name][0]
    assert np.degrees(mesh.angles.min()) > 15
    assert np.mean(mesh.edge_cotan_weights < -1e-12) < 0.01


@pytest.mark.parametrize("level", range(5))
def test_icosphere_counts(level):
    """An icosphere has 10·4^k + 2 vertices on the sphere, and keeps those of the coarser level."""
    mesh = primitives.icosphere(level, radius=3.0)
    assert (mesh.n_vertices, mesh.n_faces) == (10 * 4**level + 2, 20 * 4**level)
    np.testing.assert_allclose(np.linalg.norm(mesh.vertices, axis=1), 3.0, rtol=1e-15)
    # Subdivision keeps the vertices of the coarser level.
    coarser = primitives.icosphere(max(level - 1, 0), radius=3.0).vertices
    np.testing.assert_allclose(mesh.vertices[: len(coarser)], coarser, rtol=1e-15)


def test_torus_lies_on_the_torus():
    """Vertices satisfy the equation of the torus."""
    x, y, z = primitives.torus(30, 12, major=2.0, minor=0.5).vertices.T
    np.testing.assert_allclose((np.hypot(x, y) - 2.0) ** 2 + z**2, 0.25, rtol=1e-12)


def test_genus_two_lies_on_its_surface():
    """The distance f/|∇f| of the vertices to the surface is rounding."""
    p = CLOSED["genus two"][0].vertices
    step = 1e-6 * np.eye(3)
    gradient = np.stack([(double_torus(p + e) - double_torus(p - e)) / 2e-6 for e in step], axis=1)
    assert np.max(np.abs(double_torus(p)) / np.linalg.norm(gradient, axis=1)) < 1e-10


@pytest.mark.parametrize("diagonal", ["alternating", "uniform"])
def test_grid(diagonal):
    """A grid has the expected counts, areas and normals, for both diagonals."""
    mesh = primitives.grid(4, 3, width=2.0, height=6.0, diagonal=diagonal)
    assert (mesh.n_vertices, mesh.n_faces, mesh.euler_characteristic) == (20, 24, 1)
    np.testing.assert_allclose(mesh.face_normals, [[0, 0, 1]] * 24, atol=1e-15)
    np.testing.assert_allclose(mesh.face_areas, 0.5)
    np.testing.assert_array_equal(mesh.vertices[4 + 1 + 2], [1.0, 2.0, 0.0])


def test_strip():
    """A strip has the expected counts and size."""
    mesh = primitives.strip(3000)
    assert (mesh.n_vertices, mesh.n_faces) == (2 * 3001, 6000)
    np.testing.assert_array_equal(np.ptp(mesh.vertices, axis=0), [3000, 1, 0])


def test_bands():
    """A cylinder has two boundary loops and two sides, a Möbius band one side."""
    cylinder, moebius = primitives.cylinder_band(12, 3), primitives.moebius_band(30, 4)
    assert (cylinder.n_vertices, cylinder.euler_characteristic, len(cylinder.boundary_loops)) == (48, 0, 2)
    assert np.all(np.einsum("fx,fx->f", cylinder.face_normals, cylinder.face_centers * [1, 1, 0]) > 0)
    assert (moebius.n_vertices, moebius.euler_characteristic) == (150, 0)
    assert not moebius.is_orientable
    assert moebius.n_components == 1


def test_implicit_surface_is_independent_of_scale():
    """A ball scaled by 1e-6 has the same faces and scaled vertices."""

    def ball(scale):
        return implicit_surface(
            lambda x, y, z: (x**2 + y**2 + z**2) / scale**2 - 1, [-1.3 * scale] * 3, [1.2 * scale] * 3, 10
        )

    np.testing.assert_array_equal(ball(1.0).faces, ball(1e-6).faces)
    np.testing.assert_allclose(ball(1.0).vertices, ball(1e-6).vertices * 1e6, atol=1e-9)
