"""Convergence of advection: a function carried once round the sphere."""

import numpy as np
import pytest

from geomhw.options import Integrator
from support.exact import turned_error
from support.rates import fitted_rate

INTEGRATORS: tuple[Integrator, ...] = ("bounded", "taylor3", "expm")


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_rigid_rotation_converges(integrator: Integrator) -> None:
    """A function carried once round the unit sphere returns to itself with an L2 error of order h².

    The relative error is at most 10, 2.6 and 0.68 % on 642, 2,562 and 10,242 vertices.
    """
    errors, sizes = zip(*(turned_error(level, integrator, 2 * np.pi) for level in (3, 4, 5)), strict=True)
    assert all(error <= bound for error, bound in zip(errors, (0.1, 0.026, 0.0068), strict=True)), errors
    assert fitted_rate(sizes, errors) > 1.9
