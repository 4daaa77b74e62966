"""Fields and colors to start a flow from, in closed form."""

import numpy as np

from geomhw.errors import FieldError
from geomhw.mesh.arrays import Floats
from geomhw.mesh.geometry import unit
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.methods.tangent_fields import tangential


def rigid_field(mesh: TriangleMesh, axis: Floats) -> Floats:
    """Tangential part of ω x r at the face centers, (m, 3): one radian a unit of time about an axis through 0."""
    omega = np.asarray(axis, dtype=float)
    if omega.shape != (3,) or not np.isfinite(omega).all() or not omega.any():
        raise FieldError(f"an axis is a direction of three numbers, not {np.asarray(axis).tolist()}")
    return tangential(mesh, np.cross(unit(omega), mesh.face_centers))


def rotation_field(mesh: TriangleMesh, axis: Floats) -> Floats:
    """The handout's field: ω x r projected to the faces, unit length, times 10 h; zero where it has no direction."""
    return np.asarray(10 * mesh.mean_edge_length * unit(rigid_field(mesh, axis)))


def hue_stripes(mesh: TriangleMesh) -> Floats:
    """The handout's colors, (n, 3) in 0..1: hue cos²(3z), full saturation and value."""
    hue = np.cos(3 * mesh.vertices[:, 2]) ** 2
    # Each channel is a trapezoid of the hue, a third of a turn apart.
    offset = np.array([0.0, 2 / 3, 1 / 3])
    distance = np.abs((hue[:, None] + offset + 0.5) % 1 - 0.5)
    return np.clip(2 - 6 * distance, 0, 1)


def blob(mesh: TriangleMesh, vertex: int) -> Floats:
    """A Gaussian bump about a vertex, (n,), 1 at its top; its width is a twelfth of the mesh's diagonal, or 3 h."""
    if not 0 <= vertex < mesh.n_vertices:
        raise FieldError(f"vertex {vertex} does not exist: the mesh has {mesh.n_vertices} (0 to {mesh.n_vertices - 1})")
    width = max(np.linalg.norm(np.ptp(mesh.vertices, axis=0)) / 12, 3 * mesh.mean_edge_length)
    distance = np.linalg.norm(mesh.vertices - mesh.vertices[vertex], axis=1)
    return np.asarray(np.exp(-0.5 * (distance / width) ** 2))
