"""Convergence of the fluid schemes: a Rossby-Haurwitz wave on the sphere."""

import numpy as np
import pytest

from geomhw.fluid.run import Plan
from geomhw.fluid.schemes import scheme_of
from geomhw.fluid.vorticity_scheme import VorticityScheme
from geomhw.mesh.primitives import icosphere
from support.exact import WAVE_RATE, last, rossby_haurwitz, start_of

# -- the conservative and the fast scheme -------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("scheme", "level", "bound"), [("conservative", 4, 0.025), ("conservative", 5, 0.01), ("rk4", 5, 0.003)]
)
def test_rossby_haurwitz(scheme: str, level: int, bound: float) -> None:
    """Relative L2 error of the total vorticity at Courant number 1 after 0.8 and 1 revolutions of the pattern."""
    mesh = icosphere(level)
    stepper = scheme_of(mesh, scheme)  # type: ignore[arg-type]
    assert isinstance(stepper, VorticityScheme)
    state = start_of(stepper, rossby_haurwitz(mesh))
    for share in (0.8, 1.0):
        T = share * 2 * np.pi / WAVE_RATE
        state = last(stepper, state, Plan(cfl=1.0, until=T, every=1000))
        assert state.time == T
        exact, found = rossby_haurwitz(mesh, T), stepper.vorticity(state)
        error = np.sqrt(mesh.vertex_areas @ (found - exact) ** 2 / (mesh.vertex_areas @ exact**2))
        assert error < bound
