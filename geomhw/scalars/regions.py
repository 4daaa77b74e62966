"""Regions of interest: geodesic disks round vertices, flat or with Gaussian weights, overlapping or not."""

from collections.abc import Sequence
from typing import get_args

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Floats, Ints
from geomhw.errors import ArgumentError, FieldError
from geomhw.geodesic.exact import ExactDistance
from geomhw.mesh.named_points import region_points
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.options import OverlapName


def geodesic_disks(
    mesh: TriangleMesh,
    vertices: Sequence[int] | Ints,
    radius: float,
    sigma: float | None = None,
    overlap: OverlapName = "allow",
) -> Floats:
    """Compute a function per vertex that is positive within a geodesic distance of it, and zero elsewhere.

    Parameters
    ----------
    mesh
        The surface.
    vertices
        Centers of the k disks.
    radius
        Exact geodesic distance, units length.
    sigma
        Standard deviation of Gaussian weights exp(-d²/2σ²), units length, that sum to 1 over each disk; by default the
        function is 1 on the disk.
    overlap
        ``allow``: disks may overlap. ``closest``: a vertex is in the disk of the nearest center only, of the first one
        on a tie. ``exclude``: a vertex within the radius of several centers is in none of the disks.

    Returns
    -------
    (n, k) array

    Raises
    ------
    ArgumentError
        If the radius is negative, sigma is not positive, or the overlap is unknown.
    FieldError
        If a center is not a vertex of the surface.

    Examples
    --------
    >>> from geomhw.mesh import grid
    >>> disks = geodesic_disks(grid(10, 10), [0, 12], 0.25, overlap="closest")
    >>> disks.sum(axis=0).tolist(), float(disks.sum(axis=1).max())
    ([3.0, 12.0], 1.0)
    """
    if overlap not in get_args(OverlapName):
        raise ArgumentError(f"there is no way '{overlap}' to overlap; choose from {', '.join(get_args(OverlapName))}")
    if sigma is not None and not 0 < sigma < np.inf:
        raise ArgumentError(f"the standard deviation of the weights must be a positive number, not {sigma:g}")
    exact = ExactDistance(mesh)
    distances = np.stack([exact.from_vertices([v], limit=radius)["distance"] for v in np.asarray(vertices)], axis=1)
    inside = np.isfinite(distances)
    if overlap == "exclude":
        inside &= inside.sum(axis=1, keepdims=True) == 1
    elif overlap == "closest":
        inside &= np.arange(distances.shape[1]) == distances.argmin(axis=1)[:, None]
    if sigma is None:
        return inside.astype(float)
    weights = np.where(inside, np.exp(-0.5 * (np.where(inside, distances, 0) / sigma) ** 2), 0.0)
    total = weights.sum(axis=0)
    return np.asarray(np.divide(weights, total, out=np.zeros_like(weights), where=total > 0))


def signed_distance(mesh: TriangleMesh, inside: NDArray[np.bool_]) -> Floats:
    """Compute the exact geodesic distance to a region, negative within it.

    Parameters
    ----------
    mesh
        The surface.
    inside
        (n,) mask of the vertices of the region. Faces with all corners in it, or all outside, are filled.

    Returns
    -------
    (n,) array, units length: outside, the distance to the region; inside, minus the distance to what is outside. It
    changes its sign in the middle of the faces between the two.

    Raises
    ------
    FieldError
        If no vertex of the surface is inside, or none is outside.

    Examples
    --------
    >>> from geomhw.mesh import strip
    >>> mesh = strip(4)
    >>> signed_distance(mesh, mesh.vertices[:, 0] < 1.5)[mesh.vertices[:, 1] == 0].round(2).tolist()
    [-2.0, -1.0, 1.0, 2.0, 3.0]
    """
    used = np.ones(mesh.n_vertices, dtype=bool)
    used[mesh.unreferenced_vertices] = False
    exact, distances = ExactDistance(mesh), []
    for part, where in ((inside & used, "inside"), (~inside & used, "outside")):
        if not part.any():
            raise FieldError(f"no vertex of the surface is {where} of the region")
        distances.append(np.asarray(exact.from_sources(region_points(mesh, np.flatnonzero(part)))["distance"]))
    with np.errstate(invalid="ignore"):
        return np.where(used, distances[0] - distances[1], np.inf)
