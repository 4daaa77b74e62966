"""Methods as functions of a mesh with a source, a field and a color, for tests of what their results depend on."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from geomhw.curves import isolines as level_lines
from geomhw.flow.advection import flow_of
from geomhw.flow.helmholtz import HelmholtzDecomposition
from geomhw.fluid.run import Plan, run, scheme_of
from geomhw.geodesic.exact import ExactDistance
from geomhw.geodesic.heat_method import HeatDistance
from geomhw.geodesic.heat_step import HeatStep
from geomhw.geodesic.shortest_paths import ShortestPaths
from geomhw.geodesic.straightest import StraightestGeodesics
from geomhw.mesh.named_points import vertex_points
from geomhw.mesh.orientation import oriented
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.options import Location
from geomhw.scalars.smoothing import smooth as smoothed
from geomhw.scalars.vertex_gradient import vertex_gradient
from geomhw.spectral.killing_fields import killing_fields
from geomhw.spectral.laplacian_spectrum import laplacian_spectrum
from geomhw.transport.log_map import LogarithmicMap
from geomhw.transport.vector_heat import VectorHeat
from support.hostile import Arrays


@dataclass(frozen=True)
class Case:
    """A mesh with two vertices, a field per face, a color per vertex, a time, its size, and a source vector."""

    mesh: TriangleMesh
    source: int
    field: np.ndarray
    color: np.ndarray
    time: float
    size: float
    vector: tuple[float, ...] = (1.0, 2.0, 3.0)
    target: int = 0


#: Arrays by name, with their location, and the size to which differences are relative.
Answer = dict[str, tuple[np.ndarray, Location, float]]


def geodesic(case: Case) -> Answer:
    distance = np.asarray(HeatDistance(case.mesh, "h2").from_vertices([case.source])["distance"])
    return {"distance": (distance, "vertex", distance[np.isfinite(distance)].max())}


def robust(case: Case) -> Answer:
    """Refined distances, which are exact, beside the heat on the intrinsic triangulation."""
    distance = np.asarray(HeatDistance(case.mesh, "h2", robust=True).from_vertices([case.source])["distance"])
    return {"distance": (distance, "vertex", distance[np.isfinite(distance)].max())}


def robust_heat(case: Case) -> Answer:
    """Distances by heat on the intrinsic triangulation."""
    solver = HeatDistance(case.mesh, "h2", robust=True, refine=False)
    distance = np.asarray(solver.from_vertices([case.source])["distance"])
    return {"distance": (distance, "vertex", distance[np.isfinite(distance)].max())}


def exact(case: Case) -> Answer:
    distance = np.asarray(ExactDistance(case.mesh).from_vertices([case.source])["distance"])
    return {"distance": (distance, "vertex", distance[np.isfinite(distance)].max())}


def vecdiffuse(case: Case) -> Answer:
    """Transport, but not to where vectors from several sides cancel and leave rounding."""
    result = VectorHeat(case.mesh, "h2").from_vertices([case.source], [case.vector])
    heat = HeatStep(case.mesh, "h2").from_impulse(vertex_points(case.mesh, [case.source]).impulse(len(case.color)))
    size = np.linalg.norm(result["diffused"], axis=1)
    clear = (size > 1e-4 * heat.plain) & (heat.plain > 1e-200)
    return {"transported": (np.where(clear[:, None], result["transported"], 0.0), "vertex", 1.0)}


def advect(case: Case) -> Answer:
    return {"color": (flow_of(case.mesh, case.field).advect(case.color, case.time), "vertex", 1.0)}


def helmholtz(case: Case) -> Answer:
    result, size = HelmholtzDecomposition(case.mesh)(case.field), largest(case.field)
    parts: Answer = {name: (np.asarray(result[name]), "face", size) for name in ("curl_free", "coexact", "harmonic")}
    return parts | {"potential": (np.asarray(result["potential"]), "vertex", size * case.size)}


def fluid(case: Case) -> Answer:
    scheme = scheme_of(oriented(case.mesh), "conservative")
    states = run(scheme, scheme.start(case.field, case.color), Plan(dt=case.time, steps=2, every=2))
    state = [snapshot.state for snapshot in states][-1]
    velocity = scheme.velocity(state)
    return {"velocity": (velocity, "face", largest(case.field)), "color": (state.color, "vertex", 1.0)}


def path(case: Case) -> Answer:
    """Length of the shortest path between the two vertices."""
    ends = (vertex_points(case.mesh, [vertex]) for vertex in (case.source, case.target))
    (found,) = ShortestPaths(case.mesh).between(*ends)
    return {"length": (np.array([found.length]), "mesh", case.size)}


def trace(case: Case) -> Answer:
    """Vector from the start of a short straightest geodesic to its end."""
    source = vertex_points(case.mesh, [case.source])
    found = StraightestGeodesics(case.mesh).trace(source, case.vector, case.size / 20)
    return {"end": (found.positions[-1:] - found.positions[0], "mesh", case.size)}


def logmap(case: Case) -> Answer:
    """Radii of the logarithmic map; its angles depend on the first edge."""
    result = LogarithmicMap(case.mesh).from_source(vertex_points(case.mesh, [case.source]))
    return {"radius": (np.asarray(result["radius"]), "vertex", case.size)}


def spectrum(case: Case) -> Answer:
    """Smallest eigenvalues of the Laplacian on functions, without unit."""
    values = np.array(laplacian_spectrum(case.mesh, 6).report["eigenvalues"]) * case.size**2
    return {"eigenvalues": (values, "mesh", max(values.max(), 1.0))}


def isolines(case: Case) -> Answer:
    """Length of two level lines."""
    lines = level_lines(case.mesh, case.color, [0.1, 0.5])
    return {"length": (np.array([lines.lengths.sum()]), "mesh", case.size)}


def smooth(case: Case) -> Answer:
    return {"smoothed": (smoothed(case.mesh, case.color, case.size / 10), "vertex", 1.0)}


def gradient(case: Case) -> Answer:
    """Gradient of the color per size; thin faces, which hardly determine it, make it large."""
    found = vertex_gradient(case.mesh, case.color) * case.size
    return {"gradient": (found, "vertex", max(largest(found), 10.0))}


def killing(case: Case) -> Answer:
    """Two smallest energies, without unit."""
    energies = np.array(killing_fields(case.mesh, 2).report["energies"]) * case.size**2
    return {"energies": (energies, "mesh", 10 * max(energies.max(), 1.0))}


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
    source, target = (int(given.faces[len(given.faces) // k, 0]) for k in (2, 3))
    return Case(given, source, field, color, 0.01, size, target=target)


def largest(field: np.ndarray) -> float:
    """Return the length of the longest vector of a field."""
    return float(np.linalg.norm(field, axis=1).max())


def scaled(case: Case, factor: float) -> Case:
    mesh = TriangleMesh(case.mesh.vertices * factor, case.mesh.faces)
    return replace(case, mesh=mesh, field=case.field * factor, size=case.size * factor)
