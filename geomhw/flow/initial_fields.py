"""Vector fields and colors in closed form, to start a flow from."""

import numpy as np
from numpy.typing import ArrayLike

from geomhw.arrays import Floats
from geomhw.errors import ArgumentError
from geomhw.flow.tangent_fields import tangential
from geomhw.mesh.geometry import unit
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.curl import quarter_turn
from geomhw.operators.gradient import gradient_of

#: Largest wavenumber of a random flow.
MAX_WAVES = 10_000


def rigid_field(mesh: TriangleMesh, axis: ArrayLike) -> Floats:
    """Return the tangential part of the rotation ω x r at the face centers, one radian per unit of time.

    Parameters
    ----------
    axis : direction of ω, (3,), of any length; the axis passes through the origin.

    Returns
    -------
    (m, 3) array.

    Raises
    ------
    ArgumentError
        If the axis is zero, not finite, or has not three components.
    """
    omega = np.asarray(axis, dtype=float)
    if omega.shape != (3,) or not np.isfinite(omega).all() or not omega.any():
        raise ArgumentError(f"an axis needs three finite numbers that are not all zero, not {omega.tolist()}")
    return tangential(mesh, np.cross(unit(omega), mesh.face_centers))


def rotation_field(mesh: TriangleMesh, axis: ArrayLike) -> Floats:
    """Return the handout's field, (m, 3): the direction of `rigid_field`, of length 10 h; zero where that is zero."""
    return np.asarray(10 * mesh.mean_edge_length * unit(rigid_field(mesh, axis)))


def hue_stripes(mesh: TriangleMesh, axis: ArrayLike | None = None) -> Floats:
    """Return the handout's colors: hue cos²(3z) at full saturation and value.

    Parameters
    ----------
    axis : direction, (3,), along which the coordinate runs from -1 to 1 over the mesh; by default z as it is.

    Returns
    -------
    (n, 3) array, red, green and blue between 0 and 1.
    """
    height = mesh.vertices[:, 2] if axis is None else _normalized_height(mesh, axis)
    hue = np.cos(3 * height) ** 2
    # Each channel is a trapezoid of the hue, a third of a turn apart.
    offset = np.array([0.0, 2 / 3, 1 / 3])
    distance = np.abs((hue[:, None] + offset + 0.5) % 1 - 0.5)
    return np.clip(2 - 6 * distance, 0, 1)


def waves(mesh: TriangleMesh) -> Floats:
    """Return a pattern of smooth cells, (n,), between 0 and 1: the mean of three cosines along the coordinate axes.

    They are in phase at the center of the bounding box. The wavelength is an eighth of its diagonal, and at least 6 h.
    Unlike `hue_stripes`, the pattern is visible on a mesh of any shape and scale.
    """
    used = mesh.vertices[np.unique(mesh.faces)]
    low, high = used.min(axis=0), used.max(axis=0)
    wavelength = max(float(np.linalg.norm(high - low)) / 8, 6 * mesh.mean_edge_length)
    phase = 2 * np.pi / wavelength * (mesh.vertices - (low + high) / 2)
    return np.asarray(0.5 + np.cos(phase).sum(axis=1) / 6)


def _normalized_height(mesh: TriangleMesh, axis: ArrayLike) -> Floats:
    """Coordinate of each vertex along an axis, (n,), from -1 to 1 over the mesh; zero if the mesh has no extent."""
    height = mesh.vertices @ unit(np.asarray(axis, dtype=float))
    used = height[np.unique(mesh.faces)]
    half = np.ptp(used) / 2
    return np.asarray((height - used.min()) / half - 1 if half > 0 else np.zeros_like(height))


def blob(mesh: TriangleMesh, vertex: int) -> Floats:
    """Return a `bump` about a vertex, (n,); ArgumentError if the vertex does not exist."""
    if not 0 <= vertex < mesh.n_vertices:
        raise ArgumentError(
            f"vertex {vertex} does not exist: the mesh has {mesh.n_vertices} (0 to {mesh.n_vertices - 1})"
        )
    return bump(mesh, mesh.vertices[vertex])


def bump(mesh: TriangleMesh, center: Floats) -> Floats:
    """Return a Gaussian of distance in space, (n,), 1 at the center, (3,).

    Its standard deviation is a twelfth of the mesh's bounding box diagonal, and at least 3 h.
    """
    width = max(np.linalg.norm(np.ptp(mesh.vertices, axis=0)) / 12, 3 * mesh.mean_edge_length)
    distance = np.linalg.norm(mesh.vertices - center, axis=1)
    return np.asarray(np.exp(-0.5 * (distance / width) ** 2))


def random_field(mesh: TriangleMesh, seed: int, waves: int = 8) -> Floats:
    """Return a smooth random flow n x ∇ψ, ψ the sum of 64 random plane waves; its largest speed is 10 h.

    Parameters
    ----------
    seed : of the random numbers. The flow depends neither on the scale of the mesh nor on the vertex order.
    waves : largest wavenumber, in radians per half of the mesh's diameter.

    Returns
    -------
    (m, 3) array.

    Raises
    ------
    ArgumentError
        If ``waves`` is not between 1 and `MAX_WAVES`.
    """
    if not 1 <= waves <= MAX_WAVES:
        raise ArgumentError(f"a random flow has 1 to {MAX_WAVES} waves, not {waves}")
    rng = np.random.default_rng(seed)
    used = mesh.vertices[np.unique(mesh.faces)]
    low, high = used.min(axis=0), used.max(axis=0)
    radius = np.linalg.norm(high - low) / np.sqrt(12)  # of a sphere with this bounding box
    direction = unit(rng.normal(size=(64, 3)))
    k = waves * rng.random((64, 1)) ** (1 / 3) * direction
    phase, amplitude = rng.uniform(0, 2 * np.pi, 64), rng.normal(size=64)
    x = (mesh.vertices - (low + high) / 2) / radius
    V = quarter_turn(mesh, gradient_of(mesh, np.cos(x @ k.T + phase) @ amplitude))
    return np.asarray(10 * mesh.mean_edge_length / np.linalg.norm(V, axis=1).max() * V)
