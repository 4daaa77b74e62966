"""Distances by unfolding: each from the triangles that the shortest path may come through.

Round each vertex the front of equal distance is close to a circle. Its radius at the ends of an edge, with their
distances, places its center, laid out in the plane of the triangle beyond, and so tells the distance of the third
corner; where the path would miss the edge it runs along a side. For a center at the source itself this is the method of
Novotni and Klein, of first order in h. Here the radius is carried along by the equation of Jacobi fields, R' = 1 + κR²
for the Gaussian curvature κ, which makes it of second order, and right for fronts that are straight, or converge.

Novotni, Klein: Computing Geodesic Distances on Triangular Meshes. WSCG 2002.
do Carmo: Riemannian Geometry, ch. 5. Birkhäuser, 1992.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Floats, Ints
from geomhw.errors import ConvergenceError
from geomhw.mesh import geometry
from geomhw.mesh.polyhedral import PolyhedralSurface

#: Width of the bands of vertices that are worked on together, in mean edge lengths.
BAND = 1.5
#: Distances that change by no more than this share are settled.
GAIN = 1e-12
#: After so many rounds a vertex takes only what is shorter, for two offers may take turns for ever. And the last round.
PATIENCE = 30
MAX_ROUNDS = 10_000
#: A front of a larger radius than so many edges is taken as straight: rounding would blur its center.
STRAIGHT = 1e6
#: A front that converges within so many edges is no circle any more, and is taken as straight too.
FOCUS = 3.0
#: A vertex of a larger angle defect is a corner rather than part of a smooth surface: it bends fronts less and less.
SHARP = 0.15


@dataclass(frozen=True)
class _Front:
    """Distances, (k,), and radii of the fronts that bring them: 0 at a source, inf if straight, below 0 if hollow."""

    distance: Floats
    radius: Floats

    def __getitem__(self, which: Ints | NDArray[np.bool_]) -> "_Front":
        return _Front(self.distance[which], self.radius[which])

    def where(self, mask: NDArray[np.bool_], other: "_Front") -> "_Front":
        """This one where the mask holds, else the other."""
        return _Front(np.where(mask, self.distance, other.distance), np.where(mask, self.radius, other.radius))


class Unfolding:
    """Unfolds distances on one surface; its triangles are laid out once.

    defects: (n,), the integrated Gaussian curvature of the vertices, as in `angle_defects`.

    On a flat surface distances from a vertex, or from a straight line of vertices, come out exact, whatever the shape
    of the triangles; on a curved one the error is of the order of h², away from where paths of several directions meet.
    """

    def __init__(self, surface: PolyhedralSurface, defects: Floats) -> None:
        lengths = surface.edge_lengths[surface.edge_table.of_faces]
        self._h = surface.mean_edge_length
        # One line a corner i, with the opposite edge from j to k on the x axis and i above it.
        self._i, self._j, self._k = (np.roll(surface.faces, -shift, axis=1).ravel() for shift in range(3))
        self._jk, self._ik, self._ij = (np.roll(lengths, -shift, axis=1).ravel() for shift in range(3))
        with np.errstate(invalid="ignore", divide="ignore"):  # an edge without length is crossed by no path
            self._x, self._y = geometry.apex(self._jk, self._ij, self._ik)
        areas = surface.vertex_areas
        bends = defects / (1 + (defects / SHARP) ** 2)
        self._curvature = np.divide(bends, areas, out=np.zeros_like(areas), where=areas > 0)

    def __call__(self, start: Floats, guess: Floats) -> Floats:
        """Distance, (n,), from what ``start`` says, (n,), inf where it says nothing; never longer than that.

        guess: distances, (n,), inf where no path leads, that tell in which order vertices are met; the result hardly
        depends on it. What starts above 0 is taken to be that far from one point, round which fronts go on; an edge
        between two vertices that start at 0 is a source as a whole. ConvergenceError if distances do not settle.
        """
        known = np.isfinite(start)
        radius = np.array(start, dtype=float)
        ends = (start[self._j] == 0) & (start[self._k] == 0)
        radius[np.concatenate([self._j[ends], self._k[ends]])] = np.inf
        front = _Front(np.array(start, dtype=float), radius)
        open_corners = np.flatnonzero((np.isfinite(guess) & ~known)[self._i])
        band = (guess[self._i[open_corners]] / (BAND * self._h)).astype(np.int64)
        order = np.lexsort((self._i[open_corners], band))
        corners, band = open_corners[order], band[order]
        starts = np.searchsorted(band, np.arange(band.max(initial=-1) + 2))
        for k in range(len(starts) - 1):
            before = starts[max(k - 1, 0)]
            self._settle(front, corners[before : starts[k + 1]], starts[k] - before)
        self._settle(front, corners, 0)
        return front.distance

    def _settle(self, front: _Front, corners: Ints, new: int) -> None:
        """Give the vertices at these corners the shortest of their offers, in place, until that changes nothing.

        Corners of one vertex are next to each other. new: those from there on have not been looked at yet; the others
        are when something changes beside them.
        """
        i, j, k = self._i[corners], self._j[corners], self._k[corners]
        due = np.arange(new, len(corners))
        for count in range(MAX_ROUNDS):
            if not len(due):
                return
            vertex = i[due]
            first = np.flatnonzero(np.diff(vertex, prepend=-1))
            offer, old = self._offers(front, corners[due]), front.distance[vertex]
            length = np.where(offer.distance < old, offer.distance, np.inf) if count >= PATIENCE else offer.distance
            shortest = np.repeat(np.minimum.reduceat(length, first), np.diff(first, append=len(due)))
            taken = (length == shortest) & np.isfinite(shortest)
            front.distance[vertex[taken]], front.radius[vertex[taken]] = offer.distance[taken], offer.radius[taken]
            moved = taken & (shortest != old)
            moved[moved] = ~(np.abs(shortest[moved] - old[moved]) <= GAIN * shortest[moved])
            # Whose neighbors have changed asks all of its corners again.
            changed, asks = np.zeros((2, len(front.distance)), dtype=bool)
            changed[vertex[moved]] = True
            asks[i[changed[j] | changed[k]]] = True
            due = np.flatnonzero(asks[i])
        raise ConvergenceError("unfolding of distances does not converge; compute with refine=False", "refine=False")

    def _offers(self, front: _Front, c: Ints) -> _Front:
        """What j and k have to offer to vertex i of these corners."""
        i, j, k, base, x, y = (of[c] for of in (self._i, self._j, self._k, self._jk, self._x, self._y))
        at_j, at_k, bend = front[j], front[k], self._curvature
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            from_j = _bent(_moved(at_j, self._ij[c]), self._ij[c], (bend[i] + bend[j]) / 2)
            from_k = _bent(_moved(at_k, self._ik[c]), self._ik[c], (bend[i] + bend[k]) / 2)
            along = from_j.where(from_j.distance <= from_k.distance, from_k)
            across, foot = _across(at_j, at_k, base, x, y)
            share = foot / base
            between = (1 - share) * bend[j] + share * bend[k]
            across = _bent(across, np.hypot(x - foot, y), (bend[i] + between) / 2)
            inside = (share >= 0) & (share <= 1) & (across.distance < along.distance)
        return across.where(inside, along)


def _across(at_j: _Front, at_k: _Front, base: Floats, x: Floats, y: Floats) -> tuple[_Front, Floats]:
    """The front at (x, y) that has come over the edge from (0, 0) to (base, 0), and where on the edge it did; NaN where
    no front has such distances at both ends."""
    # Ends that agree on the center keep it; else the curvature is the mean of both. A source is its own center.
    apart = (at_j.distance - at_k.distance) / 2
    middle = (at_j.distance + at_k.distance) / 2
    agreed = (at_j.radius + at_k.radius) / 2
    mean_curved = 2 / (1 / at_j.radius + 1 / at_k.radius)
    same = np.abs(at_j.radius - at_k.radius) <= base
    radius = np.where(same, agreed, mean_curved)
    radius = np.where(at_j.radius == 0, -apart, np.where(at_k.radius == 0, apart, radius))
    offset, r_j, r_k = middle - radius, radius + apart, radius - apart
    hollow = radius < 0
    wide, focused = ~(np.abs(radius) <= STRAIGHT * base), hollow & (radius > -FOCUS * base)
    # The center, at (s, -depth), or ahead at (s, depth) where the front is hollow.
    s = base / 2 + (r_j - r_k) * (r_j + r_k) / (2 * base)
    depth = np.sqrt((r_j - s) * (r_j + s)) * np.where(hollow, -1.0, 1.0)
    reach = np.hypot(x - s, y + depth) * np.where(hollow, -1.0, 1.0)
    ahead = hollow & (y + depth >= 0)  # beyond its own focus no front is left
    round_front = _Front(np.where(ahead, np.nan, offset + reach), reach)
    # A straight front climbs along the edge by so much a length.
    climb = (at_k.distance - at_j.distance) / base
    steep = np.sqrt((1 - climb) * (1 + climb))
    flat_front = _Front(at_j.distance + x * climb + y * steep, np.where(focused, -FOCUS * base, np.inf))
    foot = np.where(wide | focused, x - y * climb / steep, s + (x - s) * depth / (y + depth))
    return flat_front.where(wide | focused, round_front), foot


def _moved(front: _Front, length: Floats) -> _Front:
    """The front after that length of flat surface."""
    return _Front(front.distance + length, front.radius + length)


def _bent(front: _Front, length: Floats, curvature: Floats) -> _Front:
    """The front at the end of that length with the curvature of the way made up for, in first order.

    A Jacobi field J, R = J/J', that grows in proportion to the radius on flat ground loses ∫κJ² of J'J by then.
    """
    before = np.where(np.isfinite(front.radius), 1 - length / front.radius, 1.0)
    weight = (1 + before + before**2) / 3  # mean of J² over the way, to that at its end
    return _Front(front.distance, 1 / (1 / front.radius - curvature * length * weight))
