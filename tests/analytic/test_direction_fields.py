"""Direction fields: index sums, known energies and fields, constraints, prescribed singularities, vertex maps."""

from collections.abc import Callable

import numpy as np
import pytest

from geomhw.directions import (
    DirectionFields,
    combined,
    commuting,
    directions_along,
    directions_along_boundary,
    directions_at,
    joint_fields,
    principal_target,
    trivial_connection,
)
from geomhw.errors import ConvergenceError
from geomhw.mesh.implicit_surfaces import genus_two
from geomhw.mesh.named_points import vertex_points
from geomhw.mesh.primitives import cylinder_band, grid, icosphere, torus
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.results import Result
from geomhw.spectral import smallest_eigenpairs
from support.meshes import annulus, disc
from support.reference import needs_reference, reference


def smoothest(mesh: TriangleMesh, n: int, s: float = 0.0) -> Result:
    """Return the smoothest field."""
    fields = DirectionFields(mesh, n, s)
    return fields.result(fields.smoothest())


def wrong_angles(found: np.ndarray, expected: np.ndarray, n: int) -> np.ndarray:
    """Return the angle, (n_vertices,), between unit vectors up to the turns of a field of n directions."""
    cosines = np.clip(np.einsum("ix,ix->i", found, expected), -1, 1)
    angle = np.arccos(cosines) % (2 * np.pi / n)
    return np.minimum(angle, 2 * np.pi / n - angle)


SURFACES: dict[str, Callable[[], TriangleMesh]] = {
    "sphere": lambda: icosphere(2),
    "torus": lambda: torus(16, 8),
    "genus 2": lambda: genus_two(24),
    "square": lambda: grid(10, 10),
    "disc": lambda: disc(4),
    "annulus": annulus,
    "cylinder": lambda: cylinder_band(20, 6),
    "two spheres": lambda: TriangleMesh(
        np.concatenate([icosphere(1).vertices, icosphere(1).vertices + 5, [[9.0, 9, 9]]]),
        np.concatenate([icosphere(1).faces, icosphere(1).faces + 42]),
    ),
}


@pytest.mark.parametrize("name", SURFACES)
def test_indices_sum_to_the_euler_characteristic(name: str) -> None:
    """Indices and boundary turns sum to χ for all n and s, and each is a multiple of 1/n."""
    mesh = SURFACES[name]()
    for n, s in ((1, 0.0), (2, 1.0), (4, -0.5), (6, 0.0)):
        report = smoothest(mesh, n, s).report
        assert report["index_sum"] == pytest.approx(mesh.euler_characteristic, abs=1e-12)
        for item in report["singularities"]:
            assert item["index"] * n == pytest.approx(round(item["index"] * n), abs=1e-12)


@needs_reference
@pytest.mark.parametrize("name", ["moomoo.off", "spot.obj", "torus5k_surface.off", "3holes.off"])
def test_indices_on_scans(name: str) -> None:
    """Also on meshes with obtuse faces and high genus."""
    from geomhw.io import read_mesh

    mesh = read_mesh(reference(f"meshes/closed/{name}"))
    assert smoothest(mesh, 4).report["index_sum"] == mesh.euler_characteristic


def test_energies_on_the_sphere_and_the_torus() -> None:
    """On the unit sphere |n| is the least eigenvalue; conformal fields have no holomorphic energy; flat fields none."""
    for n in (1, 2, 4):
        assert smoothest(icosphere(3), n).report["energy"] == pytest.approx(n, rel=1e-2)
    assert abs(smoothest(icosphere(3), 2, 1.0).report["energy"]) < 2e-2
    for mesh in (grid(8, 8), cylinder_band(16, 5)):
        assert abs(smoothest(mesh, 4).report["unit_energy"]) < 1e-12


def test_directions_are_unit_tangent_and_apart() -> None:
    """n unit tangent vectors, counterclockwise, a full turn over n apart."""
    mesh = icosphere(2)
    result = smoothest(mesh, 6)
    vectors = np.stack([result[f"direction_{k}"] for k in range(6)])
    np.testing.assert_allclose(np.linalg.norm(vectors, axis=2), 1, atol=1e-12)
    np.testing.assert_allclose(np.einsum("kix,ix->ki", vectors, mesh.vertex_normals), 0, atol=1e-12)
    turned = np.cross(vectors[0], vectors[1])
    np.testing.assert_allclose(np.einsum("ix,ix->i", turned, mesh.vertex_normals), np.sin(np.pi / 3), atol=1e-12)


def test_principal_curvature_on_cylinder_and_torus() -> None:
    """Fields of weight 10 follow the circles of a cylinder and of a torus; lines take the larger curvature."""
    band = cylinder_band(40, 12)
    around = np.cross([0, 0, 1.0], band.vertices)
    around /= np.linalg.norm(around, axis=1, keepdims=True)
    ring = torus(48, 24)
    center = ring.vertices * [1, 1, 0]
    along = np.cross([0, 0, 1.0], center)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    across = np.cross(ring.vertex_normals, along)
    for mesh, expected in ((band, around), (ring, across)):
        for n in (2, 4):
            fields = DirectionFields(mesh, n)
            result = fields.result(fields.aligned(target=principal_target(mesh, n), weight=10.0))
            assert np.degrees(wrong_angles(np.asarray(result["direction_0"]), expected, n)).max() < 2
            assert not result.report["singularities"]


def test_given_directions_at_points_along_curves_and_the_boundary() -> None:
    """Directions are exact where they are given, and a field along the rim of a disc has the index 1 within."""
    mesh = icosphere(3)
    points = vertex_points(mesh, [5, 77])
    vectors = np.array([[1.0, 2, 3], [0, 1, 0]])
    fields = DirectionFields(mesh, 1)
    result = fields.result(fields.aligned(*combined([directions_at(mesh, points, vectors, 1)])))
    tangential = (
        vectors - np.einsum("kx,kx->k", vectors, mesh.vertex_normals[[5, 77]])[:, None] * mesh.vertex_normals[[5, 77]]
    )
    tangential /= np.linalg.norm(tangential, axis=1, keepdims=True)
    np.testing.assert_allclose(np.asarray(result["direction"])[[5, 77]], tangential, atol=1e-9)
    assert result.report["index_sum"] == 2
    plate = disc(8)
    round_it = DirectionFields(plate, 1)
    swirl = round_it.result(round_it.aligned(*combined([directions_along_boundary(plate, 1)])))
    assert swirl.report["boundary_turns"] == [0.0]
    assert [item["index"] for item in swirl.report["singularities"]] == [1.0]
    square = grid(12, 12)
    crosses = DirectionFields(square, 4)
    flat = crosses.result(crosses.aligned(*combined([directions_along_boundary(square, 4)])))
    axes = np.tile([1.0, 0, 0], (square.n_vertices, 1))
    assert wrong_angles(np.asarray(flat["direction_0"]), axes, 4).max() < 1e-7
    curve = vertex_points(square, [14, 28, 42, 56])
    lines = DirectionFields(square, 2)
    slanted = lines.result(lines.aligned(*combined([directions_along(square, [curve], 2)])))
    diagonal = np.tile([np.sqrt(0.5), np.sqrt(0.5), 0], (square.n_vertices, 1))
    assert wrong_angles(np.asarray(slanted["direction_0"]), diagonal, 2).max() < 1e-7


@pytest.mark.parametrize(
    ("mesh", "n", "vertices", "faces"),
    [
        (icosphere(2), 1, {0: 1.0, 3: 1.0}, {}),
        (icosphere(2), 1, {50: 2.0}, {}),
        (icosphere(2), 2, {}, {3: 0.5, 100: 0.5, 200: 0.5, 250: 0.5}),
        (icosphere(2), 4, dict.fromkeys(range(8), 0.25), {}),
        (torus(24, 12), 1, {}, {}),
        (torus(24, 12), 4, {}, {}),
        (torus(24, 12), 1, {5: 1.0, 150: -1.0}, {}),
        (genus_two(24), 1, {100: -1.0, 400: -1.0}, {}),
        (grid(10, 10), 1, {60: -1.0}, {}),
        (grid(10, 10), 4, {}, {60: 0.25}),
        (annulus(), 1, {}, {}),
    ],
)
def test_prescribed_singularities(
    mesh: TriangleMesh, n: int, vertices: dict[int, float], faces: dict[int, float]
) -> None:
    """The field has exactly these singularities, at these places, and the sum is right with the boundary."""
    fields = DirectionFields(mesh, n)
    report = fields.result(trivial_connection(mesh, n, vertices, faces)).report
    found = {
        ("v", item["vertex"]) if "vertex" in item else ("f", item["face"]): item["index"]
        for item in report["singularities"]
    }
    assert found == {("v", key): value for key, value in vertices.items()} | {("f", key): v for key, v in faces.items()}
    assert report["index_sum"] == pytest.approx(mesh.euler_characteristic, abs=1e-12)


def test_turns_of_a_trivial_connection_on_the_torus_are_least() -> None:
    """Without singularities, a torus of revolution has a field along its circles, up to one angle."""
    ring = torus(32, 16)
    u = trivial_connection(ring, 1)
    field = np.asarray(DirectionFields(ring, 1).result(u)["direction"])
    along = np.cross([0, 0, 1.0], ring.vertices * [1, 1, 0])
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    across = np.cross(ring.vertex_normals, along)
    angle = np.arctan2(np.einsum("ix,ix->i", field, across), np.einsum("ix,ix->i", field, along))
    assert np.abs(np.exp(1j * angle) - np.exp(1j * angle[0])).max() < 0.05


def test_field_that_commutes_with_a_mirror() -> None:
    """The mirror image of the field is the field."""
    mesh = icosphere(2)
    mirror = np.linalg.norm(mesh.vertices[:, None] * [1, 1, -1] - mesh.vertices, axis=2).argmin(axis=1)
    fields = DirectionFields(mesh, 1)
    result = fields.result(commuting(fields, mirror))
    image = np.asarray(result["direction"]) * [1, 1, -1]
    apart = wrong_angles(np.asarray(result["direction"])[mirror], image, 1)
    assert np.median(apart) < 1e-3
    assert result.report["energy"] == pytest.approx(1, rel=2e-2)  # as of the smoothest field without a map
    assert result.report["index_sum"] == 2


def test_field_on_two_shapes_at_once() -> None:
    """Between spheres stretched in different directions, the differential takes the first field to the second."""
    ball = icosphere(2)
    long = TriangleMesh(ball.vertices * [1, 1, 1.2], ball.faces)
    wide = TriangleMesh(ball.vertices * [1, 1.2, 1], ball.faces)
    one, other = DirectionFields(wide, 1), DirectionFields(long, 1)
    turned = ball.vertices[:, [1, 2, 0]]
    third = np.linalg.norm(ball.vertices[:, None] - turned, axis=2).argmin(axis=0)
    u, v = joint_fields(one, other, third)
    first, second = np.asarray(one.result(u)["direction"]), np.asarray(other.result(v)["direction"])
    image = (first / [1, 1.2, 1])[:, [1, 2, 0]] * [1, 1, 1.2]
    image /= np.linalg.norm(image, axis=1, keepdims=True)
    # The rotation nearest to the differential turns directions a little less than the differential.
    assert np.median(wrong_angles(second[third], image, 1)) < 0.2
    alone = np.asarray(other.result(other.smoothest())["direction"])
    assert np.median(wrong_angles(alone[third], image, 1)) > 0.3


def test_relaxation_lowers_the_energy_of_directions() -> None:
    """Steps lower the energy of unit directions, and keep given ones and the sum of indices."""
    mesh = icosphere(3)
    fields = DirectionFields(mesh, 4)
    u = fields.smoothest()
    energies = [fields.result(u, fields.relaxed(u, steps=k)).report["unit_energy"] for k in (0, 1, 5, 20)]
    assert energies == sorted(energies, reverse=True)
    assert energies[-1] < 0.9 * energies[0]
    kept = fields.relaxed(u, np.array([7, 90]))
    np.testing.assert_allclose(kept[[7, 90]], (u / np.abs(u))[[7, 90]], atol=1e-14)
    result = fields.result(u, kept)
    assert result.report["index_sum"] == 2
    assert result.report["energy"] == fields.result(u).report["energy"]


def test_answers_do_not_depend_on_place_and_size() -> None:
    """A turn, a shift and a rescaling of the mesh turn the field, and change no index."""
    mesh = torus(20, 10)
    turn = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    moved = TriangleMesh(1e-7 * mesh.vertices @ turn.T + 1e-6, mesh.faces)
    one, other = smoothest(mesh, 2), smoothest(moved, 2)
    assert other.report["energy"] * 1e-14 == pytest.approx(one.report["energy"], rel=1e-6)
    assert other.report["index_sum"] == one.report["index_sum"]


def test_slivers_do_not_make_the_energy_negative() -> None:
    """Where negative weights make the Dirichlet energy indefinite they are left out, and said so."""
    ball = icosphere(2)
    crumpled = ball.vertices + 0.15 * np.random.default_rng(0).normal(size=ball.vertices.shape)
    report = smoothest(TriangleMesh(crumpled, ball.faces), 4).report
    assert report["nonnegative_weights"]
    assert report["energy"] > 0
    assert report["index_sum"] == 2
    assert not smoothest(ball, 4).report["nonnegative_weights"]


def test_closer_shift_finds_the_same_field(monkeypatch: pytest.MonkeyPatch) -> None:
    """If the iteration does not converge, a shift to just below the smallest eigenvalue gives the same field."""
    fields = DirectionFields(torus(20, 10), 4)
    expected, found = fields.smoothest(), []

    def failing_once(A: object, M: object, k: int) -> object:
        found.append(k)
        if len(found) == 1:
            raise ConvergenceError("no convergence")
        return smallest_eigenpairs(A, M, k)

    monkeypatch.setattr("geomhw.directions.smooth_fields.smallest_eigenpairs", failing_once)
    energies = [fields.result(u).report["energy"] for u in (expected, fields.smoothest())]
    assert len(found) == 2
    assert energies[1] == pytest.approx(energies[0], rel=1e-9)
