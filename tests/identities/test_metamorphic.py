"""Results do not depend on numbering, on the orientation of faces, on the unit of length, or on the position."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest

from geomhw.errors import GeomhwError
from geomhw.flow.advection import flow_of
from geomhw.flow.helmholtz import HelmholtzDecomposition
from geomhw.fluid.run import Plan, run, scheme_of
from geomhw.geodesic.heat_method import HeatDistance
from geomhw.geodesic.heat_step import HeatStep
from geomhw.mesh.orientation import oriented
from geomhw.mesh.surface_points import vertex_points
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.options import Location
from geomhw.transport.vector_heat import VectorHeat
from support.hostile import HOSTILE, Arrays, far_away, flipped, pinched_meshes, renumbered, rotated_corners


@dataclass(frozen=True)
class Case:
    """A mesh with a source vertex, a field per face, a color per vertex, a time, and its size."""

    mesh: TriangleMesh
    source: int
    field: np.ndarray
    color: np.ndarray
    time: float
    size: float


#: Arrays by name, with their location, and the size to which differences are relative.
Answer = dict[str, tuple[np.ndarray, Location, float]]


def geodesic(case: Case) -> Answer:
    distance = np.asarray(HeatDistance(case.mesh, "h2").from_vertices([case.source])["distance"])
    return {"distance": (distance, "vertex", distance[np.isfinite(distance)].max())}


def vecdiffuse(case: Case) -> Answer:
    """Transport, but not to where vectors from several sides cancel and leave rounding."""
    result = VectorHeat(case.mesh, "h2").from_vertices([case.source], [[1.0, 2.0, 3.0]])
    heat = HeatStep(case.mesh, "h2").from_impulse(vertex_points(case.mesh, [case.source]).impulse(len(case.color)))
    size = np.linalg.norm(result["diffused"], axis=1)
    clear = (size > 1e-4 * heat.plain) & (heat.plain > 1e-200)
    return {"transported": (np.where(clear[:, None], result["transported"], 0.0), "vertex", 1.0)}


def advect(case: Case) -> Answer:
    return {"color": (flow_of(case.mesh, case.field).advect(case.color, case.time), "vertex", 1.0)}


def helmholtz(case: Case) -> Answer:
    result, size = HelmholtzDecomposition(case.mesh)(case.field), float(np.abs(case.field).max())
    parts: Answer = {name: (np.asarray(result[name]), "face", size) for name in ("curl_free", "coexact", "harmonic")}
    return parts | {"potential": (np.asarray(result["potential"]), "vertex", size * case.size)}


def fluid(case: Case) -> Answer:
    scheme = scheme_of(oriented(case.mesh), "conservative")
    states = run(scheme, scheme.start(case.field, case.color), Plan(dt=case.time, steps=2, every=2))
    state = [snapshot.state for snapshot in states][-1]
    velocity = scheme.velocity(state)
    return {"velocity": (velocity, "face", float(np.abs(case.field).max())), "color": (state.color, "vertex", 1.0)}


COMMANDS: dict[str, Callable[[Case], Answer]] = {
    "geodesic": geodesic,
    "vecdiffuse": vecdiffuse,
    "advect": advect,
    "helmholtz": helmholtz,
    "fluid": fluid,
}


def case_of(mesh: Arrays) -> Case:
    """Return a field of rotation and stretch whose speed is the size per time, and a short time."""
    given = TriangleMesh(*mesh)
    used = given.vertices[np.unique(given.faces)]
    size = float(np.linalg.norm(np.ptp(used, axis=0)))
    centers, x = ((points - used.mean(axis=0)) / size for points in (given.face_centers, given.vertices))
    field = size * (np.cross([0.3, -0.4, 1.0], centers) + centers @ np.diag([1.0, -0.5, 0.2]) + 0.1)
    color = np.sin(4 * x[:, 0]) + np.cos(3 * x[:, 1] + 5 * x[:, 2])
    return Case(given, int(given.faces[len(given.faces) // 2, 0]), field, color, 0.01, size)


def scaled(case: Case, factor: float) -> Case:
    mesh = TriangleMesh(case.mesh.vertices * factor, case.mesh.faces)
    return Case(mesh, case.source, case.field * factor, case.color, case.time, case.size * factor)


def differences(command: str, case: Case, expected: Answer, places: np.ndarray, order: np.ndarray) -> dict[str, float]:
    """Return the largest difference of each array from that of the case before it was renumbered."""
    found = COMMANDS[command](case)
    largest = {}
    for name, (values, location, size) in expected.items():
        former = values[places if location == "vertex" else order]
        finite = np.isfinite(former)
        np.testing.assert_array_equal(np.isfinite(found[name][0]), finite)
        ours, theirs = found[name][0][finite] / found[name][2], former[finite] / size
        largest[name] = float(np.abs(ours - theirs).max(initial=0.0))
    return largest


#: Meshes whose coordinates are refused, or would be after a scaling or a translation.
BEYOND = {"huge_150", "tiny_150", "tiny_310", "far_lost", "one_point"}
#: Meshes with faces so low that the rounding of coordinates a million sizes away removes them.
LOW = {"mixed_scales", "needle_12", "needle_below", "sheared_6", "huge"}
#: Tolerances on slivers, and far away; None where rounding decides, which the report of `geodesic` says.
SLIVERS: dict[tuple[str, str], float | None] = {
    **{(name, "geodesic"): 1e-3 for name in ("needle_12", "needle_below", "sheared")},
    ("sheared_6", "geodesic"): None,
    ("sheared_6", "vecdiffuse"): None,
    ("sheared_6", "helmholtz"): None,
    ("sheared_6", "fluid"): 1e-3,
    ("sheared", "helmholtz"): 1e-5,
    ("sheared", "vecdiffuse"): 1e-6,
    ("mixed_scales", "vecdiffuse"): 1e-4,
    ("far", "vecdiffuse"): 1e-6,
    ("far", "helmholtz"): 1e-6,
    ("far", "fluid"): 1e-6,
}
MESHES = {name: make for name, make in HOSTILE.items() if name not in BEYOND}
MESHES |= {name: (lambda mesh=mesh: mesh) for name, mesh in pinched_meshes().items()}


@pytest.mark.parametrize("name", MESHES)
def test_invariance(name: str) -> None:
    """Each method gives the same on a mesh that is renumbered, flipped, moved by a million sizes, or scaled."""
    mesh = MESHES[name]()
    case = case_of(mesh)
    same = np.arange(len(mesh[0])), np.arange(len(mesh[1]))
    other, places, order = renumbered(mesh)
    source = int(np.argsort(places)[case.source])
    new = Case(TriangleMesh(*other), source, case.field[order], case.color[places], case.time, case.size)
    cases = {
        "renumbered": (new, places, order, 1e-8),
        "corners": (replace(case, mesh=TriangleMesh(*rotated_corners(mesh))), *same, 1e-8),
        "flipped": (replace(case, mesh=TriangleMesh(*flipped(mesh))), *same, 1e-8),
        "far away": (replace(case, mesh=TriangleMesh(*far_away(mesh))), *same, 1e-5),
        "scaled": (scaled(case, 1e-7 if case.size > 1 else 1e7), *same, 1e-8),
    }
    if name in LOW:
        del cases["far away"]
    for command in COMMANDS:
        tolerance = SLIVERS.get((name, command), 0.0)
        try:
            expected = COMMANDS[command](case)
        except GeomhwError:
            continue
        if tolerance is None:
            continue
        for change, (changed, *numbers, usual) in cases.items():
            if (name, command, change) == ("touching_edge", "vecdiffuse", "flipped"):
                continue  # vectors pass edges of four faces by the mean of normals, as the report warns
            found = differences(command, changed, expected, *numbers)
            assert max(found.values()) <= max(usual, tolerance), (command, change, found)
