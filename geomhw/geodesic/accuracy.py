"""How accurate distances are: their relative errors against exact ones, at vertices near the sources."""

from math import inf
from typing import Any

import numpy as np

from geomhw.arrays import Floats
from geomhw.geodesic.exact import ExactDistance
from geomhw.mesh.surface_points import SurfacePoints
from geomhw.mesh.triangle_mesh import TriangleMesh

#: Vertices compared at most. An exact front takes about 0.4 s for as many on a scan.
MOST_VERTICES = 50_000
#: Exact distances are computed up to this multiple of the largest distance.
BEYOND = 1.5


def distance_errors(mesh: TriangleMesh, sources: SurfacePoints, distance: Floats) -> dict[str, Any]:
    """Compare distances with exact polyhedral distances, at up to 50,000 vertices nearest to the sources.

    Parameters
    ----------
    mesh : the mesh.
    sources : the sources of the distances.
    distance : (n,) array, inf where unreachable; vertices of distance zero are left out.

    Returns
    -------
    dict with ``mean`` and ``largest`` relative error, the ``vertex`` of the largest, and the number of ``vertices``
    compared; empty if there are none. ``within`` is the distance up to which vertices are compared, if not all are.

    Examples
    --------
    >>> from geomhw.geodesic import HeatDistance
    >>> from geomhw.mesh import icosphere, vertex_points
    >>> mesh = icosphere(3)
    >>> errors = distance_errors(mesh, vertex_points(mesh, [7]), HeatDistance(mesh).from_vertices([7])["distance"])
    >>> errors["vertices"], 0.01 < errors["mean"] < 0.03
    (641, True)
    """
    known, limit = np.isfinite(distance), inf
    if np.count_nonzero(known) > MOST_VERTICES:
        limit = float(np.partition(distance[known], MOST_VERTICES)[MOST_VERTICES])
    # Distances up to a limit, or to some targets, need no exact ones far beyond.
    far = inf if known.all() else BEYOND * float(distance[known].max(initial=0.0))
    exact = np.asarray(ExactDistance(mesh).from_sources(sources, min(limit, far))["distance"])
    compared = np.flatnonzero(known & np.isfinite(exact) & (exact > 0))
    if not len(compared):
        return {}
    errors = np.abs(distance[compared] / exact[compared] - 1)
    return {
        "mean": float(errors.mean()),
        "largest": float(errors.max()),
        "vertex": int(compared[errors.argmax()]),
        "vertices": len(compared),
        **({"within": limit} if limit < inf else {}),
    }
