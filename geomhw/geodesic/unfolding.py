"""Geodesic distance by unfolding triangles, with fronts of second order.

Near a vertex the front of equal distance is an arc. Its radius R at the ends j and k of an edge, with their distances
d_j and d_k, gives its center c in the plane of a triangle (i, j, k). The third corner takes the shortest of

    (d_j + d_k)/2 - R + |x_i - c|   if the straight path from c crosses the edge,   d_j + |ij|,   d_k + |ik|,

over all its triangles, until no distance changes. With c at the source itself this is the method of Novotni and Klein,
of first order in h. Here R follows the equation of Jacobi fields, R' = 1 + K R² with the Gaussian curvature K, which
makes the method second order, also for straight and converging fronts.

Novotni, Klein: Computing Geodesic Distances on Triangular Meshes. WSCG 2002.
do Carmo: Riemannian Geometry, ch. 5. Birkhäuser, 1992.
"""

from typing import Any

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.compiled import compiled
from geomhw.errors import ConvergenceError
from geomhw.mesh import geometry
from geomhw.mesh.polyhedral import PolyhedralSurface
from geomhw.mesh.topology import counting_order

#: Width of the bands of vertices that are worked on together, in mean edge lengths.
BAND = 1.5
#: Distances that change by at most this share have converged.
TOLERANCE = 1e-12
#: After this many rounds a vertex takes shorter candidates only, since two may alternate without end.
ALTERNATING_ROUNDS = 30
MAX_ROUNDS = 10_000
#: A front with a radius of more edges than this is straight: rounding would blur its center.
STRAIGHT = 1e6
#: A front that converges within this many edges is no arc any more, and is taken as straight.
FOCUS = 3.0
#: The curvature of a vertex with a larger angle defect counts less and less: it is a corner, not a smooth surface.
SHARP = 0.15


class Unfolding:
    """Distances by unfolding on one surface.

    On a flat surface, distances from a vertex or a straight line of vertices are exact, for triangles of any shape. On
    a curved one the error is O(h²), away from points where shortest paths of several directions meet.

    Parameters
    ----------
    surface : the surface; faces of zero area do no harm.
    defects : (n,) array, the integrated Gaussian curvature of the vertices, as in `angle_defects`.

    References
    ----------
    Novotni, Klein: Computing Geodesic Distances on Triangular Meshes, WSCG 2002.

    Examples
    --------
    >>> from geomhw.mesh import angle_defects, grid
    >>> square = grid(4, 4)
    >>> known = np.where(np.arange(25) == 0, 0.0, np.inf)
    >>> Unfolding(square, angle_defects(square))(known, np.linalg.norm(square.vertices, axis=1)).max().round(6)
    np.float64(1.414214)
    """

    def __init__(self, surface: PolyhedralSurface, defects: Floats) -> None:
        lengths, n = surface.edge_lengths[surface.edge_table.of_faces], surface.n_vertices
        self._band_width = BAND * surface.mean_edge_length
        # One row per corner i, grouped by vertex, with the opposite edge from j to k on the x axis and i above it.
        i, j, k = (np.roll(surface.faces, -shift, axis=1).ravel() for shift in range(3))
        jk, ik, ij = (np.roll(lengths, -shift, axis=1).ravel() for shift in range(3))
        with np.errstate(invalid="ignore", divide="ignore"):  # no path crosses an edge of zero length
            x, y = geometry.apex(jk, ij, ik)
        order = counting_order(i)
        starts = np.append(0, np.cumsum(np.bincount(i, minlength=n)))
        areas = surface.vertex_areas
        smooth = defects / (1 + (defects / SHARP) ** 2)
        curvature = np.divide(smooth, areas, out=np.zeros_like(areas), where=areas > 0)
        self._j, self._k, *rest = (values[order] for values in (j, k, ij, ik, jk, x, y))
        self._corners = starts, self._j, self._k, *rest, curvature

    def __call__(self, known: Floats, guess: Floats) -> Floats:
        """Return the distance from the sources, (n,); inf where the guess is.

        Parameters
        ----------
        known : (n,) array of distances to keep, 0 at source vertices, inf where unknown. A vertex with a positive
            distance is that far from a point source. An edge between two vertices at 0 is a source as a whole.
        guess : (n,) array of approximate distances, inf where no path leads. It decides the order of computation; the
            result hardly depends on it.

        Raises
        ------
        ConvergenceError
            If distances do not converge.
        """
        distance, radius = np.array(known, dtype=float), np.array(known, dtype=float)
        on_source = (known[self._j] == 0) & (known[self._k] == 0)
        radius[self._j[on_source]] = radius[self._k[on_source]] = np.inf
        vertices = np.flatnonzero(np.isfinite(guess) & ~np.isfinite(known))
        band = (guess[vertices] / self._band_width).astype(np.int64)
        order = np.argsort(band, kind="stable")
        vertices, starts = vertices[order], np.searchsorted(band[order], np.arange(band.max(initial=-1) + 2))
        # Band by band, each with the one before; then all vertices.
        parts = [*zip([0, *starts], starts, starts[1:], strict=False), (0, 0, len(vertices))]
        for first, new, end in parts:
            if not _unfold(self._corners, vertices[first:end], new - first, distance, radius):
                raise ConvergenceError("unfolding does not converge; compute with refine=False", "refine=False")
        return distance


@compiled
def _unfold(corners: Any, vertices: Ints, new: int, distance: Floats, radius: Floats) -> bool:
    """Give vertices their shortest candidate, in place and in rounds, until nothing changes; whether that happens.

    The first round takes the vertices from ``new`` on, and each other one those beside a change.
    """
    starts, j, k = corners[0], corners[1], corners[2]
    allowed, listed = np.zeros(len(distance), dtype=np.bool_), np.zeros(len(distance), dtype=np.bool_)
    allowed[vertices] = True
    found = np.empty((len(vertices), 2))
    current, following = vertices.copy(), vertices.copy()
    current[: len(vertices) - new] = vertices[new:]
    count = len(vertices) - new
    for round_ in range(MAX_ROUNDS):
        if count == 0:
            return True
        for q in range(count):
            i = current[q]
            listed[i] = False
            limit = distance[i] if round_ >= ALTERNATING_ROUNDS else np.inf
            found[q, 0], found[q, 1] = _shortest_candidate(corners, i, limit, distance, radius)
        listing = 0
        for q in range(count):
            i = current[q]
            if found[q, 0] < np.inf:
                change = abs(found[q, 0] - distance[i])
                distance[i], radius[i] = found[q, 0], found[q, 1]
                if not change <= TOLERANCE * distance[i]:
                    for c in range(starts[i], starts[i + 1]):
                        for neighbor in (j[c], k[c]):
                            if allowed[neighbor] and not listed[neighbor]:
                                listed[neighbor] = True
                                following[listing] = neighbor
                                listing += 1
        current, following, count = following, current, listing
    return False


@compiled
def _shortest_candidate(corners: Any, i: int, limit: float, distance: Floats, radius: Floats) -> tuple[float, float]:
    """Distance and radius of the shortest candidate for vertex i below a limit; inf if there is none."""
    starts, j, k, ij, ik, jk, x, y, curvature = corners
    best, best_radius = np.inf, np.inf
    for c in range(starts[i], starts[i + 1]):
        d_j, d_k, r_j, r_k = distance[j[c]], distance[k[c]], radius[j[c]], radius[k[c]]
        # Along the sides.
        if d_j + ij[c] <= d_k + ik[c]:
            d, r, length, K = d_j + ij[c], r_j + ij[c], ij[c], curvature[j[c]]
        else:
            d, r, length, K = d_k + ik[c], r_k + ik[c], ik[c], curvature[k[c]]
        # Across the edge.
        across, across_radius, foot = _across(d_j, r_j, d_k, r_k, jk[c], x[c], y[c])
        share = foot / jk[c]
        if share >= 0.0 and share <= 1.0 and across < d:
            d, r, length = across, across_radius, np.hypot(x[c] - foot, y[c])
            K = (1 - share) * curvature[j[c]] + share * curvature[k[c]]
        if d < limit and d <= best:
            best, best_radius = d, _curved(r, length, (curvature[i] + K) / 2)
    return best, best_radius


@compiled
def _across(
    d_j: float, r_j: float, d_k: float, r_k: float, base: float, x: float, y: float
) -> tuple[float, float, float]:
    """Distance and radius at (x, y) of the front over the edge from (0, 0) to (base, 0), and where its path crosses it.

    r is 0 at a source, inf for a straight front, negative for a converging one. NaN if no front has these distances.
    """
    half_difference = (d_j - d_k) / 2
    if r_j == 0.0:  # a source is its own center
        R = -half_difference
    elif r_k == 0.0:
        R = half_difference
    elif abs(r_j - r_k) <= base:  # both ends agree on the center
        R = (r_j + r_k) / 2
    else:  # mean curvature of the front
        R = 2 / (1 / r_j + 1 / r_k)
    sign = -1.0 if R < 0.0 else 1.0
    focused = R < 0.0 and -FOCUS * base < R
    if focused or not abs(R) <= STRAIGHT * base:
        slope = (d_k - d_j) / base
        steepness = np.sqrt((1 - slope) * (1 + slope))
        return d_j + x * slope + y * steepness, -FOCUS * base if focused else np.inf, x - y * slope / steepness
    from_j, from_k = R + half_difference, R - half_difference
    # The center is at (s, -depth); ahead, at y = |depth|, for a converging front.
    s = base / 2 + (from_j - from_k) * (from_j + from_k) / (2 * base)
    depth = sign * np.sqrt((from_j - s) * (from_j + s))
    if R < 0.0 and y + depth >= 0.0:  # beyond its focus there is no front
        return np.nan, np.nan, np.nan
    reach = sign * np.hypot(x - s, y + depth)
    return (d_j + d_k) / 2 - R + reach, reach, s + (x - s) * depth / (y + depth)


@compiled
def _curved(radius: float, length: float, curvature: float) -> float:
    """Radius after a length of surface of that curvature, from the radius that it has on flat ground, in first order.

    A Jacobi field J with R = J/J' that grows in proportion to the radius on flat ground loses ∫KJ² of J'J.
    """
    before = 1 - length / radius if np.isfinite(radius) else 1.0
    weight = (1 + before + before**2) / 3  # mean of J² over the way, relative to that at its end
    return 1 / (1 / radius - curvature * length * weight)
