"""Poisson disk sampling: random points of a surface with a least exact distance, without room for another one.

Bridson: Fast Poisson Disk Sampling in Arbitrary Dimensions. SIGGRAPH Sketches, 2007.
Corsini, Cignoni, Scopigno: Efficient and Flexible Sampling with Blue Noise Properties of Triangular Meshes. IEEE TVCG
18(6), 2012.
"""

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.errors import ArgumentError, MeshError
from geomhw.geodesic.exact import ExactDistance
from geomhw.geodesic.farthest_points import Samples, all_vertices
from geomhw.geodesic.growing_sources import GrowingSources
from geomhw.mesh.inserted_points import insert_points
from geomhw.mesh.named_points import vertex_points
from geomhw.mesh.surface_points import SurfacePoints, concatenate
from geomhw.mesh.triangle_mesh import TriangleMesh

#: Candidates a round, as a multiple of the number of disks that cover the free area, and rounds.
CANDIDATES, ROUNDS = 6.0, 6
#: Share by which the spacing shrinks until a count of points fits, and the first one as a share of the densest packing.
SHRINK, DENSEST = 0.95, 0.85
#: Most points: more need too much memory.
MOST = 1_000_000


def poisson_disks(mesh: TriangleMesh, spacing: float | None = None, count: int | None = None, seed: int = 0) -> Samples:
    """Choose random points, uniform by area, each at least a distance from all before it.

    Candidates are points within faces, as many as are likely to fill the free faces, in several rounds; then all
    vertices. At the end no vertex has the given distance from all points. Distances between points are exact: the
    candidates are vertices of a divided mesh.

    Parameters
    ----------
    mesh : any triangle mesh with an area.
    spacing : least distance between two points; by default found for the count.
    count : number of points; by default as many as fit.
    seed : of the random numbers. Equal seeds give equal points.

    Raises
    ------
    ArgumentError
        If neither a count of at least 1 nor a spacing above 0 is given, or more than a million points fit.
    MeshError
        If all faces have zero area.

    Examples
    --------
    >>> from geomhw.mesh import icosphere
    >>> samples = poisson_disks(icosphere(2), 0.5)
    >>> samples.spacing >= 0.5 > samples.radius
    True
    """
    if (
        (spacing is None and count is None)
        or (spacing is not None and not spacing > 0)
        or (count is not None and count < 1)
    ):
        raise ArgumentError("samples need a count of at least 1 or a spacing above 0")
    area = float(mesh.face_areas.sum())
    if not area > 0:
        raise MeshError("all faces of the mesh have zero area, so no room for random points")
    if spacing is not None:
        if area / spacing**2 > MOST:
            raise ArgumentError(f"more than {MOST} points at a distance of {spacing:g} fit on the mesh")
        return _filled(mesh, spacing, seed, count)
    assert count is not None
    spacing = DENSEST * float(np.sqrt(2 * area / (np.sqrt(3) * count)))
    while len((found := _filled(mesh, spacing, seed, count)).points) < count:
        spacing *= SHRINK
    return found


def _filled(mesh: TriangleMesh, spacing: float, seed: int, count: int | None) -> Samples:
    """Return points at a distance, as many as fit, at most a count."""
    random, points, free = np.random.default_rng(seed), list[SurfacePoints](), np.arange(mesh.n_faces)
    for turn in range(ROUNDS + 1):
        if turn < ROUNDS:
            share = float(mesh.face_areas[free].sum())
            candidates = _random_points(mesh, free, int(CANDIDATES * share / spacing**2) + 8, random)
        else:
            candidates = vertex_points(mesh, random.permutation(np.unique(mesh.faces)))
        found = sum(map(len, points))
        inserted = insert_points(mesh, concatenate([*points, candidates]))
        grown = GrowingSources(ExactDistance(inserted.mesh), all_vertices(inserted.mesh), spacing)
        for v in inserted.vertices[:found].tolist():
            grown.add(v)
        chosen = list[int]()
        for i, v in enumerate(inserted.vertices[found:].tolist()):
            if grown.distance[v] >= spacing and (count is None or found + len(chosen) < count):
                chosen.append(i)
                grown.add(v)
        points.append(candidates[np.array(chosen, dtype=np.int64)])
        free = _free_faces(mesh, grown.distance[: mesh.n_vertices], spacing)
        if not len(free) or found + len(chosen) == count:
            break
    return _with_gaps(mesh, concatenate(points))


def _with_gaps(mesh: TriangleMesh, points: SurfacePoints) -> Samples:
    """Return points with the distance of each from those before."""
    inserted = insert_points(mesh, points)
    grown = GrowingSources(ExactDistance(inserted.mesh), all_vertices(inserted.mesh))
    gaps = np.empty(len(points))
    for i, v in enumerate(inserted.vertices.tolist()):
        gaps[i] = grown.distance[v]
        grown.add(v)
    return Samples(points, gaps, float(grown.distance[np.unique(mesh.faces)].max()))


def _free_faces(mesh: TriangleMesh, distance: Floats, spacing: float) -> Ints:
    """Faces that may have a place at a distance from all points: their corners and edges do not rule it out."""
    lengths = np.linalg.norm(mesh.opposite_edges, axis=2)
    reach = np.maximum(np.roll(lengths, 1, axis=1), np.roll(lengths, 2, axis=1))
    return np.flatnonzero((distance[mesh.faces] + reach >= spacing).all(axis=1))


def _random_points(mesh: TriangleMesh, faces: Ints, count: int, random: np.random.Generator) -> SurfacePoints:
    """Random points within some faces, uniform by area."""
    total = np.cumsum(mesh.face_areas[faces])
    chosen = faces[np.minimum(np.searchsorted(total, random.random(count) * total[-1]), len(faces) - 1)]
    u, v = np.sqrt(random.random(count)), random.random(count)
    weights = np.stack([1 - u, u * (1 - v), u * v], axis=1)
    return SurfacePoints(chosen, mesh.faces[chosen].astype(np.int64), weights)
