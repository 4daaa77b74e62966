"""Harmonic vector fields: divergence-free flows without vorticity, two for each handle of the surface."""

import numpy as np
import scipy.sparse as sp

from geomhw.arrays import Floats, Ints
from geomhw.flow.stream_function import StreamFunctionSolver
from geomhw.mesh.cut import cut_at_pinched_vertices
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.boundary_loops import loop_representatives
from geomhw.operators.curl import quarter_turn
from geomhw.operators.divergence import divergence
from geomhw.operators.gradient import gradient, hat_gradients


def harmonic_basis(mesh: TriangleMesh, poisson: StreamFunctionSolver | None = None) -> Floats:
    """Return an orthonormal basis of the harmonic fields.

    Each basis field starts from a closed 1-form X along a generator of a tree-cotree decomposition. Its closest
    gradient is subtracted and the rest turned by a right angle, h = n x (X - ∇f). So h is locally n x ∇ of a function,
    hence exactly divergence-free, and its weak curl vanishes.

    Parameters
    ----------
    mesh : an oriented manifold, with or without boundary. It is cut open at pinched vertices.
    poisson : the solver of this mesh, if it exists already.

    Returns
    -------
    (2g, m, 3) array for genus g, units 1/length, orthonormal in the area inner product. No field crosses the boundary.

    References
    ----------
    Eppstein: Dynamic generators of topologically embedded graphs, 2003.
    Crane, de Goes, Desbrun, Schröder: Digital Geometry Processing with Discrete Exterior Calculus, sec. 8.2, 2013.

    Examples
    --------
    >>> from geomhw.mesh import torus
    >>> harmonic_basis(torus(12, 6)).shape
    (2, 144, 3)
    """
    given, mesh = mesh, cut_at_pinched_vertices(mesh)[0]
    forms = closed_forms(mesh)
    if not len(forms):
        return np.zeros((0, mesh.n_faces, 3))
    X = _face_fields(mesh, forms)
    if poisson is None or mesh is not given:
        poisson = StreamFunctionSolver(mesh)
    Div_X = divergence(mesh) @ X.reshape(len(X), -1).T
    f = np.stack([poisson(-poisson.gather(column)) for column in Div_X.T], axis=1)
    return orthonormal(mesh, quarter_turn(mesh, X - (gradient(mesh) @ f).T.reshape(X.shape)))


def orthonormal(mesh: TriangleMesh, fields: Floats) -> Floats:
    """Orthonormalize face fields, (k, m, 3), in the area inner product."""
    if not len(fields):
        return fields
    weight = np.sqrt(mesh.face_areas)[:, None]
    Q = np.linalg.qr((fields * weight).reshape(len(fields), -1).T)[0]
    return np.asarray(Q.T.reshape(fields.shape) / weight)


def closed_forms(mesh: TriangleMesh) -> Floats:
    """One closed 1-form per generator, (2g, e), on ``mesh.edges`` from the lower to the higher vertex; 0 on boundaries.

    Each counts the signed crossings of every edge by a closed path of faces; no such path is a boundary.
    """
    edge_faces = edge_faces_of(mesh)
    inner = np.asarray((edge_faces >= 0).all(axis=1))
    ends = loop_representatives(mesh)[mesh.edges]
    tree = spanning_forest(ends, inner & (ends[:, 0] != ends[:, 1]), mesh.n_vertices)[1]
    rest = inner.copy()
    rest[tree[tree >= 0]] = False
    parents, cotree = spanning_forest(edge_faces, rest, mesh.n_faces)
    rest[cotree[cotree >= 0]] = False
    return crossing_forms(edge_faces, parents, cotree, np.flatnonzero(rest))


def crossing_forms(edge_faces: Ints, parents: Ints, cotree: Ints, generators: Ints) -> Floats:
    """One closed 1-form per generator, (g, e): the signed crossings of edges by a path of faces through the generator.

    parents, cotree: of a `spanning_forest` of the faces, over which the path continues from both faces of a generator.
    """
    forms = np.zeros((len(generators), len(edge_faces)))
    for form, edge in zip(forms, generators, strict=True):
        form[edge] = -1
        # From both faces of the edge to the root. Leaving a face over an edge that runs upward in it counts +1.
        for face, sign in zip(edge_faces[edge], (1, -1), strict=True):
            while parents[face] >= 0:
                crossed = cotree[face]
                form[crossed] += sign if edge_faces[crossed, 0] == face else -sign
                face = parents[face]
    return forms


def edge_faces_of(mesh: TriangleMesh) -> Ints:
    """The face in which each edge runs from lower to higher vertex, and the face of the reverse, (e, 2); -1 if none."""
    faces = np.full((mesh.n_edges, 2), -1)
    down = np.roll(mesh.faces, -1, axis=1) > np.roll(mesh.faces, -2, axis=1)
    faces[mesh.edge_table.of_faces, down.astype(int)] = np.arange(mesh.n_faces)[:, None]
    return faces


def spanning_forest(pairs: Ints, usable: Ints, size: int) -> tuple[Ints, Ints]:
    """Breadth-first forest over the usable pairs: parent of each node and the pair joining them; -1 at roots."""
    from scipy.sparse.csgraph import breadth_first_order, connected_components

    links = pairs[usable]
    graph = sp.coo_array((np.ones(len(links)), (links[:, 0], links[:, 1])), shape=(size, size)).tocsr()
    roots = np.unique(connected_components(graph, directed=False)[1], return_index=True)[1]
    # A node before all roots makes the forest a tree.
    rows = np.concatenate([links[:, 0], np.full(len(roots), size)])
    columns = np.concatenate([links[:, 1], roots])
    joined = sp.coo_array((np.ones(len(rows)), (rows, columns)), shape=(size + 1, size + 1)).tocsr()
    parents = breadth_first_order(joined, size, directed=False)[1][:size]
    parents = np.where((parents < 0) | (parents == size), -1, parents)
    joining, number = np.full(size, -1), np.flatnonzero(usable)
    for child, parent in (links.T, links.T[::-1]):
        found = parents[child] == parent
        joining[child[found]] = number[found]
    return parents, joining


def _face_fields(mesh: TriangleMesh, forms: Floats) -> Floats:
    """The constant field on each face whose line integrals along its edges are the form, (k, m, 3)."""
    upward = np.roll(mesh.faces, -1, axis=1) < np.roll(mesh.faces, -2, axis=1)
    along = forms[:, mesh.edge_table.of_faces] * np.where(upward, 1.0, -1.0)
    # From corner 0 the potential gains edge 2 to corner 1, and loses edge 1 to corner 2.
    potential = np.stack([np.zeros(along.shape[:2]), along[:, :, 2], -along[:, :, 1]], axis=2)
    return np.asarray(np.einsum("gfk,fkx->gfx", potential, hat_gradients(mesh)))
