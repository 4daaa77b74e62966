"""Tangent fields whose operators commute, or anticommute, with the operator of a vertex map."""

import numpy as np

from geomhw.arrays import Complexes, Floats, Ints
from geomhw.errors import ArgumentError
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.edge_directions import plane_frames
from geomhw.operators.local_fit import LocalFit

#: Squared norm of the commutator, relative to the field, up to which a field commutes. It is 4 for fields that
#: anticommute with a symmetry.
COMMUTES = 0.5
#: Squared length of a combination of fields, over the largest, below which they are dependent.
DEPENDENT = 1e-12


def checked_vertex_map(values: Ints, n: int, images: int | None = None) -> Ints:
    """Return a vertex map as integers, (n,).

    Parameters
    ----------
    values : the image of each vertex, counted from 0.
    n : number of vertices of the mesh.
    images : number of vertices of the other mesh, by default n.

    Raises
    ------
    ArgumentError
        If there are not n images, or one is not a vertex.
    """
    found = np.asarray(values)
    if found.shape != (n,):
        raise ArgumentError(f"a vertex map of this mesh has {n} images, one for each vertex, not {found.shape}")
    images = n if images is None else images
    if (bad := np.flatnonzero(~((found >= 0) & (found < images) & (found == np.floor(found))))).size:
        raise ArgumentError(f"the image of vertex {bad[0]} is {found[bad[0]]:g}, not a vertex from 0 to {images - 1}")
    return found.astype(np.int64)


def pushforward(mesh: TriangleMesh, fit: LocalFit, vertex_map: Ints, vectors: Floats) -> Floats:
    """Return dσ V, the images in space of vectors at vertices, (n, 3, ...), under the differential of a vertex map σ.

    This is the operator D_V on the coordinates of the images: dσ V = D_V (p∘σ).
    """
    slopes = np.stack(fit.tangents(mesh.vertices[vertex_map]))
    along = np.einsum("iax,ix...->ai...", fit.axes, vectors)
    return np.asarray(np.einsum("aiy,ai...->iy...", slopes, along))


def commuting_fields(
    mesh: TriangleMesh, fit: LocalFit, vertex_map: Ints, fields: Complexes, sign: float = 1.0
) -> Floats:
    """Return the combinations of fields whose operator D_V commutes or anticommutes with C f = f∘σ, for a symmetry σ.

    D_V C f - C D_V f, for the coordinates f of the vertices, is dσ V - V∘σ at each vertex. The result is the
    combinations for which its norm is small: those that the symmetry maps to themselves, or to their negatives.

    Parameters
    ----------
    fit : that of the mesh.
    vertex_map : σ, (n,).
    fields : (n, d) array, at vertices in `plane_frames` of the fitted normals.
    sign : 1 for fields that commute, -1 for those that anticommute.

    Returns
    -------
    (d, c) array of coefficients, with orthonormal columns if the fields are.
    """
    vertex_map = checked_vertex_map(vertex_map, mesh.n_vertices)
    frames = plane_frames(mesh, fit.normals)
    V = np.einsum("id,ix->ixd", fields.real, frames[:, 0]) + np.einsum("id,ix->ixd", fields.imag, frames[:, 1])
    rest = pushforward(mesh, fit, vertex_map, V) - sign * V[vertex_map]
    squares = np.einsum("i,ixd,ixe->de", mesh.vertex_areas, rest, rest, optimize=True)
    T = independent(np.einsum("i,ixd,ixe->de", mesh.vertex_areas, V, V, optimize=True))
    values, turns = np.linalg.eigh(T.T @ squares @ T) if T.size else (np.empty(0), np.empty((0, 0)))
    return np.asarray(T @ turns[:, values <= COMMUTES])


def real_parts(fields: Complexes) -> Floats:
    """Return fields at vertices, (n, d), as real and imaginary parts, (2n, d), two rows a vertex."""
    n, d = fields.shape
    return np.stack([fields.real, fields.imag], axis=1).reshape(2 * n, d)


def independent(gram: Floats) -> Floats:
    """Return the coefficients, (d, c), of orthonormal combinations of fields with these inner products, (d, d)."""
    if not gram.size:
        return np.zeros((len(gram), 0))
    sizes, turns = np.linalg.eigh(gram)
    kept = sizes > DEPENDENT * sizes[-1]
    return np.asarray(turns[:, kept] / np.sqrt(sizes[kept]))
