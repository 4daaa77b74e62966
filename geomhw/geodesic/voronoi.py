"""Geodesic Voronoi cells of sites on a surface: labels by exact distance, areas, borders and dual edges."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from geomhw.arrays import Floats, Ints, ranges
from geomhw.errors import ArgumentError
from geomhw.geodesic.exact import Arrivals, ExactDistance
from geomhw.geodesic.growing_sources import GrowingSources
from geomhw.geodesic.voronoi_faces import split_faces
from geomhw.mesh.inserted_curves import InsertedSources, insert_sources
from geomhw.mesh.surface_points import SurfacePoints
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.results import Field, Result

#: Distances that agree up to this share are equal.
EQUAL = 1e-10
#: How far fronts go beyond their cells, in longest edges between cells.
SLACK = 2.001


@dataclass(frozen=True, eq=False)
class VoronoiCells:
    """Geodesic Voronoi diagram of k sites.

    Attributes
    ----------
    mesh : TriangleMesh
    sites : SurfacePoints
        Points, and curves of points joined by segments, which are one site each.
    divided : TriangleMesh
        ``mesh``, with curves as chains of edges. The first vertices are those of ``mesh``.
    divided_label : integer array
        The nearest site of each vertex of it.
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
    divided: TriangleMesh
    divided_label: Ints
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
        sizes = np.bincount(self.label[reached], minlength=len(self.areas))
        radii = np.zeros(len(self.areas))
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
    """Return the geodesic Voronoi cells of sites: vertices, points within faces, or curves.

    Labels and distances of vertices are exact. In a face that several cells share, the distance from each site of its
    corners is interpolated between its exact values there: areas and borders have errors of second order. The areas of
    all cells sum to the area of the components with sites. A face belongs to the cells of its corners only. Faces are
    divided along curves first.

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
    add: Callable[[GrowingSources, int], None]
    if len(sites.segments):
        found, group = insert_sources(mesh, sites), sites.groups()
        divided, points, count = found.mesh, found.sources, int(group.max()) + 1
        solver = ExactDistance(divided)
        lines = _lines(sites, found, group)
        distance = solver.from_lines(*(np.concatenate(part) for part in zip(*lines, strict=True)))
        slack = SLACK * float(divided.edge_lengths.max())
        add = lambda grown, i: grown.add_lines(*lines[i])  # noqa: E731
    else:
        divided, points, count, solver = mesh, sites, len(sites), ExactDistance(mesh)
        arrivals = solver.arrivals(sites)
        distance, slack = arrivals.distance, _slack(mesh, sites, arrivals)
        add = GrowingSources.add
    caps = distance * (1 + 2 * EQUAL) + slack
    label, corner_distance = np.full(divided.n_vertices, -1), np.zeros((divided.n_faces, 3, 3))
    corner, order = divided.faces.ravel(), np.argsort(divided.faces, axis=None, kind="stable")
    starts = np.searchsorted(corner[order], np.arange(divided.n_vertices + 1))
    grown = GrowingSources(solver, points)
    for i in range(count):
        near = grown.distance
        near[:] = caps
        add(grown, i)
        (own,) = np.nonzero((near <= distance * (1 + EQUAL)) & (label < 0) & np.isfinite(caps))
        label[own] = i
        at = order[ranges(starts[own], starts[own + 1] - starts[own])]
        corner_distance[at // 3, at % 3] = near[divided.faces[at // 3]]
    split = split_faces(divided, label, corner_distance, count)
    pairs, borders = split.pairs, split.segments
    lengths = np.linalg.norm(borders[:, 1] - borders[:, 0], axis=1)
    kept = lengths > EQUAL * float(mesh.edge_lengths.mean())  # cells that meet in a point share no border
    pairs, borders, lengths = pairs[kept], borders[kept], lengths[kept]
    dual_edges, which = np.unique(pairs, axis=0, return_inverse=True)
    return VoronoiCells(
        mesh,
        sites,
        divided,
        label,
        label[: mesh.n_vertices],
        distance[: mesh.n_vertices],
        split.areas,
        dual_edges,
        np.asarray(np.bincount(which.ravel(), lengths, len(dual_edges)), dtype=float),
        borders,
        split.pieces,
        split.owners,
    )


def _lines(sites: SurfacePoints, found: InsertedSources, group: Ints) -> list[tuple[Ints, Ints]]:
    """Return the vertices and the sides of edges of each site on the divided mesh. group: site of each point."""
    lines = []
    for i in range(int(group.max()) + 1):
        own = np.flatnonzero(group[sites.segments[:, 0]] == i)
        chains = [found.chains[s] for s in own.tolist()]
        lines.append((np.unique(np.concatenate([found.vertices[group == i], *chains])), found.sides(own)))
    return lines


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
    return float(SLACK * lengths[group[a] != group[b]].max(initial=EQUAL * float(lengths.mean())))
