"""Convergence of the fluid schemes: a Rossby-Haurwitz wave on the sphere."""

import numpy as np
import pytest

from geomhw.fluid.run import Plan, scheme_of
from geomhw.fluid.vorticity_scheme import VorticityScheme
from geomhw.mesh.primitives import icosphere
from support.exact import WAVE_RATE, last, rossby_haurwitz
from support.rates import fitted_rate

LEVELS = (3, 4, 5)


def wave_errors(level: int, scheme: str) -> tuple[float, float]:
    """Return the relative L2 errors of the total vorticity after 0.8 and 1 revolutions, at Courant number 1."""
    mesh = icosphere(level)
    stepper = scheme_of(mesh, scheme)  # type: ignore[arg-type]
    assert isinstance(stepper, VorticityScheme)
    state, errors = stepper.from_vorticity(rossby_haurwitz(mesh)), []
    for share in (0.8, 1.0):
        T = share * 2 * np.pi / WAVE_RATE
        state = last(stepper, state, Plan(cfl=1.0, until=T, every=1000))
        assert state.time == T
        exact, found = rossby_haurwitz(mesh, T), stepper.vorticity(state)
        errors.append(np.sqrt(mesh.vertex_areas @ (found - exact) ** 2 / (mesh.vertex_areas @ exact**2)))
    return errors[0], errors[1]


@pytest.mark.parametrize(("scheme", "bounds"), [("conservative", (0.08, 0.025, 0.01)), ("rk4", (0.035, 0.007, 0.003))])
def test_rossby_haurwitz(scheme: str, bounds: tuple[float, ...]) -> None:
    """The vorticity of a Rossby-Haurwitz wave converges to the exact one with order h², at a fixed Courant number."""
    errors = [wave_errors(level, scheme) for level in LEVELS]
    assert all(max(pair) < bound for pair, bound in zip(errors, bounds, strict=True)), errors
    sizes = [icosphere(level).mean_edge_length for level in LEVELS]
    for after in zip(*errors, strict=True):
        assert fitted_rate(sizes, after) > 1.85, errors
