"""Tangent vectors at sources: the frames of their planes, input checks, and the initial field at vertices."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geomhw.arrays import Complexes, Floats, Ints
from geomhw.errors import ArgumentError, FieldError, MeshError
from geomhw.mesh.cut import cut_into_sheets
from geomhw.mesh.surface_points import SurfacePoints
from geomhw.mesh.tangent_frames import face_frames
from geomhw.mesh.triangle_mesh import TriangleMesh

#: A vector with a smaller tangential part, as a share of its length, is normal to the surface.
LEAST_TANGENT_SHARE = 1e-6


def source_frames(mesh: TriangleMesh, sources: SurfacePoints) -> Floats:
    """Return a right-handed orthonormal frame of the tangent plane of each source.

    Returns
    -------
    (k, 2, 3) array: that of ``mesh.tangent_frames`` at a vertex, for the fan of its first face if it has several; for
    a point inside a face, that of the face, with the first vector along its first edge.

    Raises
    ------
    FieldError
        If a face that contains a source has zero area.

    Examples
    --------
    >>> from geomhw.mesh import face_point, grid
    >>> source_frames(grid(2, 2), face_point(grid(2, 2), 0))[0] + 0.0
    array([[1., 0., 0.],
           [0., 1., 0.]])
    """
    inside = sources.faces >= 0
    flat = np.isin(sources.faces, mesh.degenerate_faces)
    if (inside & flat).any():
        raise FieldError(f"face {sources.faces[inside & flat][0]} has zero area, so no tangent plane for a vector")
    frames = cut_into_sheets(mesh)[0].tangent_frames[sources.corners[:, 0]]
    faces = sources.faces[inside]
    frames[inside] = face_frames(mesh.opposite_edges[faces], mesh.face_normals[faces])
    return frames


def unit_vectors(frames: Floats, degrees: ArrayLike) -> Floats:
    """Return unit vectors, (k, 3), at angles, (k,), counterclockwise from the first vectors of frames, (k, 2, 3)."""
    angle = np.radians(np.asarray(degrees, dtype=float))[..., None]
    return np.asarray(np.cos(angle) * frames[..., 0, :] + np.sin(angle) * frames[..., 1, :])


def seeded_angle(seed: int) -> float:
    """Return a random angle in degrees."""
    return float(360 * np.random.default_rng(seed).random())


def checked_vectors(sources: SurfacePoints, vectors: ArrayLike) -> tuple[SurfacePoints, Floats]:
    """Check the vectors at sources, (k, 3), and return the d distinct sources with their vectors, (d, 3).

    Raises
    ------
    FieldError
        If a vector is zero or not finite, or a source is given twice with different vectors.
    """
    given = np.atleast_2d(np.asarray(vectors, dtype=float))
    if given.shape != (len(sources), 3):
        raise FieldError(f"{len(sources)} sources need as many vectors of three components, not {given.shape}")
    _refuse(~np.isfinite(given).all(axis=1), sources, "the vector at source {} is not finite")
    _refuse((given == 0).all(axis=1), sources, "the vector at source {} is zero; it has no direction to transport")
    chosen, group = sources.distinct()
    other = (given != given[chosen][group]).any(axis=1)
    _refuse(other, sources, "source {} is given twice, with different vectors; give it once")
    return sources[chosen], given[chosen]


def tangent_vectors(
    sources: SurfacePoints, given: Floats, mesh: TriangleMesh, fans: SurfacePoints, source: Ints
) -> tuple[SurfacePoints, Floats, Floats]:
    """Project vectors, (d, 3), at distinct sources to tangent planes, at a vertex with several fans to that of each.

    Parameters
    ----------
    mesh : the mesh of the sources, cut into sheets.
    fans, source : the sources on it, at a vertex with several fans once for each, and the source of each, (q,).

    Returns
    -------
    kept : SurfacePoints
        Those of ``fans`` at which the vector is not normal.
    parts : array of one tangential part for each of them.
    tangent : (d, 3) array, the longest tangential part at each source.

    Raises
    ------
    FieldError
        If a vector is normal to the surface.
    MeshError
        If a source is a vertex without a normal.
    """
    bare = (fans.faces < 0) & np.isin(fans.corners[:, 0], mesh.vertices_without_normal)
    lost = np.setdiff1d(source[bare], source[~bare])
    if lost.size:
        vertex = fans.corners[source == lost[0], 0]
        cancel = np.isin(vertex, np.delete(mesh.faces, mesh.degenerate_faces, axis=0)).any()
        why = "its faces cancel" if cancel else "all its faces have zero area"
        raise MeshError(f"vertex {sources.name(lost[0])} has no normal: {why}; take another source")
    fans, source = fans[~bare], source[~bare]
    frames, vectors = source_frames(mesh, fans), given[source]
    parts = np.einsum("sk,skx->sx", np.einsum("skx,sx->sk", frames, vectors), frames)
    length = np.linalg.norm(parts, axis=1)
    kept = length > LEAST_TANGENT_SHARE * np.linalg.norm(vectors, axis=1)
    normal = ~np.isin(np.arange(len(sources)), source[kept])
    _refuse(normal, sources, "the vector at source {} is normal to the surface; give one with a tangential part")
    fans, parts, source = fans[kept], parts[kept], source[kept]
    tangent = np.empty_like(given)
    ascending = np.argsort(length[kept], kind="stable")  # later writes win
    tangent[source[ascending]] = parts[ascending]
    return fans, parts, tangent


def _refuse(bad: NDArray[np.bool_], sources: SurfacePoints, message: str) -> None:
    """Raise an ArgumentError that names the first bad source, if there is one."""
    if bad.any():
        raise ArgumentError(message.format(sources.name(int(np.argmax(bad)))))


def spread_to_corners(mesh: TriangleMesh, sources: SurfacePoints, tangent: Floats) -> Complexes:
    """Distribute tangent vectors at sources, (k, 3), to vertices: (n,) complex numbers in ``mesh.tangent_frames``.

    A vector inside a face goes to its corners with the barycentric coordinates as weights, each time rotated from the
    plane of the face to that of the vertex by the smallest rotation.
    """
    source, corner = np.nonzero(sources.weights)
    vertices, vectors = sources.corners[source, corner], tangent[source]
    inside = sources.faces[source] >= 0
    to = mesh.vertex_normals[vertices[inside]]
    vectors[inside] = _rotated(
        vectors[inside], _side_normals(mesh, sources.faces[source[inside]], vertices[inside]), to
    )
    parts = np.einsum("ckx,cx->kc", mesh.tangent_frames[vertices], vectors) * sources.weights[source, corner]
    y0 = np.zeros(mesh.n_vertices, dtype=complex)
    np.add.at(y0, vertices, parts[0] + 1j * parts[1])
    y0[mesh.vertices_without_normal] = 0.0
    return y0


def _side_normals(mesh: TriangleMesh, faces: Ints, vertices: Ints) -> Floats:
    """Normals of faces, (c, 3), on the side of the normals of their vertices, (c,).

    The side is that of ``corner_signs``. Copies of another face have none there, and take the nearer side.
    """
    normals = mesh.face_normals[faces]
    corner = (mesh.faces[faces] == vertices[:, None]).argmax(axis=1)
    sign = mesh.corner_signs[faces, corner]
    nearer = np.where(np.einsum("cx,cx->c", normals, mesh.vertex_normals[vertices]) < 0, -1, 1)
    return np.asarray(normals * np.where(sign == 0, nearer, sign)[:, None])


def _rotated(vectors: Floats, normals: Floats, to: Floats) -> Floats:
    """Tangent vectors after the smallest rotation of their unit normals to others; unchanged if these are opposite."""
    both = normals + to
    cosine = np.einsum("cx,cx->c", normals, to)
    share = np.divide(
        np.einsum("cx,cx->c", vectors, to), 1 + cosine, out=np.zeros_like(cosine), where=1 + cosine > 1e-15
    )
    return np.asarray(vectors - share[:, None] * both)
