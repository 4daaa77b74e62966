"""What is known at several sources, or at one within a face, before any system is solved.

One source at a vertex needs none of this: its heat spreads as it likes, and distance is shifted to zero there. Several
must be equally warm, or a curve of them would shed heat askew, and distance has to be right at each [GIH, sec. 2.4 has
both as boundary conditions].
"""

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.geodesic.heat_step import HeatStep
from geomhw.mesh.geometry import lengths
from geomhw.mesh.surface_points import SurfacePoints
from geomhw.mesh.topology import counting_order
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.solvers.auto import LaplaceSolver


def source_heat(flow: HeatStep, sources: SurfacePoints) -> Floats:
    """Heat to start with, (n,), integrated: one at a single vertex, shared by the corners for a point within a face.

    Several vertices get one each on average, in such shares that (M + tS) u makes them all equally warm.
    """
    n, vertices = flow.mesh.n_vertices, sources.vertices
    impulse = sources.impulse(n)
    if len(np.unique(flow.mesh.components[vertices])) == len(vertices):
        return impulse
    held, A = np.zeros(n), flow.matrix
    held[vertices] = 1.0
    with np.errstate(under="ignore"):
        u = held + LaplaceSolver(A, flow.surface & (held == 0), flow.solver)(-(A @ held))
    shares = (A @ u)[vertices]
    impulse = sources.within_faces.impulse(n)
    impulse[vertices] += shares / shares.mean()
    return impulse


def known_distances(mesh: TriangleMesh, sources: SurfacePoints) -> Floats:
    """Distances that are known, (n,), inf elsewhere: 0 at source vertices, and straight lines to the corners of the
    faces that hold a source; but not where another source is nearer as the crow flies, for there it may be shorter."""
    distance = np.full(mesh.n_vertices, np.inf)
    if len(sources.vertices) == len(sources):
        distance[sources.vertices] = 0.0
        return distance
    face, place = _holding(mesh, sources.within_faces)
    corners = mesh.faces[face]
    straight = np.linalg.norm(mesh.vertices[corners] - place[:, None], axis=2)
    np.minimum.at(distance, corners, straight)
    distance[sources.vertices] = 0.0
    for start, end in (mesh.edges.T, mesh.edges.T[::-1]):  # a source vertex may be nearer, along an edge
        beside = (distance[start] == 0) & np.isfinite(distance[end])
        np.minimum.at(distance, end[beside], mesh.edge_lengths[beside])
    held = np.flatnonzero(np.isfinite(distance))
    chord = _chords(mesh, sources, held)
    known = distance[held] <= chord * (1 + 1e-9)
    # At least one vertex a component must be held: the one nearest to a source.
    ascending = held[np.argsort(distance[held], kind="stable")]
    known |= np.isin(held, ascending[np.unique(mesh.components[ascending], return_index=True)[1]])
    distance[held[~known]] = np.inf
    return distance


def chord_to_nearest(mesh: TriangleMesh, sources: SurfacePoints, vertices: Ints | slice = slice(None)) -> Floats:
    """Straight through space from these vertices to the nearest source, (k,): no path on the surface is shorter."""
    places = sources.positions(mesh)
    if len(places) == 1:
        return lengths(np.subtract(mesh.vertices[vertices].T, places.T, order="C").T)
    from scipy.spatial import KDTree

    return np.asarray(KDTree(places).query(mesh.vertices[vertices])[0])


def _chords(mesh: TriangleMesh, sources: SurfacePoints, vertices: Ints) -> Floats:
    """The chord from each vertex to the nearest source of its component, (k,)."""
    if not len(sources.within_faces):
        return np.zeros(len(vertices))
    chords = np.full(len(vertices), np.inf)
    owner, label = mesh.components[sources.corners[:, 0]], mesh.components[vertices]
    for component in np.unique(label):  # those with a source
        of = label == component
        chords[of] = chord_to_nearest(mesh, sources[owner == component], vertices[of])
    return chords


def _holding(mesh: TriangleMesh, points: SurfacePoints) -> tuple[Ints, Floats]:
    """Every face that holds one of the points, and that point, (k, 3): its own face, on an edge its neighbors too."""
    place, edges = points.positions(mesh), mesh.edge_table
    on_edge = np.flatnonzero((points.weights == 0).any(axis=1))
    edge = edges.of_faces[points.faces[on_edge], np.argmin(points.weights[on_edge], axis=1)]
    by_edge = counting_order(edges.of_faces.ravel()) // 3
    ends = np.cumsum(edges.face_counts)
    round_edge = [by_edge[ends[e] - edges.face_counts[e] : ends[e]] for e in edge]
    again = np.repeat(place[on_edge], edges.face_counts[edge], axis=0)
    return np.concatenate([points.faces, *round_edge]), np.concatenate([place, again])
