"""Identities and invariances on random meshes and fields of hypothesis."""

from collections.abc import Sequence

import numpy as np
import pytest
import scipy.sparse as sp
from hypothesis import assume, given
from hypothesis import strategies as st

from geomhw.flow.helmholtz import HelmholtzDecomposition
from geomhw.flow.initial_fields import random_field
from geomhw.flow.tangent_fields import energy
from geomhw.fluid.conservative import ConservativeScheme
from geomhw.fluid.run import Plan, run
from geomhw.geodesic.heat_method import heat_distance
from geomhw.mesh.primitives import grid, icosphere, strip, torus
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.connection_laplacian import connection_stiffness
from geomhw.operators.divergence import divergence
from geomhw.operators.gradient import gradient
from geomhw.operators.laplacian import stiffness
from geomhw.operators.mass import lumped_mass
from geomhw.transport.vector_heat import VectorHeat, random_tangent
from support.meshes import ZOO, annulus

seeds = st.integers(0, 2**32 - 1)
BASES = [ZOO["tetrahedron"](), icosphere(1), torus(7, 5), grid(4, 3), strip(5), annulus()]
CLOSED = [icosphere(1), torus(9, 6)]


@st.composite
def surfaces(draw: st.DrawFn, bases: Sequence[TriangleMesh] = BASES, shake: float = 0.25) -> TriangleMesh:
    """A small surface with moved vertices, at a random scale and position."""
    base = draw(st.sampled_from(bases))
    chance = np.random.default_rng(draw(seeds))
    moved = base.vertices + shake * base.mean_edge_length * chance.uniform(-1, 1, base.vertices.shape)
    size = 10.0 ** draw(st.integers(-6, 6))
    return TriangleMesh(size * (moved + chance.normal(size=3)), base.faces)


@st.composite
def rotations(draw: st.DrawFn) -> np.ndarray:
    """A rotation matrix."""
    Q, R = np.linalg.qr(np.random.default_rng(draw(seeds)).normal(size=(3, 3)))
    Q *= np.sign(np.diag(R))
    return Q * np.sign(np.linalg.det(Q))


@given(surfaces())
def test_operators(mesh: TriangleMesh) -> None:
    """Div G = -S; S is symmetric and positive semidefinite, with constants in its kernel; masses sum to the area."""
    S, scale = stiffness(mesh), abs(stiffness(mesh)).max()
    assert abs(divergence(mesh) @ gradient(mesh) + S).max() < 1e-12 * scale
    assert abs(S - S.T).max() == 0
    assert np.linalg.eigvalsh(S.toarray()).min() > -1e-12 * scale
    assert np.abs(S @ np.ones(mesh.n_vertices)).max() < 1e-12 * scale
    assert lumped_mass(mesh).sum() == pytest.approx(mesh.face_areas.sum(), rel=1e-13)


@given(surfaces(CLOSED))
def test_connection(mesh: TriangleMesh) -> None:
    """C is symmetric, and positive semidefinite where no weight is negative."""
    C = connection_stiffness(mesh)
    scale = abs(C).max()
    assert abs(C - C.T).max() < 1e-12 * scale
    weights = -sp.triu(stiffness(mesh), 1).data
    if weights.min() >= 0:
        assert np.linalg.eigvalsh(C.toarray()).min() > -1e-12 * scale


@given(surfaces(), rotations(), st.integers(-8, 8), seeds)
def test_distance_is_that_of_the_surface(mesh: TriangleMesh, Q: np.ndarray, power: int, seed: int) -> None:
    """Distance is invariant under renumbering and rigid motion, and scales with the mesh."""
    chance = np.random.default_rng(seed)
    size, source = 10.0**power, int(chance.choice(mesh.faces.ravel()))
    names = chance.permutation(mesh.n_vertices)  # new number of each vertex
    order = chance.permutation(mesh.n_faces)
    vertices = np.empty_like(mesh.vertices)
    vertices[names] = size * (mesh.vertices - mesh.vertices.mean(axis=0)) @ Q.T
    turned = names[mesh.faces][np.arange(mesh.n_faces)[:, None], (np.arange(3) + chance.integers(3)) % 3]
    other = TriangleMesh(vertices, turned[order])
    one = heat_distance(mesh, [source], "h2")
    two = heat_distance(other, [int(names[source])], "h2")[names]
    np.testing.assert_allclose(two, size * one, rtol=0, atol=1e-8 * size * one[np.isfinite(one)].max())
    assert one[source] == 0
    assert (one >= 0).all()


@given(surfaces(), seeds)
def test_transport_keeps_lengths(mesh: TriangleMesh, seed: int) -> None:
    """Transported vectors have the length of the source's vector."""
    source = int(np.random.default_rng(seed).choice(mesh.faces.ravel()))
    vector = 3.0 * random_tangent(mesh, source, seed)
    moved = VectorHeat(mesh).from_vertices([source], [vector])["transported"]
    used = np.unique(mesh.faces)
    np.testing.assert_allclose(np.linalg.norm(moved[used], axis=1), np.linalg.norm(vector), rtol=1e-12)


@given(surfaces(), seeds)
def test_parts_of_a_field(mesh: TriangleMesh, seed: int) -> None:
    """The parts sum to the field, and their energies to its energy."""
    result = HelmholtzDecomposition(mesh)(np.random.default_rng(seed).normal(size=(mesh.n_faces, 3)))
    parts = [result[name] for name in ("curl_free", "coexact", "harmonic")]
    total = energy(mesh, result["field"])
    np.testing.assert_allclose(sum(parts), result["field"], atol=1e-9 * np.abs(result["field"]).max())
    assert sum(energy(mesh, part) for part in parts) == pytest.approx(total, rel=1e-9)


@given(surfaces(CLOSED, shake=0.1), seeds)
def test_flow_keeps_energy(mesh: TriangleMesh, seed: int) -> None:
    """Ten steps at Courant number 0.05 keep the energy."""
    scheme = ConservativeScheme(mesh)
    start = scheme.start(random_field(mesh, seed % 1000), np.zeros(mesh.n_vertices))
    before = energy(mesh, scheme.velocity(start))
    assume(before > 0)
    end = [snapshot.state for snapshot in run(scheme, start, Plan(cfl=0.05, steps=10, every=10), None)][-1]
    assert energy(mesh, scheme.velocity(end)) == pytest.approx(before, rel=1e-9)
