"""Killing fields: their number on spheres, surfaces of revolution and flat tori, symmetries, and other metrics."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import ConvexHull, Delaunay
from scipy.spatial.transform import Rotation

from geomhw.flow import rigid_field
from geomhw.intrinsic import IntrinsicMesh
from geomhw.mesh.primitives import cylinder_band, grid, icosphere, torus
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators import hat_gradients
from geomhw.spectral import KillingFields, killing_fields
from support.rates import fitted_rate


def random_sphere(count: int) -> TriangleMesh:
    """Return the triangulation of random points on the unit sphere."""
    points = np.random.default_rng(1).normal(size=(count, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    faces = ConvexHull(points).simplices.copy()
    inward = np.linalg.det(points[faces]) < 0
    faces[inward] = faces[inward][:, ::-1]
    return TriangleMesh(points, faces)


def random_torus(count: int) -> TriangleMesh:
    """Return the triangulation of random points on a torus of revolution with radii 1 and 0.4."""
    angles = 2 * np.pi * np.random.default_rng(3).random((count, 2))
    turns = 2 * np.pi * (np.indices((3, 3)).reshape(2, -1).T - 1)
    copies = (angles + turns[:, None]).reshape(-1, 2)
    faces = Delaunay(copies * [1, 0.4]).simplices
    middle = copies[faces].mean(axis=1)
    faces = faces[((middle >= 0) & (middle < 2 * np.pi)).all(axis=1)] % count
    u, v = angles.T
    r = 1 + 0.4 * np.cos(v)
    return TriangleMesh(np.stack([r * np.cos(u), r * np.sin(u), 0.4 * np.sin(v)], axis=1), faces)


def waisted() -> TriangleMesh:
    """Return an open surface of revolution whose radius depends on the height."""
    band = cylinder_band(48, 16, height=3)
    return TriangleMesh(band.vertices * (1 + 0.3 * band.vertices[:, 2:] ** 2) ** [1, 1, 0], band.faces)


def bump() -> TriangleMesh:
    """Return a sphere with a bump beside its poles."""
    ball = icosphere(3)
    place = np.array([0.5, 0.3, 0.8])
    height = 0.6 * np.exp(-8 * ((ball.vertices - place) ** 2).sum(axis=1)) + 0.4 * ball.vertices[:, 0] ** 3
    return TriangleMesh(ball.vertices * (1 + height)[:, None], ball.faces)


SURFACES = {
    "icosphere": (icosphere(2), 3),
    "random sphere": (random_sphere(400), 3),
    "spheroid": (TriangleMesh(icosphere(2).vertices * [1, 1, 2], icosphere(2).faces), 1),
    "torus": (torus(32, 16), 1),
    "random torus": (random_torus(900), 1),
    "cylinder": (cylinder_band(40, 15, height=2), 1),
    "oval cylinder": (TriangleMesh(cylinder_band(40, 15).vertices * [1.6, 0.7, 1], cylinder_band(40, 15).faces), 1),
    "waisted": (waisted(), 1),
    "square": (grid(16, 16), 0),
    "bump": (bump(), 0),
}


@pytest.mark.parametrize("name", SURFACES)
def test_number_of_killing_fields(name: str) -> None:
    """The number below the gap is that of the smooth surface, also after a turn, a rescaling and a renumbering."""
    mesh, expected = SURFACES[name]
    problem = KillingFields(mesh)
    energies = problem.pairs(4).values
    count, ratio = problem.gap(energies)
    assert count == expected
    assert ratio > 300 or not expected
    chance = np.random.default_rng(5)
    order = chance.permutation(mesh.n_vertices)
    points = 1e-6 * Rotation.from_rotvec([1, 2, 3]).apply(mesh.vertices.copy()) + 2e-6
    faces = np.argsort(order)[mesh.faces][chance.permutation(mesh.n_faces)]
    moved = KillingFields(TriangleMesh(points[order], faces))
    again = moved.pairs(4).values
    assert moved.gap(again)[0] == expected
    np.testing.assert_allclose(again[expected:], 1e12 * energies[expected:], rtol=1e-7)


def test_rotations_of_the_sphere_and_energies_above_the_gap() -> None:
    """The span of the three fields is that of the rotations; the next energy is 1 = l(l+1)/4 - ½, second order."""
    errors = []
    for level in (1, 2, 3):
        mesh = icosphere(level)
        result = killing_fields(mesh, 6)
        energies = np.array(result.report["energies"])
        assert energies[2] < 1e-4 * 4.0**-level
        errors.append(float(np.abs(energies[3:] - 1).max()))
        fields = np.stack([field.values for field in result.fields], axis=-1)
        products = np.einsum("fxi,fxj,f->ij", fields, fields, mesh.face_areas)
        np.testing.assert_allclose(products, np.eye(6), atol=3 * 4.0**-level)
        np.testing.assert_allclose(np.diag(products), 1, atol=1e-12)
    assert fitted_rate([1 / 2, 1 / 4, 1 / 8], errors) > 1.8
    spin = rigid_field(mesh, [0, 0, 1.0])
    spin /= np.sqrt(np.einsum("fx,fx,f->", spin, spin, mesh.face_areas))
    along = np.einsum("fxi,fx,f->i", fields[..., :3], spin, mesh.face_areas)
    assert np.linalg.norm(along) > 1 - 1e-3
    shares = result.report["shares"]
    assert max(shares["gradient"][:3]) < 1e-6
    assert min(shares["coexact"][:3]) > 1 - 1e-6


def test_energy_of_a_rotation_vanishes_with_fourth_order() -> None:
    """On random triangulations the energy of Killing fields falls at least with the fourth power of the edge length."""
    found = [float(KillingFields(random_sphere(count)).pairs(3).values[2]) for count in (150, 300, 600)]
    assert fitted_rate([1.0, 2**-0.5, 0.5], found) > 4


def test_flat_torus() -> None:
    """A torus with a flat metric, by edge lengths alone, has two parallel fields: of energy zero to rounding."""
    ring = torus(24, 16)
    x, y, z = ring.vertices.T
    u, v = np.arctan2(y, x), np.arctan2(z, np.hypot(x, y) - 1)
    points = np.stack([np.cos(u), np.sin(u), np.cos(v), np.sin(v)], axis=1)
    i, j = ring.edges.T
    flat = replace(IntrinsicMesh.of(ring), lengths=np.linalg.norm(points[j] - points[i], axis=1))
    problem = KillingFields(flat)
    pairs = problem.pairs(4)
    assert problem.gap(pairs.values) == (2, pytest.approx(1e11, rel=10))
    assert pairs.values[1] < 1e-13
    assert pairs.values[2] > 0.1
    result = killing_fields(ring, 2, surface=flat)
    # The field of the torus in space has the same barycentric coordinates as a field of constant length in the other.
    change = np.einsum("fkx,fx->fk", hat_gradients(ring), result["killing_0"])
    length = np.linalg.norm(np.einsum("fk,fkx->fx", change, points[ring.faces]), axis=1)
    assert np.ptp(length) < 1e-9 * length.max()


def test_crumpled_strip_is_flat() -> None:
    """On a sharply folded cylinder, where normals mean nothing, the flat metric gives the exact rotation."""
    band = cylinder_band(12, 4)
    folds = np.where(np.arange(60) % 2, 0.4, 1.0)[:, None] ** [1, 1, 0]
    sharp = TriangleMesh(band.vertices * folds, band.faces)
    report = killing_fields(sharp, 3).report
    assert report["connection"] == "intrinsic"
    assert report["gap"]["fields"] == 1
    assert report["energies"][0] < 1e-12


def test_free_boundary() -> None:
    """Without a condition at the boundary a bent rectangle has the three motions of the plane, a cylinder two."""
    sheet = grid(20, 10, np.pi, 1.0)
    u, h, _ = sheet.vertices.T
    bent = TriangleMesh(np.stack([np.cos(u), np.sin(u), h], axis=1), sheet.faces)
    assert killing_fields(bent, 4, "free").report["gap"]["fields"] == 3
    assert killing_fields(cylinder_band(24, 8), 4, "free").report["gap"]["fields"] == 2
    for connection in ("normals", "intrinsic"):
        assert killing_fields(bent, 4, "free", connection).report["gap"]["fields"] == 3


def test_several_components() -> None:
    """Three rotations for each of two spheres of different size, and none for vertices without faces."""
    ball = icosphere(2)
    n = ball.n_vertices
    points = np.concatenate([ball.vertices, 3 * ball.vertices + 9, [[50.0, 0, 0]]])
    mesh = TriangleMesh(points, np.concatenate([ball.faces, ball.faces + n]))
    assert killing_fields(mesh, 6).report["gap"]["fields"] == 6


def test_coexact_basis() -> None:
    """Combinations of coexact and harmonic fields have no divergence to rounding, and the same number below the gap."""
    for mesh, expected in ((icosphere(2), 3), (torus(24, 12), 1), (cylinder_band(24, 8, height=2), 1)):
        report = killing_fields(mesh, 4, basis="coexact").report
        assert report["gap"]["fields"] == expected
        assert max(report["shares"]["gradient"]) < 1e-20


def mirror_of(mesh: TriangleMesh, signs: list[int]) -> np.ndarray:
    """Return the vertex map of a reflection in coordinate planes."""
    gaps = np.linalg.norm(mesh.vertices[:, None] * signs - mesh.vertices, axis=2)
    assert gaps.min(axis=1).max() < 1e-12
    return gaps.argmin(axis=1)


def test_symmetric_and_antisymmetric_fields() -> None:
    """A mirror keeps one rotation of the sphere and reverses two; a half turn keeps one as well."""
    mesh = icosphere(2)
    mirror, half_turn = mirror_of(mesh, [1, 1, -1]), mirror_of(mesh, [-1, -1, 1])
    spin = rigid_field(mesh, [0, 0, 1.0])
    for symmetry in (mirror, half_turn):
        kept = killing_fields(mesh, 3, symmetric=symmetry)
        assert kept.report["gap"]["fields"] == 1
        cosine = np.einsum("fx,fx,f->", kept["killing_0"], spin, mesh.face_areas)
        assert abs(cosine) == pytest.approx(np.sqrt(np.einsum("fx,fx,f->", spin, spin, mesh.face_areas)), rel=1e-3)
        turned = killing_fields(mesh, 3, antisymmetric=symmetry)
        assert turned.report["gap"]["fields"] == 2
        assert abs(np.einsum("fx,fx,f->", turned["killing_0"], spin, mesh.face_areas)) < 1e-6
    with_basis = killing_fields(mesh, 3, basis="coexact", eigenfields=40, antisymmetric=mirror)
    assert with_basis.report["gap"]["fields"] == 2
