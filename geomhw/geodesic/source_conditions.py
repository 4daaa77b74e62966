"""Several sources, or sources inside faces: their heat, and the distances that are known near them.

One source vertex needs neither: it starts with unit heat, and the distance is shifted to zero there. Several source
vertices are equally warm, (M + tS) u = u0 with u = const at the sources; from a curve of unequal sources heat would
flow askew. Known distances are Dirichlet conditions of the Poisson problem [GIH, sec. 2.4].
"""

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.geodesic.heat_step import HeatStep
from geomhw.mesh.geometry import lengths
from geomhw.mesh.surface_points import SurfacePoints
from geomhw.mesh.topology import counting_order
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.solvers.auto import LaplaceSolver

#: Distances up to this share longer than the chord are equal to it up to rounding.
ROUNDING = 1e-9


def source_heat(step: HeatStep, sources: SurfacePoints, mesh: TriangleMesh) -> Floats:
    """Return the initial heat u0, (n,), integrated.

    A single vertex has 1; a point inside a face gives its corners their barycentric coordinates. Several vertices have
    a mean of 1, in the shares that make them equally warm after the step. Segments have their length in mean edges.
    """
    n, vertices = step.mesh.n_vertices, sources.vertices
    if len(sources.segments):
        return _segment_heat(mesh, sources)
    if len(np.unique(step.mesh.components[vertices])) == len(vertices):
        return sources.impulse(n)
    at_sources, A = np.zeros(n), step.matrix
    at_sources[vertices] = 1.0
    with np.errstate(under="ignore"):  # u = 1 at the sources, and (M + tS) u = 0 elsewhere
        u = at_sources + LaplaceSolver(A, step.surface & (at_sources == 0), step.solver)(-(A @ at_sources))
    shares = (A @ u)[vertices]
    u0 = sources.within_faces.impulse(n)
    u0[vertices] += shares / shares.mean()
    return u0


def _segment_heat(mesh: TriangleMesh, sources: SurfacePoints) -> Floats:
    """Return heat of constant density along segments, integrated with the hat functions of corners, and 1 elsewhere."""
    i, j, _ = sources.segments.T
    spots = np.concatenate([sources.corners[i], sources.corners[j]])
    ends = sources.positions(mesh)
    length = np.tile(lengths(ends[i] - ends[j]) / (2 * mesh.mean_edge_length), 2)
    shares = np.concatenate([sources.weights[i], sources.weights[j]]) * length[:, None]
    alone = np.setdiff1d(np.arange(len(sources)), sources.segments[:, :2])
    heat = np.bincount(spots.ravel(), shares.ravel(), mesh.n_vertices)
    return np.asarray(heat + sources[alone].impulse(mesh.n_vertices))


def known_distances(mesh: TriangleMesh, sources: SurfacePoints, components: Ints | None = None) -> Floats:
    """Return distances near the sources, (n,), inf where unknown.

    They are 0 at source vertices, and straight lines to the corners of the faces that contain a source. Where another
    source is nearer in space, the distance on the surface may be shorter too, and is unknown. components: labels of
    vertices, (n,), where the mesh is a part of another one; by default its own.
    """
    if len(sources.segments):  # exact at the corners of the faces that contain them
        from geomhw.geodesic.exact import ExactDistance

        near = np.union1d(mesh.faces[sources.segments[:, 2]], np.append(sources.vertices, sources.corners))
        exact = np.asarray(ExactDistance(mesh).from_sources(sources, targets=near)["distance"])
        distance = np.full(mesh.n_vertices, np.inf)
        distance[near] = exact[near]
        return distance
    distance = np.full(mesh.n_vertices, np.inf)
    if len(sources.vertices) == len(sources):
        distance[sources.vertices] = 0.0
        return distance
    components = mesh.components if components is None else components
    faces, positions = _containing_faces(mesh, sources.within_faces)
    corners = mesh.faces[faces]
    np.minimum.at(distance, corners, np.linalg.norm(mesh.vertices[corners] - positions[:, None], axis=2))
    distance[sources.vertices] = 0.0
    for start, end in (mesh.edges.T, mesh.edges.T[::-1]):  # along an edge from a source vertex
        candidate = (distance[start] == 0) & np.isfinite(distance[end])
        np.minimum.at(distance, end[candidate], mesh.edge_lengths[candidate])
    finite = np.flatnonzero(np.isfinite(distance))
    known = distance[finite] <= _chords(mesh, sources, finite, components) * (1 + ROUNDING)
    # The Poisson problem needs one known distance per component: that of the vertex nearest to a source.
    ascending = finite[np.argsort(distance[finite], kind="stable")]
    known |= np.isin(finite, ascending[np.unique(components[ascending], return_index=True)[1]])
    distance[finite[~known]] = np.inf
    return distance


def chord_to_nearest(mesh: TriangleMesh, sources: SurfacePoints, vertices: Ints | slice = slice(None)) -> Floats:
    """Return the distance in space from vertices to the nearest source, (k,), a lower bound on geodesic distance."""
    positions = sources.positions(mesh)
    if len(sources.segments):
        return _to_segments(mesh.vertices[vertices], positions, sources)
    return chord_to_points(mesh.vertices[vertices], positions)


def chord_to_points(points: Floats, positions: Floats) -> Floats:
    """Return the distance in space from points, (k, 3), to the nearest of some positions, (k,)."""
    if len(positions) == 1:
        return lengths(np.subtract(points.T, positions.T, order="C").T)
    from scipy.spatial import KDTree

    return np.asarray(KDTree(positions).query(points)[0])


def _to_segments(points: Floats, positions: Floats, sources: SurfacePoints) -> Floats:
    """Return the distance in space from points to the nearest source or segment, (k,)."""
    i, j, _ = sources.segments.T
    along = positions[j] - positions[i]
    square = np.maximum(np.einsum("sx,sx->s", along, along), np.finfo(float).tiny)
    nearest = np.full(len(points), np.inf)
    for k, point in enumerate(points):
        share = np.clip(np.einsum("sx,sx->s", point - positions[i], along) / square, 0, 1)
        apart = lengths(positions[i] + share[:, None] * along - point)
        nearest[k] = min(apart.min(), lengths(positions - point).min())
    return nearest


def _chords(mesh: TriangleMesh, sources: SurfacePoints, vertices: Ints, components: Ints) -> Floats:
    """The chord from each vertex to the nearest source of its component, (k,)."""
    chords = np.full(len(vertices), np.inf)
    of_sources, of_vertices = components[sources.corners[:, 0]], components[vertices]
    for component in np.unique(of_vertices):  # each has a source
        here = of_vertices == component
        chords[here] = chord_to_nearest(mesh, sources[of_sources == component], vertices[here])
    return chords


def _containing_faces(mesh: TriangleMesh, points: SurfacePoints) -> tuple[Ints, Floats]:
    """Faces that contain a point, all at its edge for one on an edge, and the positions of the points, (k, 3)."""
    positions, edges = points.positions(mesh), mesh.edge_table
    on_edge = np.flatnonzero((points.weights == 0).any(axis=1))
    edge = edges.of_faces[points.faces[on_edge], np.argmin(points.weights[on_edge], axis=1)]
    by_edge = counting_order(edges.of_faces.ravel()) // 3
    ends = np.cumsum(edges.face_counts)
    at_edges = [by_edge[ends[e] - edges.face_counts[e] : ends[e]] for e in edge]
    repeated = np.repeat(positions[on_edge], edges.face_counts[edge], axis=0)
    return np.concatenate([points.faces, *at_edges]), np.concatenate([positions, repeated])
