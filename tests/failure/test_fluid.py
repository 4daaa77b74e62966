"""Fluid schemes refuse wrong plans, meshes, options and steps that are too long."""

import re
from typing import Any

import numpy as np
import pytest

from geomhw.errors import ConvergenceError, FieldError, MeshError
from geomhw.flow.initial_fields import random_field
from geomhw.fluid import initial
from geomhw.fluid.conservation import ConservationCheck
from geomhw.fluid.conservative import ConservativeScheme
from geomhw.fluid.rk4 import RK4Scheme
from geomhw.fluid.run import Plan, run, scheme_of
from geomhw.fluid.stable_fluids import StableFluidsScheme
from geomhw.fluid.state import Diagnostics
from geomhw.mesh.primitives import icosphere, moebius_band
from geomhw.options import SchemeName
from support.flow_files import jagged
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
    """Each wrong plan raises with its own keyword."""
    with pytest.raises(FieldError, match=words):
        Plan(**plan)  # type: ignore[arg-type]


def test_refusals() -> None:
    """One-sided meshes, unknown names, negative viscosity, and a Courant number at rest raise."""
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


def test_initial_flows_refused() -> None:
    """Harmonic fields that do not exist, waves on other surfaces or of degree 1, and wrong vortices raise."""
    model = ConservativeScheme(zoo_mesh("crumpled_torus")).model
    with pytest.raises(FieldError, match="there are 0 to 1"):
        initial.harmonic(model, 2)
    with pytest.raises(FieldError, match="no handles"):
        initial.harmonic(ConservativeScheme(zoo_mesh("sphere")).model, 0)
    with pytest.raises(FieldError, match="sphere"):
        initial.rossby_haurwitz(model, 4)
    with pytest.raises(FieldError, match="radii"):
        initial.rossby_haurwitz(ConservativeScheme(zoo_mesh("crumpled_sphere")).model, 4)
    with pytest.raises(FieldError, match="degree"):
        initial.rossby_haurwitz(ConservativeScheme(zoo_mesh("sphere")).model, 1)
    with pytest.raises(FieldError, match="vertex 240"):
        initial.vortices(model, {240: 1.0})
    with pytest.raises(FieldError, match="not finite"):
        initial.vortices(model, {3: np.inf})


@pytest.mark.parametrize("scheme", SCHEMES)
def test_steps_too_large_are_refused_not_nan(scheme: str) -> None:
    """A step of thousands of cells raises, and no state with NaN is returned."""
    mesh = zoo_mesh("sphere")
    stepper = scheme_of(mesh, scheme)  # type: ignore[arg-type]
    state = stepper.start(random_field(mesh, 1), mesh.vertices[:, 0])
    with pytest.raises(ConvergenceError, match="shorter"):
        stepper.step(state, 1e6, None)


@pytest.mark.parametrize("name", ["sphere", "crumpled_torus"])
@pytest.mark.parametrize("scheme", ["conservative", "rk4"])
def test_the_largest_courant_number_is_named(scheme: str, name: str) -> None:
    """The message names a Courant number that succeeds and whose double fails."""
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


@pytest.mark.parametrize("wrong", [{"w": [1.0]}, {"w": [np.nan] * 240}, {"harmonic": [1.0]}, {"circulations": 1.0}])
def test_starts_refused(wrong: dict[str, Any]) -> None:
    """A vorticity, harmonic coefficients or circulations that are not one finite value for each are refused."""
    scheme = RK4Scheme(zoo_mesh("crumpled_torus"))
    with pytest.raises(FieldError, match="finite values"):
        scheme.from_vorticity(**{"w": np.zeros(scheme.mesh.n_vertices), **wrong})


def test_energy_that_runs_away() -> None:
    """On slivers stable-fluids gains energy in long steps: it is recorded, and the run stops before it doubles."""
    mesh, V = jagged(18)
    scheme = scheme_of(mesh, "stable-fluids")
    start = scheme.start(V)
    check, shots = ConservationCheck(scheme, start), []
    with pytest.raises(ConvergenceError, match=r"gains energy .* at step"):
        shots.extend(run(scheme, start, Plan(cfl=2.0, steps=12), None, check))
    energies = [Diagnostics(scheme)(shot.state, 0.0)["energy"] for shot in shots]
    assert len(energies) > 1
    assert max(energies) <= 2 * energies[0]
    assert check.since.get("energy") == next((k for k, E in enumerate(energies) if 1.01 * energies[0] < E), None)


def test_enstrophy_that_grows() -> None:
    """On slivers the conservative scheme may gain enstrophy, by the recorded share and from the recorded step on."""
    mesh, V = jagged(86)
    scheme = scheme_of(mesh, "conservative")
    start = scheme.start(V)
    check = ConservationCheck(scheme, start)
    rows = [Diagnostics(scheme)(shot.state, 0.0) for shot in run(scheme, start, Plan(cfl=2.0, steps=12), None, check)]
    ratios = [row["enstrophy"] / rows[0]["enstrophy"] for row in rows]
    assert check.excess == {"enstrophy": pytest.approx(max(ratios) - 1)}
    assert check.since == {"enstrophy": next(k for k, ratio in enumerate(ratios) if ratio > 1.01)}


@pytest.mark.parametrize("name", SCHEMES)
def test_forced_flow_keeps_its_bound(name: SchemeName) -> None:
    """What a force can do is no finding, also when a run resumes from a state in the middle."""
    mesh = icosphere(2)
    force, plan = initial.top_jet(mesh, 0.01), Plan(dt=0.01, steps=30)
    scheme = scheme_of(mesh, name)
    start = scheme.start(1e-3 * random_field(mesh, 1))
    check = ConservationCheck(scheme, start, force)
    states = [snapshot.state for snapshot in run(scheme, start, plan, force, check)]
    first = Diagnostics(scheme)(states[0], 0.01)
    resumed = ConservationCheck(scheme, states[15], force, first, 0.01)
    assert list(run(scheme, states[15], plan, force, resumed))
    assert check.since == resumed.since == {}
    assert resumed._bounds["energy"] == pytest.approx(check._bounds["energy"])
