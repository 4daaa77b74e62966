"""Fields and colors to start a flow from, in closed form."""

import numpy as np

from geomhw.arrays import Floats
from geomhw.errors import FieldError
from geomhw.flow.tangent_fields import tangential
from geomhw.mesh.geometry import unit
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.curl import quarter_turn
from geomhw.operators.gradient import gradient_of


def rigid_field(mesh: TriangleMesh, axis: Floats) -> Floats:
    """Tangential part of ω x r at the face centers, (m, 3): one radian a unit of time about an axis through 0."""
    omega = np.asarray(axis, dtype=float)
    if omega.shape != (3,) or not np.isfinite(omega).all() or not omega.any():
        raise FieldError(f"an axis is a direction of three numbers, not {np.asarray(axis).tolist()}")
    return tangential(mesh, np.cross(unit(omega), mesh.face_centers))


def rotation_field(mesh: TriangleMesh, axis: Floats) -> Floats:
    """The handout's field: ω x r projected to the faces, unit length, times 10 h; zero where it has no direction."""
    return np.asarray(10 * mesh.mean_edge_length * unit(rigid_field(mesh, axis)))


def hue_stripes(mesh: TriangleMesh, axis: Floats | None = None) -> Floats:
    """The handout's colors, (n, 3) in 0..1: hue cos²(3z), full saturation and value.

    axis: a direction, along which the mesh is taken to reach from -1 to 1, whatever its size; None takes z as it is.
    """
    height = mesh.vertices[:, 2] if axis is None else _from_end_to_end(mesh, axis)
    hue = np.cos(3 * height) ** 2
    # Each channel is a trapezoid of the hue, a third of a turn apart.
    offset = np.array([0.0, 2 / 3, 1 / 3])
    distance = np.abs((hue[:, None] + offset + 0.5) % 1 - 0.5)
    return np.clip(2 - 6 * distance, 0, 1)


def _from_end_to_end(mesh: TriangleMesh, axis: Floats) -> Floats:
    """How far along an axis each vertex is, (n,), from -1 to 1 over the mesh; zero where it has no extent."""
    height = mesh.vertices @ unit(np.asarray(axis, dtype=float))
    used = height[np.unique(mesh.faces)]
    half = np.ptp(used) / 2
    return np.asarray((height - used.min()) / half - 1 if half > 0 else np.zeros_like(height))


def blob(mesh: TriangleMesh, vertex: int) -> Floats:
    """A `bump` about a vertex, (n,)."""
    if not 0 <= vertex < mesh.n_vertices:
        raise FieldError(f"vertex {vertex} does not exist: the mesh has {mesh.n_vertices} (0 to {mesh.n_vertices - 1})")
    return bump(mesh, mesh.vertices[vertex])


def bump(mesh: TriangleMesh, center: Floats) -> Floats:
    """A Gaussian bump about a point in space, (n,), 1 there; its width is a twelfth of the mesh's diagonal, or 3 h."""
    width = max(np.linalg.norm(np.ptp(mesh.vertices, axis=0)) / 12, 3 * mesh.mean_edge_length)
    distance = np.linalg.norm(mesh.vertices - center, axis=1)
    return np.asarray(np.exp(-0.5 * (distance / width) ** 2))


def random_field(mesh: TriangleMesh, seed: int, waves: int = 8) -> Floats:
    """A smooth random flow, (m, 3): n x ∇ of sixty-four plane waves, its fastest part 10 h a unit of time; FieldError
    unless ``waves`` is positive.

    The waves are drawn from the seed with at most ``waves`` radians to half the mesh's diameter, so that the flow
    depends neither on the scale of the mesh nor on how it is numbered.
    """
    if waves < 1:
        raise FieldError(f"a random flow has at least one wave, not {waves}")
    rng = np.random.default_rng(seed)
    low, high = mesh.vertices[np.unique(mesh.faces)].min(axis=0), mesh.vertices[np.unique(mesh.faces)].max(axis=0)
    radius = np.linalg.norm(high - low) / np.sqrt(12)  # that of a sphere with this box
    direction = unit(rng.normal(size=(64, 3)))
    k = waves * rng.random((64, 1)) ** (1 / 3) * direction
    phase, height = rng.uniform(0, 2 * np.pi, 64), rng.normal(size=64)
    at = (mesh.vertices - (low + high) / 2) / radius
    stream = np.cos(at @ k.T + phase) @ height
    slope = gradient_of(mesh, stream)
    V = quarter_turn(mesh, slope)
    return np.asarray(10 * mesh.mean_edge_length / np.linalg.norm(V, axis=1).max() * V)
