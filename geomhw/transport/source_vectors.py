"""Tangent vectors at sources: the plane that each lies in, checks, and the vertices they start from."""

import numpy as np
from numpy.typing import ArrayLike

from geomhw.arrays import Complexes, Floats, Ints
from geomhw.errors import FieldError
from geomhw.mesh.surface_points import SurfacePoints
from geomhw.mesh.tangent_frames import face_frames
from geomhw.mesh.triangle_mesh import TriangleMesh

#: A vector whose tangential part is a smaller share of it than this is normal to the surface.
LEAST_TANGENT_SHARE = 1e-6


def source_frames(mesh: TriangleMesh, sources: SurfacePoints) -> Floats:
    """Right-handed orthonormal frame of the tangent plane of each source, (k, 2, 3).

    At a vertex one of ``tangent_frames``; within a face its own plane, the first vector along its first edge.
    FieldError where such a face has no area.
    """
    inside = sources.faces >= 0
    flat = np.isin(sources.faces, mesh.degenerate_faces)
    if (inside & flat).any():
        raise FieldError(f"face {sources.faces[inside & flat][0]} has no area, so no plane for a vector")
    frames = mesh.tangent_frames[sources.corners[:, 0]]
    faces = sources.faces[inside]
    frames[inside] = face_frames(mesh.opposite_edges[faces], mesh.face_normals[faces])
    return frames


def turned(frames: Floats, degrees: ArrayLike) -> Floats:
    """Unit vectors, (k, 3), at angles, (k,), counterclockwise from the first vector of each frame, (k, 2, 3)."""
    angle = np.radians(np.asarray(degrees, dtype=float))[..., None]
    return np.asarray(np.cos(angle) * frames[..., 0, :] + np.sin(angle) * frames[..., 1, :])


def seeded_angle(seed: int) -> float:
    """An angle in degrees, drawn from the seed."""
    return float(360 * np.random.default_rng(seed).random())


def tangent_vectors(mesh: TriangleMesh, sources: SurfacePoints, vectors: ArrayLike) -> tuple[SurfacePoints, Floats]:
    """The different sources, and the tangential part of the vector at each, (k, 3).

    FieldError for a vector that is zero, not finite or normal to the surface, and for a source given twice with
    different vectors.
    """
    given = np.atleast_2d(np.asarray(vectors, dtype=float))
    if given.shape != (len(sources), 3):
        raise FieldError(f"{len(sources)} sources need as many vectors of three components, not {given.shape}")
    if not (finite := np.isfinite(given).all(axis=1)).all():
        bad = int(np.argmin(finite))
        raise FieldError(f"the vector at source {sources.name(bad)} is not finite: {given[bad].tolist()}")
    if not (some := given.any(axis=1)).all():
        bad = int(np.argmin(some))
        raise FieldError(f"the vector at source {sources.name(bad)} is zero; it has no direction to transport")
    chosen, group = sources.distinct()
    if (other := (given != given[chosen][group]).any(axis=1)).any():
        bad = int(np.argmax(other))
        raise FieldError(f"source {sources.name(bad)} is given twice, with different vectors; give it once")
    wanted, given = sources[chosen], given[chosen]
    frames = source_frames(mesh, wanted)
    tangent = np.einsum("sk,skx->sx", np.einsum("skx,sx->sk", frames, given), frames)
    normal = np.linalg.norm(tangent, axis=1) <= LEAST_TANGENT_SHARE * np.linalg.norm(given, axis=1)
    if normal.any():
        bad = int(np.argmax(normal))
        raise FieldError(
            f"the vector at source {wanted.name(bad)} is normal to the surface; give one with a tangential part"
        )
    return wanted, tangent


def spread_to_corners(mesh: TriangleMesh, sources: SurfacePoints, tangent: Floats) -> Complexes:
    """The vectors, (k, 3), at vertices, (n,), as complex numbers in ``tangent_frames``.

    One within a face goes to its corners by the barycentric weights, turned from the face's plane to theirs by the
    smallest rotation, so that its length is kept at each.
    """
    source, corner = np.nonzero(sources.weights)
    vertices, vectors = sources.corners[source, corner], tangent[source]
    inside = sources.faces[source] >= 0
    to = mesh.vertex_normals[vertices[inside]]
    vectors[inside] = _tilted(vectors[inside], _normals(mesh, sources.faces[source[inside]], vertices[inside]), to)
    parts = np.einsum("ckx,cx->kc", mesh.tangent_frames[vertices], vectors) * sources.weights[source, corner]
    y0 = np.zeros(mesh.n_vertices, dtype=complex)
    np.add.at(y0, vertices, parts[0] + 1j * parts[1])
    return y0


def _normals(mesh: TriangleMesh, faces: Ints, vertices: Ints) -> Floats:
    """Normals of faces, (c, 3), on the side on which those of their vertices, (c,), are.

    The side is that of ``corner_signs``; a copy of another face has none, and takes the nearer.
    """
    normals = mesh.face_normals[faces]
    corner = (mesh.faces[faces] == vertices[:, None]).argmax(axis=1)
    sign = mesh.corner_signs[faces, corner]
    nearer = np.where(np.einsum("cx,cx->c", normals, mesh.vertex_normals[vertices]) < 0, -1, 1)
    return np.asarray(normals * np.where(sign == 0, nearer, sign)[:, None])


def _tilted(vectors: Floats, normals: Floats, to: Floats) -> Floats:
    """Vectors across unit normals after the smallest rotation of these to others; as they are between opposite ones."""
    both = normals + to
    cosine = np.einsum("cx,cx->c", normals, to)
    share = np.divide(
        np.einsum("cx,cx->c", vectors, to), 1 + cosine, out=np.zeros_like(cosine), where=1 + cosine > 1e-15
    )
    return np.asarray(vectors - share[:, None] * both)
