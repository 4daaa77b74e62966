"""Fluid schemes refuse wrong plans, meshes, options and steps that are too long."""

import re

import numpy as np
import pytest

from geomhw.errors import ConvergenceError, FieldError, MeshError
from geomhw.flow.initial_fields import random_field
from geomhw.fluid.conservative import ConservativeScheme
from geomhw.fluid.run import Plan, run
from geomhw.fluid.schemes import scheme_of
from geomhw.fluid.stable_fluids import StableFluidsScheme
from geomhw.mesh.primitives import moebius_band
from support.meshes import zoo_mesh

SCHEMES = ("conservative", "rk4", "stable-fluids")


@pytest.mark.parametrize(
    ("plan", "words"),
    [
        ({"dt": -1.0, "steps": 1}, "dt must be"),
        ({"dt": float("nan"), "steps": 1}, "dt must be"),
        ({"cfl": 0.0, "steps": 1}, "cfl must be"),
        ({"dt": 1.0, "until": float("inf")}, "until must be"),
        ({"dt": 1.0}, "ends either"),
        ({"steps": 1}, "of dt or of"),
        ({"dt": 1.0, "steps": 0}, "at least one step"),
        ({"dt": 1.0, "steps": 1, "every": 0}, "at least one"),
    ],
)
def test_plans_refused(plan: dict[str, float], words: str) -> None:
    """Each plan that is none has its sentence."""
    with pytest.raises(FieldError, match=words):
        Plan(**plan)  # type: ignore[arg-type]


def test_refusals() -> None:
    """One-sided meshes, unknown schemes, negative viscosity, a flow at rest with a Courant number."""
    band = moebius_band(24, 3)
    for scheme in SCHEMES:
        with pytest.raises(MeshError, match="oriented manifold"):
            scheme_of(band, scheme)  # type: ignore[arg-type]
    mesh = zoo_mesh("sphere")
    with pytest.raises(FieldError, match="conservative, rk4, stable-fluids"):
        scheme_of(mesh, "best")  # type: ignore[arg-type]
    with pytest.raises(FieldError, match="full, increment"):
        StableFluidsScheme(mesh, "none")  # type: ignore[arg-type]
    with pytest.raises(FieldError, match="viscosity"):
        ConservativeScheme(mesh, viscosity=-1.0)
    with pytest.raises(FieldError, match="viscosity"):
        scheme_of(mesh, "stable-fluids", viscosity=1.0)
    scheme_at_rest = ConservativeScheme(mesh)
    rest = scheme_at_rest.start(np.zeros((mesh.n_faces, 3)), np.zeros(mesh.n_vertices))
    with pytest.raises(FieldError, match="at rest"):
        list(run(scheme_at_rest, rest, Plan(cfl=1.0, steps=1), None))


@pytest.mark.parametrize("scheme", SCHEMES)
def test_steps_too_large_are_refused_not_nan(scheme: str) -> None:
    """A step of many thousand cells ends in a sentence; no state with NaN comes out."""
    mesh = zoo_mesh("sphere")
    stepper = scheme_of(mesh, scheme)  # type: ignore[arg-type]
    state = stepper.start(random_field(mesh, 1), mesh.vertices[:, 0])
    with pytest.raises(ConvergenceError, match="shorter"):
        stepper.step(state, 1e6, None)


@pytest.mark.parametrize("name", ["sphere", "crumpled_torus"])
@pytest.mark.parametrize("scheme", ["conservative", "rk4"])
def test_the_largest_courant_number_is_named(scheme: str, name: str) -> None:
    """The refusal of a long step names a Courant number that runs, and whose double does not."""
    mesh = zoo_mesh(name)
    stepper = scheme_of(mesh, scheme)  # type: ignore[arg-type]
    start = stepper.start(random_field(mesh, 1), np.zeros(mesh.n_vertices))
    with pytest.raises(ConvergenceError, match="step 1 is too long") as refusal:
        list(run(stepper, start, Plan(cfl=40.0, steps=1), None))
    found = re.search(r"on this mesh is (\S+) \(dt (\S+)\)", str(refusal.value))
    assert found
    assert 0.2 < float(found[1]) < 20
    for plan in (Plan(cfl=float(found[1]), steps=1), Plan(dt=float(found[2]), steps=1)):
        assert len(list(run(stepper, start, plan, None))) == 2
    with pytest.raises(ConvergenceError):
        stepper.step(start, 2 * float(found[2]), None)
