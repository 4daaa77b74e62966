"""Given directions at points, along curves and along the boundary, as values of u at vertices."""

from collections.abc import Sequence

import numpy as np

from geomhw.arrays import Complexes, Floats, Ints
from geomhw.directions.power_fields import unit_power
from geomhw.errors import ArgumentError
from geomhw.mesh.surface_points import SurfacePoints
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.deformation_energy import boundary_directions
from geomhw.operators.edge_directions import edge_ends

#: Length of a sum of unit numbers below which they cancel, over their number.
CANCELS = 1e-6


def directions_at(mesh: TriangleMesh, points: SurfacePoints, vectors: Floats, n: int) -> Complexes:
    """Return u, (n_vertices,), with the directions of the vectors, (k, 3), at the corners of the points; 0 elsewhere.

    Several vectors at a vertex are averaged, by weights.

    Raises
    ------
    ArgumentError
        If a vector has no tangential part.
    """
    u = np.zeros(mesh.n_vertices, dtype=complex)
    largest = np.abs(vectors).max(axis=1, initial=0.0, keepdims=True)
    scaled = vectors / np.where(largest > 0, largest, 1.0)
    parts = np.einsum("kcax,kx->kca", mesh.tangent_frames[points.corners], scaled)
    z, used = parts[..., 0] + 1j * parts[..., 1], points.weights > 0
    lost = used & (np.abs(z) <= CANCELS)
    if lost.any():
        raise ArgumentError(f"the vector at vertex {points.corners[lost][0]} is zero or normal to the surface there")
    np.add.at(u, points.corners[used], points.weights[used] * unit_power(z[used]) ** n)
    return u


def directions_along(mesh: TriangleMesh, curves: Sequence[SurfacePoints], n: int) -> Complexes:
    """Return u, (n_vertices,), along curves given by points: at the corners of both ends of each segment."""
    u = np.zeros(mesh.n_vertices, dtype=complex)
    for curve in curves:
        places = curve.positions(mesh)
        along = places[1:] - places[:-1]
        moves = np.flatnonzero(np.linalg.norm(along, axis=1) > 0)
        for end in (moves, moves + 1):
            u += directions_at(mesh, curve[end], along[moves], n)
    return u


def directions_along_boundary(mesh: TriangleMesh, n: int) -> Complexes:
    """Return u, (n_vertices,), along the boundary, in the direction of its faces; 0 elsewhere, and at corners between.

    At a vertex it is the mean of both edges, which may cancel: lines at a right angle.
    """
    ahead, behind = boundary_directions(mesh, edge_ends(mesh, "intrinsic"))
    rim = (ahead != 0) & (behind != 0)
    return np.where(rim, unit_power(ahead) ** n + unit_power(-behind) ** n, 0.0)


def combined(parts: Sequence[Complexes]) -> tuple[Ints, Complexes]:
    """Return the vertices with a direction, (k,), and u there, of length 1, of the sum of some parts."""
    total = np.sum(parts, axis=0)
    vertices = np.flatnonzero(np.abs(total) > CANCELS)
    return vertices, unit_power(total[vertices])
