"""Geodesic Voronoi cells of sites on a surface: labels by exact distance, areas, borders and dual edges."""

from dataclasses import dataclass

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.errors import ArgumentError
from geomhw.geodesic.exact import Arrivals, ExactDistance
from geomhw.geodesic.growing_sources import GrowingSources
from geomhw.geodesic.voronoi_faces import split_faces
from geomhw.mesh.surface_points import SurfacePoints
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.results import Field, Result

#: Distances that agree up to this share are equal.
EQUAL = 1e-10


@dataclass(frozen=True, eq=False)
class VoronoiCells:
    """Geodesic Voronoi diagram of k sites.

    Attributes
    ----------
    mesh : TriangleMesh
    sites : SurfacePoints
    label : (n,) integer array
        The nearest site of each vertex, the lower one on a tie; -1 on components without a site.
    distance : (n,) array
        Exact distance from it.
    areas : (k,) array
        Area of each cell.
    dual_edges : (e, 2) integer array
        Pairs of sites, the lower first, whose cells share a border.
    border_lengths : (e,) array
        Length of the border between them.
    borders : (s, 2, 3) array
        Segments of the borders, within faces.
    pieces : (p, 3, 3) array
        Triangles that make up the faces that several cells share.
    piece_labels : (p,) integer array
        The site of each.
    """

    mesh: TriangleMesh
    sites: SurfacePoints
    label: Ints
    distance: Floats
    areas: Floats
    dual_edges: Ints
    border_lengths: Floats
    borders: Floats
    pieces: Floats
    piece_labels: Ints

    @property
    def result(self) -> Result:
        """The arrays ``label`` and ``distance`` per vertex, with a report."""
        reached = self.label >= 0
        sizes = np.bincount(self.label[reached], minlength=len(self.sites))
        radii = np.zeros(len(self.sites))
        np.maximum.at(radii, self.label[reached], self.distance[reached])
        report = {
            "sites": self.sites.report(),
            "areas": self.areas.tolist(),
            "vertices": sizes.tolist(),
            "radii": radii.tolist(),
            "dual_edges": self.dual_edges.tolist(),
            "border_lengths": self.border_lengths.tolist(),
            "unreachable_vertices": int((~reached).sum()) - len(self.mesh.unreferenced_vertices),
        }
        fields = [Field("label", "vertex", self.label.astype(np.int32)), Field("distance", "vertex", self.distance)]
        return Result(self.mesh, fields, report, self.sites)


def voronoi_cells(mesh: TriangleMesh, sites: SurfacePoints) -> VoronoiCells:
    """Return the geodesic Voronoi cells of sites: vertices or points within faces.

    Labels and distances of vertices are exact. In a face that several cells share, the distance from each site of its
    corners is interpolated between its exact values there: areas and borders have errors of second order. The areas of
    all cells sum to the area of the components with sites. A face belongs to the cells of its corners only.

    Raises
    ------
    ArgumentError
        If there is no site.

    Examples
    --------
    >>> from geomhw.mesh import grid, vertex_points
    >>> cells = voronoi_cells(grid(4, 4), vertex_points(grid(4, 4), [0, 4]))
    >>> cells.label[:5].tolist(), cells.areas.tolist()
    ([0, 0, 0, 1, 1], [0.5, 0.5])
    """
    if not len(sites):
        raise ArgumentError("there is no site")
    solver = ExactDistance(mesh)
    arrivals = solver.arrivals(sites)
    caps = arrivals.distance * (1 + 2 * EQUAL) + _slack(mesh, sites, arrivals)
    label, corner_distance = np.full(mesh.n_vertices, -1), np.zeros((mesh.n_faces, 3, 3))
    corner, order = mesh.faces.ravel(), np.argsort(mesh.faces, axis=None, kind="stable")
    starts = np.searchsorted(corner[order], np.arange(mesh.n_vertices + 1))
    grown = GrowingSources(solver, sites)
    for i in range(len(sites)):
        distance = grown.distance
        distance[:] = caps
        grown.add(i)
        (own,) = np.nonzero((distance <= arrivals.distance * (1 + EQUAL)) & (label < 0) & np.isfinite(caps))
        label[own] = i
        at = order[_ranges(starts[own], starts[own + 1])]
        corner_distance[at // 3, at % 3] = distance[mesh.faces[at // 3]]
    split = split_faces(mesh, label, corner_distance, len(sites))
    pairs, borders = split.pairs, split.segments
    lengths = np.linalg.norm(borders[:, 1] - borders[:, 0], axis=1)
    kept = lengths > EQUAL * float(mesh.edge_lengths.mean())  # cells that meet in a point share no border
    pairs, borders, lengths = pairs[kept], borders[kept], lengths[kept]
    dual_edges, which = np.unique(pairs, axis=0, return_inverse=True)
    return VoronoiCells(
        mesh,
        sites,
        label,
        arrivals.distance,
        split.areas,
        dual_edges,
        np.asarray(np.bincount(which.ravel(), lengths, len(dual_edges)), dtype=float),
        borders,
        split.pieces,
        split.owners,
    )


def _slack(mesh: TriangleMesh, sites: SurfacePoints, arrivals: Arrivals) -> float:
    """How far the front of a site goes beyond its cell, so that it reaches all corners of the faces of the cell.

    It is twice the length of the longest edge between two cells; at least a share of the mean edge.
    """
    source = np.where(arrivals.origin >= 0, arrivals.origin, np.arange(mesh.n_vertices))
    while (source[source] != source).any():
        source = source[source]
    within = np.minimum(arrivals.origin[source], 0)
    group = np.where(within < 0, within, source)
    a, b = mesh.edges.T
    lengths = mesh.edge_lengths
    return float(2.001 * lengths[group[a] != group[b]].max(initial=EQUAL * float(lengths.mean())))


def _ranges(begins: Ints, ends: Ints) -> Ints:
    """Concatenate the ranges between begins and ends."""
    sizes = ends - begins
    return np.asarray(np.repeat(begins - np.append(0, np.cumsum(sizes)[:-1]), sizes) + np.arange(sizes.sum()))
