"""The default diffusion time: h², or √h where that is near h² and more accurate.

√h has no unit: on a mesh in other units it is another multiple of h². On a given mesh the error of the heat method
changes by up to a factor of 2.5 in either direction between h²/4 and h² (17 meshes against exact distances). So the two
are compared on the mesh itself, against exact distances.
"""

import math

import numpy as np

from geomhw.arrays import Floats
from geomhw.geodesic.diffusion_time import TimeStep, given_time
from geomhw.geodesic.edge_paths import edge_path_distance
from geomhw.geodesic.heat_step import HeatStep
from geomhw.geodesic.poisson import DistancePoisson
from geomhw.geodesic.source_conditions import known_distances
from geomhw.geodesic.unit_field import unit_field
from geomhw.mesh.named_points import vertex_points
from geomhw.mesh.polyhedral import PolyhedralSurface
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.divergence import divergence_of

#: √h is considered between these multiples of h²,
LEAST, MOST = 0.25, 1.0
#: if no cotan weight is below zero by more than rounding,
ROUNDING = 1e-12
#: and chosen if its mean error is below this share of that of h²: from other sources it may gain less.
MARGIN = 0.8


def time_step(asked: str | float, surface: PolyhedralSurface) -> TimeStep:
    """Return the diffusion time on a surface of mean edge length h.

    Parameters
    ----------
    asked : ``h2`` (t = h², [GIH, sec. 3.2.4]), ``sqrt-h`` (t = √h, the course handout's, which depends on the unit of
        length), a multiple such as ``0.5*h2``, a positive number (length²), or ``auto``: √h if that is from 0.25 to
        1 h², no cotan weight is negative, and distances on this mesh come out more accurate; else h².

    Raises
    ------
    MeshError
        If a face has zero area.
    ArgumentError
        For anything else, and for a time that is zero, infinite or not between 1e-60 h² and 1e8 h².

    Examples
    --------
    >>> from geomhw.mesh import icosphere
    >>> mesh = icosphere(2)
    >>> round(time_step("0.5*h2", mesh).t / mesh.mean_edge_length**2, 12)
    0.5
    """
    surface.require_area("robust=True")
    if str(asked).strip() != "auto":
        return given_time(asked, surface.mean_edge_length)
    h = surface.mean_edge_length
    if not isinstance(surface, TriangleMesh):
        return TimeStep(h**2, "auto", "h²")
    weights = surface.edge_cotan_weights
    if clear := without_comparison(h, float(weights.min()), float(np.abs(weights).max())):
        return clear
    if _is_more_accurate(surface, math.sqrt(h), h**2):
        return TimeStep(math.sqrt(h), "auto", f"√h, which is {h**-1.5:.3g} h² and more accurate here")
    return TimeStep(h**2, "auto", "h²")


def without_comparison(h: float, least: float, largest: float) -> TimeStep | None:
    """Return the time of ``auto`` if it follows from the mean edge length and the cotan weights of edges, else None.

    least : the least weight; largest : the largest absolute value.
    """
    if not LEAST <= h**-1.5 <= MOST:  # √h/h²
        return TimeStep(h**2, "auto", "h²")
    if least < -ROUNDING * largest:
        return TimeStep(h**2, "auto", "h², since cotan weights are negative")
    return None


def _is_more_accurate(mesh: TriangleMesh, time: float, other: float) -> bool:
    """Whether mean relative errors against exact distances are below `MARGIN` times those of another time.

    The answer does not depend on the sources: they are the vertex of largest area and the one farthest from it.
    """
    from geomhw.geodesic.exact import ExactDistance

    front, steps = ExactDistance(mesh), [HeatStep(mesh, t) for t in (time, other)]
    methods = [(step, DistancePoisson(mesh, step)) for step in steps]
    source = int(mesh.vertex_areas.argmax())
    for _ in range(2):
        exact = np.asarray(front.from_vertices([source])["distance"])
        known = np.isfinite(exact) & (exact > 0)
        errors = [np.abs(_distance(mesh, *method, source)[known] / exact[known] - 1).mean() for method in methods]
        if not errors[0] < MARGIN * errors[1]:
            return False
        source = int(np.where(known, exact, 0.0).argmax())
    return True


def _distance(mesh: TriangleMesh, step: HeatStep, poisson: DistancePoisson, source: int) -> Floats:
    """The distance from a vertex by the heat method, (n,), clamped to edge paths."""
    sources, paths = vertex_points(mesh, [source]), edge_path_distance(mesh, np.array([source]))
    u = step.from_impulse(sources.impulse(mesh.n_vertices), paths)
    X = unit_field(mesh, u, sources.vertices)[1]
    phi = poisson(divergence_of(mesh, X), sources, known_distances(mesh, sources), u)
    return np.minimum(phi, paths)
