"""Smoothing by heat flow: integral, constants, masks and range; regions and extrema against brute force."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geomhw.errors import ArgumentError, FieldError
from geomhw.geodesic import ExactDistance
from geomhw.mesh import TriangleMesh, grid, icosphere, torus
from geomhw.options import OverlapName
from geomhw.scalars import HeatSmoothing, geodesic_disks, local_extrema, signed_distance, smooth

BALL, TORUS, PLANE = icosphere(3), torus(24, 16), grid(12, 9)


@given(seed=st.integers(0, 2**32 - 1), width=st.floats(0.05, 50), which=st.sampled_from([BALL, TORUS, PLANE]))
def test_integral_and_range_are_kept(seed: int, width: float, which: TriangleMesh) -> None:
    """The integral stays to 1e-12, the values between the extremes; below two edges they pass those by up to 3 %."""
    values = np.random.default_rng(seed).normal(size=which.n_vertices) * 1e3 + 7
    areas = which.vertex_areas
    smoothed = smooth(which, values, width)
    assert abs(areas @ smoothed - areas @ values) <= 1e-12 * (areas @ np.abs(values))
    if which.edge_cotan_weights.min() > -1e-12:
        reach = (1e-3 if width > 2 * which.mean_edge_length else 0.03) * np.ptp(values)
        assert smoothed.max() < values.max() + reach
        assert smoothed.min() > values.min() - reach


def test_constants_stay_and_columns_are_independent() -> None:
    """A constant stays to rounding; several columns give what each gives on its own."""
    np.testing.assert_allclose(smooth(TORUS, np.full(TORUS.n_vertices, 3.7), 0.8), 3.7, rtol=1e-12)
    values = np.random.default_rng(0).normal(size=(TORUS.n_vertices, 3))
    flow = HeatSmoothing(TORUS, 0.5)
    apart = np.stack([flow(column) for column in values.T], axis=1)
    np.testing.assert_allclose(flow(values), apart, rtol=1e-9, atol=1e-12)


def test_integral_of_each_component_is_kept() -> None:
    """Nothing passes from a component to another one, and vertices without faces keep their value."""
    far = BALL.vertices + np.array([5, 0, 0])
    both = TriangleMesh(
        np.concatenate([BALL.vertices, far, [[9, 9, 9]]]), [*BALL.faces, *(BALL.faces + BALL.n_vertices)]
    )
    values = np.zeros(both.n_vertices)
    values[3], values[-1] = 1, 5
    smoothed = smooth(both, values, 3.0)
    assert (smoothed[BALL.n_vertices : -1] == 0).all()
    assert smoothed[-1] == 5
    areas = BALL.vertex_areas
    assert abs(areas @ smoothed[: BALL.n_vertices] - areas[3]) < 1e-14


@pytest.mark.parametrize("fwhm", [0.0, -1.0, np.nan, np.inf])
def test_widths_that_are_none(fwhm: float) -> None:
    """A width that is no positive number is refused."""
    with pytest.raises(ArgumentError, match="full width"):
        smooth(BALL, BALL.vertices[:, 0], fwhm)


@pytest.mark.parametrize("distance", [0.3, 1.0])
def test_extrema_against_all_distances(distance: float) -> None:
    """Extrema are the vertices more extreme than all others within the exact distance."""
    values = np.random.default_rng(1).normal(size=TORUS.n_vertices)
    D = np.stack([ExactDistance(TORUS).from_vertices([v])["distance"] for v in range(TORUS.n_vertices)])
    found = local_extrema(TORUS, values, distance)
    near = distance >= D
    near[tuple(TORUS.edges.T)] = near[tuple(TORUS.edges.T[::-1])] = True
    maxima = np.flatnonzero((values[:, None] >= np.where(near, values, -np.inf)).all(axis=1))
    minima = np.flatnonzero((values[:, None] <= np.where(near, values, np.inf)).all(axis=1))
    assert sorted(found.maxima) == maxima.tolist()
    assert sorted(found.minima) == minima.tolist()
    assert (np.diff(values[found.maxima]) < 0).all()


def test_plateaus_are_one_extremum() -> None:
    """Connected vertices of one value are one extremum; a constant has none; a tie within the distance keeps one."""
    values = np.where(PLANE.vertices[:, 0] < 0.2, 1.0, 0.0)
    found = local_extrema(PLANE, values)
    assert found.maxima.tolist() == [0]
    assert len(found.minima) == 1
    assert local_extrema(PLANE, np.ones(PLANE.n_vertices)).maxima.tolist() == []
    values = np.zeros(PLANE.n_vertices)
    values[[15, 17]] = 1
    assert local_extrema(PLANE, values).maxima.tolist() == [15, 17]
    assert local_extrema(PLANE, values, 0.5).maxima.tolist() == [15]
    with pytest.raises(ArgumentError, match="distance between extrema"):
        local_extrema(PLANE, values, -1)


@pytest.mark.parametrize("overlap", ["allow", "closest", "exclude"])
def test_disks_against_distances(overlap: OverlapName) -> None:
    """Disks are where the exact distance is within the radius; weights are Gaussian and sum to 1."""
    centers, radius = [3, 40, 41, 200], 0.9
    D = np.stack([ExactDistance(TORUS).from_vertices([v])["distance"] for v in centers], axis=1)
    inside = radius >= D
    if overlap == "closest":
        inside &= D.argmin(axis=1)[:, None] == np.arange(4)
    if overlap == "exclude":
        inside &= inside.sum(axis=1)[:, None] == 1
    np.testing.assert_array_equal(geodesic_disks(TORUS, centers, radius, overlap=overlap), inside)
    weights = np.where(inside, np.exp(-(D**2) / (2 * 0.4**2)), 0)
    found = geodesic_disks(TORUS, centers, radius, 0.4, overlap)
    np.testing.assert_allclose(found, weights / np.maximum(weights.sum(axis=0), 1e-300), atol=1e-15)


def test_disks_refuse_impossible_weights() -> None:
    """A standard deviation that is not positive is refused."""
    with pytest.raises(ArgumentError, match="standard deviation"):
        geodesic_disks(PLANE, [0], 1, 0.0)
    with pytest.raises(ArgumentError, match="overlap"):
        geodesic_disks(PLANE, [0], 1, overlap="never")  # type: ignore[arg-type]


def test_signed_distance_against_both_sides() -> None:
    """Outside it is the distance to the region, inside the negative distance to the rest."""
    inside = PLANE.vertices[:, 0] < 0.45
    found = signed_distance(PLANE, inside)
    x = PLANE.vertices[:, 0]
    np.testing.assert_allclose(found, np.where(inside, x - x[~inside].min(), x - x[inside].max()), atol=1e-12)
    np.testing.assert_allclose(signed_distance(PLANE, ~inside), -found, atol=1e-12)
    with pytest.raises(FieldError, match="outside"):
        signed_distance(PLANE, np.ones(PLANE.n_vertices, dtype=bool))
