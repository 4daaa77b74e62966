"""Exact solutions on the sphere, and computed fields with their errors against exact ones."""

import numpy as np

from geomhw.flow.advection import flow_of
from geomhw.flow.initial_fields import rigid_field
from geomhw.fluid.conservative import ConservativeScheme
from geomhw.fluid.run import Plan, run
from geomhw.fluid.state import FlowState, Scheme
from geomhw.geodesic.heat_method import HeatDistance
from geomhw.mesh.primitives import cylinder_band, icosphere
from geomhw.mesh.surface_points import SurfacePoints
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.options import Connection, Integrator
from geomhw.transport.vector_heat import VectorHeat, random_tangent

Z = np.array([0.0, 0.0, 1.0])


def smooth(points: np.ndarray) -> np.ndarray:
    """Return a function without symmetry about the axis."""
    x, y, z = points.T
    return np.exp(2 * x) + x * y - z


def turned_error(level: int, integrator: Integrator, angle: float) -> tuple[float, float]:
    """Return the relative L2 error of a function advected by a rotation, and h."""
    mesh = icosphere(level)
    advected = flow_of(mesh, rigid_field(mesh, Z), integrator).advect(smooth(mesh.vertices), angle)
    c, s = np.cos(-angle), np.sin(-angle)
    back = mesh.vertices @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]).T
    exact = smooth(back)
    norm = np.sqrt(mesh.vertex_areas @ exact**2)
    return float(np.sqrt(mesh.vertex_areas @ (advected - exact) ** 2) / norm), mesh.mean_edge_length


#: Rate at which a Rossby-Haurwitz wave of degree 4 turns on a unit sphere under Ω = 1.
WAVE_RATE = 1 - 2 / (4 * 5)


def rossby_haurwitz(mesh: TriangleMesh, time: float = 0.0) -> np.ndarray:
    """Return the exact total vorticity 2Ωz + 2 Re(x+iy)⁴, the wave turned by Ω(1 - 2/(l(l+1))) t."""
    x, y, z = mesh.vertices.T
    turned = (x + 1j * y) * np.exp(-1j * WAVE_RATE * time)
    return 2 * z + 2 * (turned**4).real


def last(scheme: Scheme, state: FlowState, plan: Plan) -> FlowState:
    """Return the state at the end of a run without force."""
    return [snapshot.state for snapshot in run(scheme, state, plan, None)][-1]


def wave_velocity(mesh: TriangleMesh) -> np.ndarray:
    """Return the velocity of the wave at time 0."""
    scheme = ConservativeScheme(mesh)
    return scheme.velocity(scheme.from_vorticity(rossby_haurwitz(mesh)))


def cylinder() -> tuple[TriangleMesh, np.ndarray]:
    """Return a cylinder and the distances from its vertex 0: the shorter straight line of two unfoldings."""
    n = 24
    mesh = cylinder_band(n, 8, height=2.0)
    width = 2 * n * np.sin(np.pi / n)
    across = np.arange(mesh.n_vertices) % n * (width / n)
    up = mesh.vertices[:, 2] - mesh.vertices[0, 2]
    return mesh, np.minimum(np.hypot(across, up), np.hypot(width - across, up))


def great_circle(mesh: TriangleMesh, source: int) -> np.ndarray:
    """Return exact distances on the unit sphere."""
    a, b = mesh.vertices, mesh.vertices[source]
    return np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), a @ b)


INSIDE = [0.2, 0.3, 0.5]


def errors(
    mesh: TriangleMesh, sources: SurfacePoints, exact: np.ndarray, time: str = "h2"
) -> tuple[float, float, float]:
    """Return the mean error within 3 h of the sources, and the mean and largest error beyond, in h."""
    h = mesh.mean_edge_length
    error = np.abs(HeatDistance(mesh, time).from_sources(sources)["distance"] - exact) / h
    near = (exact > 0) & (exact < 3 * h)
    far = exact >= 3 * h
    return float(error[near].mean()), float(error[far].mean()), float(error[far].max())


def along_great_circles(mesh: TriangleMesh, source: int, vector: np.ndarray) -> np.ndarray:
    """Return exact transport on the unit sphere: the rotation from the source to each vertex; unit, tangent."""
    a, x = mesh.vertices[source], mesh.vertices
    axis, cosine = np.cross(a, x), x @ a
    moved = vector * cosine[:, None] + np.cross(axis, vector)
    moved += axis * (axis @ vector)[:, None] / np.maximum(1 + cosine, 1e-12)[:, None]
    moved -= np.einsum("vx,vx->v", moved, mesh.vertex_normals)[:, None] * mesh.vertex_normals
    return moved / np.linalg.norm(moved, axis=1)[:, None]


def mean_angle_error(level: int, connection: Connection, time: str) -> float:
    """Return the mean angle in degrees to exact transport, without 10° about the antipode, over six sources."""
    mesh = icosphere(level)
    solver = VectorHeat(mesh, time, connection)
    errors = []
    for source in (0, 12, 42, 100, 300, 641):
        vector = random_tangent(mesh, source, seed=1)
        X = solver.from_vertices([source], [vector])["transported"]
        np.testing.assert_allclose(np.linalg.norm(X, axis=1), 1, atol=1e-12)
        exact = along_great_circles(mesh, source, vector)
        angle = np.arctan2(np.linalg.norm(np.cross(X, exact), axis=1), np.einsum("vx,vx->v", X, exact))
        kept = mesh.vertices @ mesh.vertices[source] > -np.cos(np.radians(10))
        errors.append(np.degrees(angle[kept]).mean())
    return float(np.mean(errors))
