"""Comparison of arrays: reflexive, symmetric, and exact at its tolerance."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from geomhw.compare import Finding, Tolerance, compare_arrays
from support.comparisons import DEFAULT


def arrays(a, b, tolerance: Tolerance = DEFAULT, **options) -> Finding:
    return compare_arrays("u", "vertex", a, b, tolerance, **options)


NUMBERS = hnp.arrays(float, st.integers(1, 20), elements=st.floats(allow_nan=True, allow_infinity=True))


@given(NUMBERS)
def test_anything_equals_itself(values):
    """Equal arrays are equal at zero tolerance, NaN and infinities included."""
    finding = arrays(values, values.copy(), Tolerance(0.0))
    assert finding.same
    assert finding.absolute == 0


@given(NUMBERS, st.data())
def test_order_does_not_matter(a, data):
    """Comparison is symmetric in A and B."""
    b = data.draw(hnp.arrays(float, a.shape, elements=st.floats(-1e3, 1e3)))
    for rtol in (1e-9, 0.5):
        p, q = arrays(a, b, Tolerance(rtol)), arrays(b, a, Tolerance(rtol))
        assert (p.same, p.absolute, p.beyond, p.index) == (q.same, q.absolute, q.beyond, q.index)


@pytest.mark.parametrize("scale", [1e-12, 1.0, 1e12])
def test_tolerance_is_what_it_says(scale):
    """A deviation below rtol times the largest magnitude passes, one above fails, at any scale."""
    a = scale * np.array([0.0, 1e-3, -8.0, 3.0])
    for i in range(4):
        for share, same in ((0.99, True), (1.01, False)):
            b = a.copy()
            b[i] += share * 1e-6 * 8 * scale
            finding = arrays(a, b, Tolerance(1e-6), single=False)
            assert finding.same is same
            assert finding.index == (i,)
            assert finding.absolute == pytest.approx(share * 8e-6 * scale, rel=1e-6)
            assert finding.relative == pytest.approx(share * 1e-6, rel=1e-5)
            assert finding.tolerance == pytest.approx(8e-6 * scale)
            assert finding.beyond == (not same)


def test_atol_adds():
    """The tolerance is atol + rtol · scale."""
    noise, other = np.array([1e-17, -2e-17]), np.array([3e-17, 1e-17])
    assert not arrays(noise, other).same
    assert arrays(noise, other, Tolerance(atol=4e-17)).same
    assert not arrays(noise, other, Tolerance(atol=2e-17)).same
    assert arrays([1.0], [1.0 + 3e-6], Tolerance(rtol=2e-6, atol=2e-6)).same


def test_one_that_blows_up_does_not_pass():
    """A single huge value fails, although it raises the scale."""
    a = np.ones(5)
    b = a.copy()
    b[3] = 1e300
    finding = arrays(a, b, Tolerance(0.5))
    assert not finding.same
    assert finding.index == (3,)
    assert not arrays([1e308], [-1e308], Tolerance(1.0)).same


@pytest.mark.parametrize(
    ("a", "b"), [(np.nan, 1.0), (np.inf, 1.0), (np.inf, -np.inf), (np.nan, np.inf), (1 + 1j * np.nan, 1 + 1j)]
)
def test_what_is_not_finite_equals_itself_only(a, b):
    """NaN and infinities differ from everything else, at any tolerance."""
    finding = arrays([2.0, a], [2.0, b], Tolerance(0.9, 1e300))
    assert not finding.same
    assert finding.index == (1,)
    assert finding.absolute == np.inf
    assert not arrays([1e300, a], [1e300, b], Tolerance(1e300)).same  # where the tolerance itself overflows


@pytest.mark.parametrize(
    ("a", "b", "worst"),
    [
        (np.uint8([3, 250]), np.uint8([3, 251]), 1),
        (np.uint8([0, 7]), np.uint8([0, 255]), 248),
        (np.int64([0, 2**53]), np.int64([0, 2**53 + 1]), 1),
        (np.array([False, True]), np.array([False, False]), 1),
    ],
)
def test_whole_numbers_are_exact(a, b, worst):
    """Integers are compared exactly, without overflow or rounding."""
    finding = arrays(a, b, Tolerance(0.9, 1e9))
    assert (finding.same, finding.index, finding.absolute) == (False, (1,), worst)


def test_types_and_widths():
    """Integers beside floats are numbers; a column equals a vector; single precision has its own default."""
    assert arrays(np.array([1, 2]), np.array([1.0, 2.0 + 1e-10])).same
    assert arrays(np.ones((4, 1)), np.ones(4)).same
    x = np.random.default_rng(0).normal(size=50)
    assert arrays(x, x.astype(np.float32)).same
    assert not arrays(x, x.astype(np.float32).astype(np.float64)).same
    assert not arrays(x, x.astype(np.float32), Tolerance(1e-9)).same


def test_shapes_and_texts():
    """Different shapes, different texts, and text beside numbers give one note each."""
    assert arrays(np.ones((3, 2)), np.ones(4)).note == "3 x 2 in A, 4 in B"
    finding = arrays(np.array(["a", "b"]), np.array(["a", "c"]))
    assert (finding.same, finding.index, finding.values) == (False, (1,), ("b", "c"))
    assert arrays(np.array(["a"]), np.array([1.0])).note == "text in A, numbers in B"
    records = np.zeros(2, [("u", float)])
    assert arrays(records, records).same
    assert arrays(records, np.zeros(2, [("v", float)])).note == "[('u', '<f8')] in A, [('v', '<f8')] in B"


def test_signaling_nan() -> None:
    """A signaling NaN equals itself, without a warning."""
    values = np.frombuffer(bytes.fromhex("3f800000ffffff85ff800001"), ">f4")
    assert np.isnan(values).tolist() == [False, True, True]
    assert compare_arrays("u", "vertex", values, values.copy(), Tolerance()).same
