"""Points in one place: the groups are those of numpy.unique and of all pairs."""

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from geomhw.mesh import welding
from geomhw.mesh.welding import distinct_points, first_nearby


@pytest.mark.parametrize("kind", [np.float32, np.float64])
@pytest.mark.parametrize("scale", [1, 1e-30, 1e30])
@pytest.mark.parametrize("collide", [False, True])
def test_distinct_points(kind, scale, collide, monkeypatch):
    """Equal points are found, -0.0 equals 0.0, also where all points have one hash."""
    if collide:
        monkeypatch.setattr(welding, "_PRIMES", np.zeros(3, np.uint64))
    points = np.random.default_rng(0).integers(-4, 5, (500, 3)).astype(kind) * kind(scale)
    points[::3] *= -1
    first, inverse = distinct_points(points)
    assert first.tolist() == sorted(np.unique(points + 0.0, axis=0, return_index=True)[1].tolist())
    np.testing.assert_array_equal(points[first][inverse], points)
    assert (first[inverse] <= np.arange(len(points))).all()


@pytest.mark.parametrize("scale", [1, 1e-30, 1e30])
@pytest.mark.parametrize("offset", [0, 1e3])
def test_first_nearby(scale, offset):
    """Chains of near points are those of all pairs, at any scale and place."""
    rng = np.random.default_rng(1)
    points = rng.random((2000, 3)) + offset
    points[1000:] = points[:1000] + rng.normal(size=(1000, 3)) * 1e-6
    pairs = cKDTree(points).query_pairs(2e-6, output_type="ndarray")
    labels = connected_components(coo_array((np.ones(len(pairs)), pairs.T), shape=(2000, 2000)), directed=False)[1]
    lowest = np.full(2000, 2000)
    np.minimum.at(lowest, labels, np.arange(2000))
    np.testing.assert_array_equal(first_nearby(points * scale, 2e-6 * scale), lowest[labels])


def test_first_nearby_on_a_line():
    """Points in a plane across the direction of the search, or in one place, are compared, too."""
    assert first_nearby(np.zeros((3, 3)), 1e-9).tolist() == [0, 0, 0]
    assert first_nearby(np.array([[0.0, 0, 0]]), 1e-9).tolist() == [0]
