"""Local extrema of a function on vertices, separated by geodesic distance."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Floats, Ints
from geomhw.errors import ArgumentError
from geomhw.geodesic.exact import ExactDistance
from geomhw.mesh.topology import vertex_components
from geomhw.mesh.triangle_mesh import TriangleMesh


@dataclass(frozen=True)
class Extrema:
    """Vertices of the local maxima, from the largest value down, and of the minima, from the smallest up."""

    maxima: Ints
    minima: Ints


def local_extrema(
    mesh: TriangleMesh, values: Floats, distance: float = 0.0, allowed: NDArray[np.bool_] | None = None
) -> Extrema:
    """Find the vertices that are more extreme than all others within a geodesic distance.

    Parameters
    ----------
    mesh
        The surface.
    values
        (n,) array.
    distance
        Exact geodesic distance, units length, within which no vertex may be more extreme. The neighbors along edges
        count in any case.
    allowed
        (n,) mask of the vertices that may be extrema, by default all.

    Returns
    -------
    Extrema
        Connected vertices of one value are one extremum, at the lowest index. Of equal extrema within the distance, the
        one of lowest index is kept.

    Raises
    ------
    ArgumentError
        If the distance is negative or not a number.
    MeshError
        If a face has zero area, for a positive distance.

    Examples
    --------
    >>> from geomhw.mesh import icosphere
    >>> ball = icosphere(2)
    >>> found = local_extrema(ball, ball.vertices[:, 2])
    >>> ball.vertices[found.maxima, 2].round(2), ball.vertices[found.minima, 2].round(2)
    (array([1.]), array([-1.]))
    """
    if not distance >= 0:
        raise ArgumentError(f"the distance between extrema is a length, 0 or more, not {distance:g}")
    values = np.asarray(values, dtype=float)
    allowed = np.ones(mesh.n_vertices, dtype=bool) if allowed is None else allowed
    plateaus = vertex_components(mesh.edges[values[mesh.edges[:, 0]] == values[mesh.edges[:, 1]]], mesh.n_vertices)
    return Extrema(*(_maxima(mesh, sign * values, plateaus, distance, allowed) for sign in (1, -1)))


def _maxima(mesh: TriangleMesh, values: Floats, plateaus: Ints, distance: float, allowed: NDArray[np.bool_]) -> Ints:
    """Maxima from the largest down."""
    one, other = mesh.edges.T
    size = int(plateaus.max(initial=-1)) + 1
    has_higher, has_lower = np.zeros(size, dtype=bool), np.zeros(size, dtype=bool)
    rises = values[other] - values[one]
    has_higher[plateaus[one[rises > 0]]] = has_higher[plateaus[other[rises < 0]]] = True
    has_lower[plateaus[one[rises < 0]]] = has_lower[plateaus[other[rises > 0]]] = True
    _, lowest = np.unique(plateaus, return_index=True)
    found = lowest[(has_lower & ~has_higher) & allowed[lowest]]
    found = found[np.lexsort((found, -values[found]))]
    if not distance:
        return found
    exact = ExactDistance(mesh)
    kept, near_higher = np.zeros(mesh.n_vertices, dtype=bool), np.zeros(mesh.n_vertices, dtype=bool)
    for vertex in found.tolist():
        if near_higher[vertex]:
            continue
        near = np.isfinite(exact.from_vertices([vertex], limit=distance)["distance"])
        kept[vertex] = not (values[near] > values[vertex]).any()
        near_higher |= near  # all that follow are lower, or equal and of a higher index
    return found[kept[found]]
