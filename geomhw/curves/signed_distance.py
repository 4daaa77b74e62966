"""Signed distance to curves: the signed heat method, and exact distances with the sign of each side.

Curves divide the surface into pieces. Where a piece is on the same side of all curves at its border, its sign is known,
and distances in it are exact. Elsewhere the signed heat method gives a generalized distance.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.curves.signed_heat import SignedHeat
from geomhw.errors import FieldError
from geomhw.geodesic.diffusion_time import given_time
from geomhw.geodesic.exact import ExactDistance
from geomhw.mesh.inserted_curves import InsertedSources, insert_sources
from geomhw.mesh.surface_points import SurfacePoints
from geomhw.mesh.topology import linked_components
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.results import Field, Result


def signed_distance(
    mesh: TriangleMesh, curves: SurfacePoints, correct: bool = True, time: str | float = "auto"
) -> Result:
    """Return the distance from curves, positive on their left, negative on their right, seen from outside.

    Parameters
    ----------
    mesh : an oriented manifold mesh.
    curves : points with segments, which are directed.
    correct : whether to replace the generalized distance of the signed heat method by exact distances in pieces whose
        side is known. In pieces on both sides of a curve without ends or crossings, such as one meridian of a torus, no
        sign is known, and distances are unsigned.
    time : diffusion time of the signed heat method, as in `SignedHeat`.

    Returns
    -------
    Result with ``signed_distance`` per vertex; inf on components without a curve. The report has the numbers of
    vertices with ``exact``, ``generalized`` and ``unsigned`` distances.

    Raises
    ------
    FieldError
        If there is no segment.
    MeshError
        If the mesh is no oriented manifold, or a face has zero area.
    ArgumentError
        If the time is none, as for `time_step`.

    Examples
    --------
    >>> from geomhw.curves import isolines, signed_distance
    >>> from geomhw.mesh import curve_points, icosphere
    >>> ball = icosphere(4)
    >>> (equator,) = isolines(ball, ball.vertices[:, 2], [0.001]).curves
    >>> d = signed_distance(ball, curve_points(ball, *equator))["signed_distance"]
    >>> round(float(d.min()), 2), round(float(d.max()), 2)
    (-1.57, 1.57)
    """
    curves = curves.unique()
    if not len(curves.segments):
        raise FieldError("a signed distance needs a curve, not points")
    mesh.require_oriented("signed distance")
    if str(time).strip() != "auto":
        given_time(time, mesh.mean_edge_length)  # a wrong time is an error also where it is not used
    found = _Sides.of(mesh, curves) if correct else None
    heat = None
    if found is None or found.needs_heat:
        method = SignedHeat(mesh, time)
        heat = method(curves)
    distance = found.distance(heat) if found else heat
    assert distance is not None
    report: dict[str, Any] = {"sources": curves.report(), "method": "exact fronts" if found else "heat"}
    if heat is not None:
        report["time"] = method.time.report(mesh.mean_edge_length)
    known = np.isfinite(distance)
    counts = found.counts() if found else {"exact": 0, "generalized": int(known.sum()), "unsigned": 0}
    extremes = {name: end(distance[known]) for name, end in (("least", np.min), ("largest", np.max))}
    report |= {name: float(value) for name, value in extremes.items()}
    unreached = int((~known).sum()) - len(mesh.unreferenced_vertices)
    report |= {"vertices": counts, "unreachable_vertices": unreached}
    return Result(mesh, [Field("signed_distance", "vertex", distance)], report, curves)


@dataclass(frozen=True, eq=False)
class _Sides:
    """The piece of each vertex, the sign of each piece, and unsigned distances.

    piece: (n,). sign: (p,), 0 where both signs occur. generalized: (p,), whether a piece without a sign borders a curve
    with ends or crossings. unsigned: (n,), exact.
    """

    piece: Ints
    sign: Ints
    generalized: Ints
    unsigned: Floats

    @classmethod
    def of(cls, mesh: TriangleMesh, curves: SurfacePoints) -> "_Sides":
        """Divide the mesh along the curves, and compute distances from them."""
        found = insert_sources(mesh, curves)
        divided, n = found.mesh, mesh.n_vertices
        segments = np.arange(len(found.chains))
        sides = found.sides(segments)
        edge, left = _directed(found)
        table = divided.edge_table.of_faces
        on_curve = np.zeros(divided.n_edges, dtype=bool)
        on_curve[edge] = True
        face, side = np.nonzero(~on_curve[table])
        pieces = linked_components(face, divided.n_faces + table[face, side], divided.n_faces + divided.n_edges)
        pieces = np.unique(pieces[: divided.n_faces], return_inverse=True)[1].ravel()
        # The sign at each side of a face that is on a curve: of its edge, times that of the direction of the side.
        f, k = np.divmod(sides, 3)
        upward = divided.faces[f, (k + 1) % 3] < divided.faces[f, (k + 2) % 3]
        count = int(pieces.max()) + 1
        both = np.zeros((count, 2), dtype=bool)
        for sign in (0, 1):  # whether the curve runs along the edge upward or downward
            there = left[sign][table[f, k]]
            both[pieces[f[there]], np.where(upward[there] == (sign == 0), 1, 0)] = True
        piece_sign = both[:, 1].astype(int) - both[:, 0]
        loose = _loose_edges(divided, np.flatnonzero(on_curve))
        generalized = np.zeros(count, dtype=bool)
        generalized[pieces[f[loose[table[f, k]]]]] = True
        generalized &= piece_sign == 0
        piece = np.zeros(divided.n_vertices, dtype=np.int64)
        piece[divided.faces[::-1]] = pieces[::-1, None]
        distance = ExactDistance(divided).from_lines(found.sources.vertices, sides)
        return cls(piece[:n], piece_sign, generalized, distance[:n])

    @property
    def needs_heat(self) -> bool:
        """Whether a vertex has a generalized distance."""
        return bool(self.generalized[self.piece].any())

    def distance(self, heat: Floats | None) -> Floats:
        """Return the signed distances. heat: the generalized ones, where needed."""
        sign = self.sign[self.piece]
        found = np.where(sign == 0, 1, sign) * self.unsigned
        found[np.isinf(self.unsigned)] = np.inf
        if heat is not None:
            general = self.generalized[self.piece] & (self.unsigned > 0) & np.isfinite(self.unsigned)
            found[general] = heat[general]
        return np.asarray(found + 0.0)

    def counts(self) -> dict[str, int]:
        """Return how many vertices have which kind of distance."""
        known = np.isfinite(self.unsigned)
        general = self.generalized[self.piece] & known
        unsigned = (self.sign[self.piece] == 0) & ~general & known & (self.unsigned > 0)
        return {
            "exact": int((known & ~general & ~unsigned).sum()),
            "generalized": int(general.sum()),
            "unsigned": int(unsigned.sum()),
        }


def _directed(found: InsertedSources) -> tuple[Ints, tuple[Ints, Ints]]:
    """Return the edges of curves, and masks of the edges along which a curve runs upward, and downward."""
    mesh = found.mesh
    start = np.concatenate([chain[:-1] for chain in found.chains])
    end = np.concatenate([chain[1:] for chain in found.chains])
    edge = mesh.edge_table.between(np.stack([start, end], axis=1))
    upward, downward = (np.zeros(mesh.n_edges, dtype=bool) for _ in range(2))
    upward[edge[start < end]] = True
    downward[edge[start > end]] = True
    return np.unique(edge), (upward, downward)


def _loose_edges(mesh: TriangleMesh, edges: Ints) -> Ints:
    """Return a mask of the edges of curves with an end inside the surface, or a crossing."""
    ends = mesh.edges[edges]
    degree = np.bincount(ends.ravel(), minlength=mesh.n_vertices)
    odd = (degree > 0) & (degree != 2)
    odd[np.intersect1d(np.flatnonzero(degree == 1), mesh.boundary_vertices)] = False
    part = linked_components(ends[:, 0], ends[:, 1], mesh.n_vertices)
    loose = np.zeros(mesh.n_edges, dtype=bool)
    loose[edges] = np.isin(part[ends[:, 0]], part[odd])
    return loose
