"""Methods as functions of a mesh with a source, a field and a color, for tests of what their results depend on."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from geomhw.curves import isolines as level_lines
from geomhw.curves import signed_distance, split_mesh
from geomhw.directions import DirectionFields
from geomhw.flow.advection import flow_of
from geomhw.flow.field_derivatives import FieldDerivatives, derivatives_of
from geomhw.flow.helmholtz import HelmholtzDecomposition
from geomhw.flow.pushforward import Pushforward
from geomhw.flow.tangent_fields import tangential
from geomhw.fluid.run import Plan, run, scheme_of
from geomhw.geodesic.exact import ExactDistance
from geomhw.geodesic.heat_method import HeatDistance
from geomhw.geodesic.heat_step import HeatStep
from geomhw.geodesic.shortest_paths import ShortestPaths
from geomhw.geodesic.straightest import StraightestGeodesics
from geomhw.geodesic.voronoi import voronoi_cells
from geomhw.mesh.curve_points import curve_points
from geomhw.mesh.named_points import vertex_points
from geomhw.mesh.orientation import oriented
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.options import Location
from geomhw.scalars.smoothing import smooth as smoothed
from geomhw.scalars.vertex_gradient import vertex_gradient
from geomhw.spectral.killing_fields import killing_fields
from geomhw.spectral.laplacian_spectrum import laplacian_spectrum
from geomhw.transport.log_map import LogarithmicMap
from geomhw.transport.surface_means import karcher_mean
from geomhw.transport.vector_heat import VectorHeat
from support.hostile import Arrays


@dataclass(frozen=True)
class Case:
    """A mesh with two vertices, a field per face, a color per vertex, a time, its size, a source vector, and a face."""

    mesh: TriangleMesh
    source: int
    field: np.ndarray
    color: np.ndarray
    time: float
    size: float
    vector: tuple[float, ...] = (1.0, 2.0, 3.0)
    target: int = 0
    corners: tuple[int, ...] = (0, 0, 0)


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


def bracket(case: Case) -> Answer:
    """Lie bracket of the field and of a constant vector, per size."""
    U, V = (tangential(case.mesh, field) for field in (case.field, case.size * constant(case)))
    found = FieldDerivatives(case.mesh).bracket(U, V)
    return {"bracket": (found, "face", max(largest(found), 10 * case.size))}


def derive(case: Case) -> Answer:
    """Derivatives of the field without a sign that the orientation decides."""
    found = derivatives_of(oriented(case.mesh), case.field, case.field)
    along, divergence = (np.asarray(found[name]) for name in ("covariant_derivative", "divergence"))
    size = max(float(np.abs(divergence).max()), 10.0)
    return {
        "covariant_derivative": (along, "face", max(largest(along), 10 * case.size)),
        "divergence": (divergence, "vertex", size),
    }


def push(case: Case) -> Answer:
    """A constant vector field carried by the field for a tenth of the time."""
    flow = Pushforward(oriented(case.mesh), case.field)
    found = flow.field(tangential(case.mesh, case.size * constant(case)), case.time / 10)
    return {"pushed": (found, "face", max(largest(found), case.size))}


def design(case: Case) -> Answer:
    """Energy of the smoothest cross field, without unit."""
    fields = DirectionFields(oriented(case.mesh), 4)
    energy = fields.result(fields.smoothest()).report["energy"]
    energies = np.array([energy]) * case.size**2
    return {"energy": (energies, "mesh", max(energies.max(), 1.0))}


def signed(case: Case) -> Answer:
    """Distance from the border of a face, without the sign, which the orientation decides."""
    mesh = oriented(case.mesh)
    mesh.require_oriented("signed distance")
    face = np.flatnonzero(np.isin(mesh.faces, case.corners).all(axis=1))[0]
    places = mesh.faces[face].tolist()
    weights = np.eye(3)[[places.index(vertex) for vertex in (*case.corners, case.corners[0])]]
    curve = curve_points(mesh, np.full(4, face), weights)
    found = np.abs(signed_distance(mesh, curve)["signed_distance"])
    return {"distance": (found, "vertex", case.size)}


def split(case: Case) -> Answer:
    """Areas of the pieces between level lines, without order."""
    lines = level_lines(case.mesh, case.color, [0.1, 0.5])
    pieces = split_mesh(case.mesh, lines.curves)
    areas = np.bincount(pieces.pieces, pieces.mesh.face_areas)
    return {"areas": (np.sort(areas), "mesh", areas.sum())}


def voronoi(case: Case) -> Answer:
    """Areas of the cells of two sites."""
    cells = voronoi_cells(case.mesh, vertex_points(case.mesh, [case.source, case.target]))
    return {"areas": (cells.areas, "mesh", cells.areas.sum())}


def center(case: Case) -> Answer:
    """Sum of the squared distances from the mean of three points."""
    found = karcher_mean(case.mesh, vertex_points(case.mesh, [case.source, *case.corners[:2]]))
    return {"sum": (np.array([found.value]), "mesh", case.size**2)}


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
    corners = tuple(given.faces[len(given.faces) // 3].tolist())
    return Case(given, source, field, color, 0.01, size, target=target, corners=corners)


def constant(case: Case) -> np.ndarray:
    """Return the vector of the case on every face."""
    return np.tile(case.vector, (case.mesh.n_faces, 1))


def largest(field: np.ndarray) -> float:
    """Return the length of the longest vector of a field."""
    return float(np.linalg.norm(field, axis=1).max())


def scaled(case: Case, factor: float) -> Case:
    mesh = TriangleMesh(case.mesh.vertices * factor, case.mesh.faces)
    return replace(case, mesh=mesh, field=case.field * factor, size=case.size * factor)
