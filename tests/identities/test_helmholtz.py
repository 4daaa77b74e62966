"""Identities of the Helmholtz-Hodge decomposition, on closed meshes and on meshes with boundary."""

import numpy as np
import pytest

from geomhw.flow.helmholtz import HelmholtzDecomposition
from geomhw.flow.tangent_fields import energy
from geomhw.mesh.primitives import torus
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.divergence import divergence
from geomhw.operators.gradient import gradient
from geomhw.results import Result
from support.meshes import crumpled, zoo_mesh
from support.reference import needs_reference, reference

PARTS = ("curl_free", "coexact", "harmonic")


def decomposed(mesh: TriangleMesh, seed: int = 0) -> Result:
    """Decompose a random field."""
    return HelmholtzDecomposition(mesh)(np.random.default_rng(seed).normal(size=(mesh.n_faces, 3)))


def check_parts(mesh: TriangleMesh, genus: int) -> None:
    """Check that the parts sum to the field, are orthogonal, and have the right divergence and harmonic part."""
    result = decomposed(mesh)
    V = result["field"]
    size = np.abs(V).max()
    np.testing.assert_allclose(sum(result[part] for part in PARTS), V, atol=1e-10 * size)
    np.testing.assert_allclose(result["coexact"] + result["harmonic"], result["divergence_free"], atol=1e-10 * size)
    total = energy(mesh, V)
    for i, j in ((0, 1), (0, 2), (1, 2)):
        product = mesh.face_areas @ np.einsum("fx,fx->f", result[PARTS[i]], result[PARTS[j]])
        assert abs(product) < 1e-10 * total
    Div = divergence(mesh)
    scale = (abs(Div) @ np.abs(V).ravel()).max()
    for part in ("divergence_free", "coexact", "harmonic"):
        assert np.abs(Div @ result[part].ravel()).max() < 1e-10 * scale
    harmonic = energy(mesh, result["harmonic"]) / total
    if genus == 0:
        assert harmonic < 1e-20
    else:
        assert harmonic > 1e-6


def test_closed_meshes(closed_mesh: tuple[TriangleMesh, int]) -> None:
    """The identities hold on every closed mesh of the zoo."""
    check_parts(*closed_mesh)


@needs_reference
@pytest.mark.parametrize(("name", "genus"), [("moomoo.off", 0), ("kitten.obj", 1), ("eight.off", 2), ("3holes.off", 3)])
def test_real_closed_meshes(name: str, genus: int) -> None:
    """The identities hold on real meshes of genus 0 to 3."""
    from geomhw.io import read_mesh

    check_parts(read_mesh(reference(f"meshes/closed/{name}")), genus)


@pytest.mark.parametrize("name", ["grid", "annulus", "strip", "two_spheres", "triangle"])
def test_boundary_and_components(name: str) -> None:
    """The identities hold with boundary and several components; for genus 0 nothing is harmonic."""
    check_parts(zoo_mesh(name), 0)


def test_boundary_is_not_crossed() -> None:
    """The divergence-free part has no flux through the boundary of the annulus."""
    mesh = zoo_mesh("annulus")
    result = decomposed(mesh)
    spread = divergence(mesh) @ result["divergence_free"].ravel()
    assert np.abs(spread[mesh.boundary_vertices]).max() < 1e-12


def test_gradient_is_curl_free() -> None:
    """A gradient is its own curl-free part; its potential is the function minus its mean."""
    mesh = zoo_mesh("crumpled_torus")
    f = np.sin(3 * mesh.vertices[:, 0])
    result = HelmholtzDecomposition(mesh)((gradient(mesh) @ f).reshape(-1, 3))
    np.testing.assert_allclose(result["curl_free"], result["field"], atol=1e-11)
    mean = (mesh.vertex_areas @ f) / mesh.vertex_areas.sum()
    np.testing.assert_allclose(result["potential"], f - mean, atol=1e-12)


def test_turned_gradient_is_coexact() -> None:
    """n × ∇f is coexact with stream function f, and the projection leaves it unchanged."""
    mesh = zoo_mesh("crumpled_sphere")
    f = np.sin(2 * mesh.vertices[:, 2])
    V = np.cross(mesh.face_normals, (gradient(mesh) @ f).reshape(-1, 3))
    decomposition = HelmholtzDecomposition(mesh)
    np.testing.assert_allclose(decomposition(V)["coexact"], V, atol=1e-11)
    np.testing.assert_allclose(decomposition.project(V), V, atol=1e-11)
    np.testing.assert_allclose(decomposition.project((gradient(mesh) @ f).reshape(-1, 3)), 0, atol=1e-11)


def test_harmonic_fields_of_the_torus() -> None:
    """Harmonic parts of three fields on a torus span two dimensions."""
    for mesh in (torus(20, 10), crumpled(torus(20, 10))):
        parts = np.stack([decomposed(mesh, seed)["harmonic"].ravel() for seed in range(3)])
        values = np.linalg.svd(parts, compute_uv=False)
        assert values[1] > 1e-3 * values[0]
        assert values[2] < 1e-10 * values[0]


def test_normal_part_is_reported() -> None:
    """The normal component is removed, and its share of the energy is reported."""
    mesh = zoo_mesh("sphere")
    V = np.cross([0, 0, 1], mesh.face_centers)
    given = V + mesh.face_normals
    report = HelmholtzDecomposition(mesh)(given).report
    assert report["normal_part_removed"] == pytest.approx(mesh.face_areas.sum() / energy(mesh, given), rel=1e-3)


def test_zero_field() -> None:
    """The zero field has zero parts, and a report without NaN."""
    mesh = zoo_mesh("sphere")
    result = HelmholtzDecomposition(mesh)(np.zeros((mesh.n_faces, 3)))
    assert not result["harmonic"].any()
    assert result.report["energy_shares"]["harmonic"] == 0
