"""Source points on a distributed mesh: vertices, points in faces, the nearest points to places in space."""

import numpy as np
from numpy.typing import ArrayLike

from geomhw.arrays import Floats, Ints
from geomhw.distributed.local_mesh import LocalMesh
from geomhw.distributed.source_stars import source_stars
from geomhw.errors import ArgumentError
from geomhw.mesh.closest_faces import closest_faces
from geomhw.mesh.named_points import points_in_faces, vertices_as_points
from geomhw.mesh.nearest import near_places
from geomhw.mesh.surface_points import SurfacePoints


def vertex_sources(mesh: LocalMesh, vertices: Ints) -> SurfacePoints:
    """Return vertices of the file as sources, the same on all ranks.

    Raises
    ------
    ArgumentError
        If a vertex does not exist, or belongs to no face.
    """
    n = mesh.n_vertices
    for outside in vertices[(vertices < 0) | (vertices >= n)][:1]:
        raise ArgumentError(f"source {outside} is not a vertex: the mesh has {n} (0 to {n - 1})")
    at = mesh.local(mesh.find(np.unique(vertices)))
    loose = np.setdiff1d(at[at < mesh.n_own], mesh.faces)
    for bad in mesh.ranks.comm.allgather(mesh.part.in_file[loose].tolist()):
        for vertex in bad[:1]:
            raise ArgumentError(f"source {vertex} belongs to no face; choose a vertex on the surface")
    return vertices_as_points(vertices)


def face_sources(mesh: LocalMesh, faces: Ints, weights: ArrayLike) -> SurfacePoints:
    """Return points in faces of the file by barycentric coordinates, checked as `face_points` does."""

    def corners_of(wanted: Ints) -> Ints:
        with mesh.ranks.agreeing():
            rows = [mesh.file.read_faces(face, face + 1) for face in wanted.tolist() if mesh.ranks.rank == 0]
        return np.concatenate(mesh.ranks.comm.bcast(rows))

    return points_in_faces(faces, weights, mesh.file.n_faces, corners_of)


def near_sources(mesh: LocalMesh, points: ArrayLike) -> tuple[SurfacePoints, Floats, float]:
    """Return the points of the surface closest to points in space, (k, 3), the same on all ranks.

    Returns
    -------
    points, with the numbers of the file; their distances from the given ones, (k,); the diagonal of the bounding box.

    Raises
    ------
    ArgumentError
        As `nearest_point`.
    """
    ranks = mesh.ranks
    used = mesh.vertices[np.unique(mesh.faces)]
    low = np.min(ranks.comm.allgather(used.min(axis=0, initial=np.inf)), axis=0)
    high = np.max(ranks.comm.allgather(used.max(axis=0, initial=-np.inf)), axis=0)
    places = near_places(points, low, high)
    count, in_file = len(places), mesh.with_ghosts(mesh.part.in_file)
    distance, corners, weights = np.full(count, np.inf), np.zeros((count, 3), np.int64), np.zeros((count, 3))
    for rows, block in mesh.blocks():
        face, b = closest_faces(block, places)
        gap = np.linalg.norm(np.einsum("kc,kcx->kx", b, block.vertices[block.faces[face]]) - places, axis=1)
        closer = gap < distance
        distance[closer], weights[closer] = gap[closer], b[closer]
        corners[closer] = in_file[rows[block.faces[face[closer]]]]
    distances = np.array(ranks.comm.allgather(distance))
    nearest = distances.argmin(axis=0), np.arange(count)
    corners, weights = (np.array(ranks.comm.allgather(part))[nearest] for part in (corners, weights))
    return _on_lowest_faces(mesh, corners, weights), distances[nearest], float(np.linalg.norm(high - low))


def _on_lowest_faces(mesh: LocalMesh, corners: Ints, weights: Floats) -> SurfacePoints:
    """Points between some vertices, (k, 3), on the lowest face of the file that has those of positive weight."""
    stars = source_stars(mesh, np.unique(corners))
    found, chosen = [], np.empty((len(corners), 3))
    triangles = stars.vertices[stars.mesh.faces]
    for k, (vertices, b) in enumerate(zip(corners, weights, strict=True)):
        face = int(np.argmax(np.all([(triangles == v).any(axis=1) for v in vertices[b > 0]], axis=0)))
        found.append(stars.faces[face])
        chosen[k] = ((triangles[face][:, None] == vertices) * b).sum(axis=1)
    return points_in_faces(
        np.array(found), chosen, mesh.file.n_faces, lambda faces: triangles[np.searchsorted(stars.faces, faces)]
    )
