"""The default diffusion time: h², or √h where that is near h² and more accurate.

√h has no unit: on a mesh in other units it is another multiple of h². On a given mesh the error of the heat method
changes by up to a factor of 2.5 in either direction between h²/4 and h² (17 meshes against exact distances). So the two
are compared on the mesh itself, against exact distances.
"""

import math

import numpy as np

from geomhw.arrays import Floats
from geomhw.geodesic.diffusion_time import TimeStep
from geomhw.mesh.polyhedral import PolyhedralSurface
from geomhw.mesh.triangle_mesh import TriangleMesh

#: √h is considered between these multiples of h²,
LEAST, MOST = 0.25, 1.0
#: and chosen if its mean error is below this share of that of h²: from other sources it may gain less.
MARGIN = 0.8


def auto_time(surface: PolyhedralSurface) -> TimeStep:
    """Return h², or √h if that is from 0.25 to 1 h², no cotan weight is negative, and distances come out more accurate.

    The choice does not depend on the sources: it is made for the vertex of largest area and the one farthest from it.
    """
    h = surface.mean_edge_length
    ratio = math.sqrt(h) / h**2
    if not (LEAST <= ratio <= MOST and isinstance(surface, TriangleMesh)):
        return TimeStep(h**2, "auto", "h²")
    rounding = 1e-12 * np.abs(surface.edge_cotan_weights).max()
    if surface.edge_cotan_weights.min() < -rounding:
        return TimeStep(h**2, "auto", "h², since cotan weights are negative")
    if _is_more_accurate(surface, math.sqrt(h), h**2):
        return TimeStep(math.sqrt(h), "auto", f"√h, which is {ratio:.3g} h² and more accurate here")
    return TimeStep(h**2, "auto", "h²")


def _is_more_accurate(mesh: TriangleMesh, time: float, other: float) -> bool:
    """Whether mean relative errors against exact distances are below `MARGIN` times those of another time."""
    from geomhw.geodesic.exact import ExactDistance
    from geomhw.geodesic.heat_method import HeatDistance

    def plain(t: float) -> Floats:
        return np.asarray(methods[t].from_vertices([source])["distance"])

    front = ExactDistance(mesh)
    methods = {t: HeatDistance(mesh, t, refine=False) for t in (time, other)}
    source = int(mesh.vertex_areas.argmax())
    for _ in range(2):
        exact = np.asarray(front.from_vertices([source])["distance"])
        known = np.isfinite(exact) & (exact > 0)
        errors = [np.abs(plain(t)[known] / exact[known] - 1).mean() for t in (time, other)]
        if not errors[0] < MARGIN * errors[1]:
            return False
        source = int(np.where(known, exact, 0.0).argmax())
    return True
