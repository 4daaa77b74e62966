"""Karcher mean and geometric median of points on a surface, by exact logarithmic and exponential maps.

Karcher: Riemannian Center of Mass and Mollifier Smoothing. Comm. Pure Appl. Math. 30(5), 1977.
Weiszfeld: Sur le point pour lequel la somme des distances de n points donnés est minimum. Tohoku Math. J. 43, 1937.
Vardi, Zhang: The Multivariate L1-Median and Associated Data Depth. PNAS 97(4), 2000.
"""

from math import inf

import numpy as np

from geomhw.errors import ArgumentError, FieldError
from geomhw.geodesic.exact import ExactDistance
from geomhw.geodesic.shortest_paths import ShortestPaths
from geomhw.mesh.inserted_points import InsertedPoints, insert_points
from geomhw.mesh.named_points import face_point, vertex_points
from geomhw.mesh.surface_points import SurfacePoints, concatenate
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.transport.mean_search import MeanSearch, SurfaceMean

#: Starts are vertices and edges of least value among their neighbors, within this share of the least one; how many of
#: either kind.
BAND, STARTS = 0.05, 8
#: Values are equal up to this share.
EQUAL = 1e-9
#: Minima at a larger distance differ, as a share of the largest distance of a point.
APART = 1e-5


def karcher_mean(mesh: TriangleMesh, points: SurfacePoints) -> SurfaceMean:
    """Return the point of least sum of squared exact distances from given points.

    The iteration steps along the straightest geodesic whose vector is the mean of the logarithmic map, halved until the
    sum does not grow, up to rounding. It starts at the vertices and edges that have the least sum among their neighbors
    and are nearly the best, and on the shortest path between two points; the best minimum is returned.

    Parameters
    ----------
    mesh : TriangleMesh
    points : k points, vertices or within faces.

    Raises
    ------
    ArgumentError
        If there is no point.
    FieldError
        If no path connects two of the points.

    References
    ----------
    Karcher: Riemannian Center of Mass and Mollifier Smoothing. Comm. Pure Appl. Math. 30(5), 1977.

    Examples
    --------
    >>> from geomhw.mesh import grid, vertex_points
    >>> square = grid(2, 2)
    >>> karcher_mean(square, vertex_points(square, [0, 2, 6, 8])).point.report()
    [4]
    """
    return _center(mesh, points, median=False)


def geometric_median(mesh: TriangleMesh, points: SurfacePoints) -> SurfaceMean:
    """Return the point of least sum of exact distances from given points; parameters and errors as `karcher_mean`.

    The steps are those of Weiszfeld, at a given point those of Vardi and Zhang.

    Examples
    --------
    >>> from geomhw.mesh import grid, vertex_points
    >>> square = grid(2, 2)
    >>> geometric_median(square, vertex_points(square, [0, 4, 5])).point.report()
    [4]
    """
    return _center(mesh, points, median=True)


def _center(mesh: TriangleMesh, points: SurfacePoints, median: bool) -> SurfaceMean:
    """Minimize from several starts; return the best minimum."""
    if not len(points):
        raise ArgumentError("there is no point to take the mean of")
    inserted = insert_points(mesh, points)
    search = MeanSearch(inserted.mesh, inserted.vertices, median)
    starts, radius = _starts(search)
    found = [search.minimum(start, radius) for start in starts]
    best = min(found, key=lambda item: item.value)
    places = [original_point(mesh, inserted, item.point) for item in found]
    point = places[found.index(best)]
    others, scale = [point], APART * float(best.distances.max())
    for item, place in zip(found, places, strict=True):
        away = [np.linalg.norm(place.positions(mesh) - other.positions(mesh)) for other in others]
        if item.value <= best.value * (1 + EQUAL) and min(away) > scale:
            others.append(place)
    rest = concatenate(others[1:]) if others[1:] else None
    return SurfaceMean(point, best.value, best.distances, best.last_step, best.steps, rest)


def original_point(mesh: TriangleMesh, inserted: InsertedPoints, point: SurfacePoints) -> SurfacePoints:
    """Return a point of a divided mesh as one of the mesh before."""
    face, corner = int(point.faces[0]), point.weights[0]
    if face < 0:
        if (v := int(point.vertices[0])) < mesh.n_vertices:
            return vertex_points(mesh, [v])
        face, k = np.argwhere(inserted.mesh.faces == v)[0].tolist()
        corner = np.eye(3)[k]
    return face_point(mesh, int(inserted.parents[face]), corner @ inserted.corners[face])


def _starts(search: MeanSearch) -> tuple[list[SurfacePoints], float]:
    """Vertices and middles of edges to start from, the best first, and a radius with all given points round each.

    They are local minima of the sum, as it is on flat faces, no farther from any given point than a minimum can be. A
    squared distance from one image of a point is x² + a linear function along an edge, and thus known from its ends.
    """
    mesh, solver, targets = search.mesh, ExactDistance(search.mesh), search.targets
    given = [vertex_points(mesh, [v]) for v in targets.tolist()]
    between = solver.rows(given, targets=[targets] * len(given))[:, targets]
    if np.isinf(between[0]).any():
        k = int(np.isinf(between[0]).argmax())
        raise FieldError(f"no path connects point 0 with point {k}: they lie on different components")
    reach = search.radius(float((between if search.median else between**2).sum(axis=1).min()))
    distances = solver.rows(given, reach)
    (a, b), quarters = mesh.edges.T, mesh.edge_lengths**2 / 4
    at_vertices, at_edges = np.zeros(mesh.n_vertices), np.zeros(mesh.n_edges)
    for d in distances**2:
        middle = np.maximum((d[a] + d[b]) / 2 - quarters, 0)
        at_vertices += np.sqrt(d) if search.median else d
        at_edges += np.sqrt(middle) if search.median else middle
    least_vertex, least_edge = np.full((2, mesh.n_vertices), inf)
    for least, one, other in ((least_vertex, at_vertices[a], at_vertices[b]), (least_edge, at_edges, at_edges)):
        np.minimum.at(least, a, other)
        np.minimum.at(least, b, one)
    vertices = np.flatnonzero((at_vertices <= least_vertex) & np.isfinite(at_vertices))
    is_least = (at_edges <= np.minimum(least_edge[a], least_edge[b])) & np.isfinite(at_edges)
    edges = np.flatnonzero(is_least & (at_edges < np.minimum(at_vertices[a], at_vertices[b])))
    found = []
    for local, values, point in ((vertices, at_vertices, _vertex), (edges, at_edges, _middle)):
        order = local[np.argsort(values[local], kind="stable")][:STARTS]
        found += [(float(values[k]), point(mesh, int(k))) for k in order]
    found.sort(key=lambda item: item[0])
    if len(given) == 2 and not search.median:  # the middle of a shortest path is a minimum
        (path,) = ShortestPaths(mesh).between(*given)
        found.insert(0, (path.length**2 / 2, path.end(int(np.abs(path.arc_length - path.length / 2).argmin()))))
    starts = [start for value, start in found if value <= found[0][0] * (1 + BAND)]
    return starts, reach + float(mesh.edge_lengths.max())


def _vertex(mesh: TriangleMesh, v: int) -> SurfacePoints:
    """Return a vertex as a point."""
    return vertex_points(mesh, [v])


def _middle(mesh: TriangleMesh, edge: int) -> SurfacePoints:
    """Return the middle of an edge."""
    face = int(np.flatnonzero((mesh.edge_table.of_faces == edge).any(axis=1))[0])
    return face_point(mesh, face, np.isin(mesh.faces[face], mesh.edges[edge]) / 2)
