"""Harmonic fields: the flows that no stream function makes, two a handle."""

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import breadth_first_order

from geomhw.arrays import Floats, Ints
from geomhw.flow.stream_function import LoopPoisson
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.boundary_loops import loop_groups
from geomhw.operators.curl import quarter_turn
from geomhw.operators.divergence import divergence
from geomhw.operators.gradient import gradient, hat_gradients


def harmonic_basis(mesh: TriangleMesh, poisson: LoopPoisson | None = None) -> Floats:
    """Orthonormal harmonic fields, (2g, m, 3), by area inner product; none crosses the boundary.

    Closed 1-forms along the loops of a tree-cotree decomposition [Eppstein 2003; Crane et al., Digital Geometry
    Processing with Discrete Exterior Calculus, sec. 8.2], less the closest gradient, turned by a right angle: h = n x
    (X - ∇f) is a stream flow locally, so exactly divergence-free, and its curl vanishes in the weak sense. The mesh is
    an oriented manifold; 1-forms vanish along the boundary. poisson: the mesh's, where it is at hand.
    """
    forms = closed_forms(mesh)
    if forms.shape[0] == 0:
        return np.zeros((0, mesh.n_faces, 3))
    X = _face_fields(mesh, forms)
    poisson = poisson or LoopPoisson(mesh)
    spread = divergence(mesh) @ X.reshape(len(X), -1).T
    f = np.stack([poisson(-poisson.gathered(column)) for column in spread.T], axis=1)
    exact = X - (gradient(mesh) @ f).T.reshape(X.shape)
    turned = quarter_turn(mesh, exact)
    weight = np.sqrt(mesh.face_areas)[:, None]
    Q = np.linalg.qr((turned * weight).reshape(len(turned), -1).T)[0]
    return np.asarray(Q.T.reshape(turned.shape) / weight)


def closed_forms(mesh: TriangleMesh) -> sp.csr_array:
    """One closed 1-form a generator, (2g, e), with values -1, 0, 1 on ``mesh.edges``, from the lower vertex up.

    Each counts how often an edge is crossed, and from which side, by one loop of faces; no loop bounds.
    """
    sides = _edge_faces(mesh)
    inner = np.asarray((sides >= 0).all(axis=1))
    in_tree = _tree_edges(loop_groups(mesh)[mesh.edges], inner, mesh.n_vertices)
    parents = _forest(sides, inner & ~in_tree, mesh.n_faces)
    crossed = _parent_edges(sides, inner & ~in_tree, parents)
    used = in_tree.copy()
    used[crossed[crossed >= 0]] = True
    generators = np.flatnonzero(inner & ~used)
    rows: list[int] = []
    columns: list[int] = []
    values: list[float] = []
    # One walk up the tree a generator, sequential by nature; there are 2g of them.
    for row, edge in enumerate(generators.tolist()):
        ahead, behind = (_climb(face, parents, crossed) for face in sides[edge].tolist())
        for path, sign in ((ahead, 1), (behind, -1)):
            for face, over in path:
                rows.append(row)
                columns.append(over)
                # Leaving a face over an edge that runs upward in it counts +1.
                values.append(sign * (1 if sides[over, 0] == face else -1))
        rows.append(row)
        columns.append(edge)
        values.append(-1)
    shape = (len(generators), mesh.n_edges)
    return sp.coo_array((np.array(values), (rows, columns)), shape=shape).tocsr()


def _edge_faces(mesh: TriangleMesh) -> Ints:
    """The face in which each edge runs upward, and that in which it runs downward, (e, 2); -1 where there is none."""
    sides = np.full((mesh.n_edges, 2), -1)
    down = np.roll(mesh.faces, -1, axis=1) > np.roll(mesh.faces, -2, axis=1)
    sides[mesh.edge_table.of_faces, down.astype(int)] = np.arange(mesh.n_faces)[:, None]
    return sides


def _forest(pairs: Ints, chosen: Ints, size: int) -> Ints:
    """Parents, (size,), of a breadth-first forest over the chosen pairs; -1 at the roots."""
    from scipy.sparse.csgraph import connected_components

    links = pairs[chosen]
    graph = sp.coo_array((np.ones(len(links)), (links[:, 0], links[:, 1])), shape=(size, size)).tocsr()
    labels = connected_components(graph, directed=False)[1]
    roots = np.unique(labels, return_index=True)[1]
    # A node before all roots makes the forest a tree.
    rows = np.concatenate([links[:, 0], np.full(len(roots), size)])
    columns = np.concatenate([links[:, 1], roots])
    joined = sp.coo_array((np.ones(len(rows)), (rows, columns)), shape=(size + 1, size + 1)).tocsr()
    parents = breadth_first_order(joined, size, directed=False)[1][:size]
    return np.where((parents < 0) | (parents == size), -1, parents)


def _tree_edges(ends: Ints, inner: Ints, size: int) -> Ints:
    """Mask of the edges of a spanning forest over the inner edges, ends given as representatives."""
    usable = inner & (ends[:, 0] != ends[:, 1])
    parents = _forest(ends, usable, size)
    mask = np.zeros(len(ends), dtype=bool)
    chosen = _parent_edges(ends, usable, parents)
    mask[chosen[chosen >= 0]] = True
    return mask


def _parent_edges(pairs: Ints, usable: Ints, parents: Ints) -> Ints:
    """For each node the one usable pair that joins it to its parent, -1 at a root."""
    found = np.full(len(parents), -1)
    number = np.flatnonzero(usable)
    for child, parent in ((0, 1), (1, 0)):
        a, b = pairs[number, child], pairs[number, parent]
        hit = parents[a] == b
        found[a[hit]] = number[hit]
    return found


def _climb(face: int, parents: Ints, crossed: Ints) -> list[tuple[int, int]]:
    """(face, edge left over) from a face up to its root."""
    path = []
    while parents[face] >= 0:
        path.append((face, int(crossed[face])))
        face = int(parents[face])
    return path


def _face_fields(mesh: TriangleMesh, forms: sp.csr_array) -> Floats:
    """The field on each face whose line integrals along its edges are the form, (k, m, 3)."""
    upward = np.roll(mesh.faces, -1, axis=1) < np.roll(mesh.faces, -2, axis=1)
    along = forms.toarray()[:, mesh.edge_table.of_faces] * np.where(upward, 1.0, -1.0)
    # From corner 0 the potential gains edge 2 to corner 1, and loses edge 1 to corner 2.
    potential = np.stack([np.zeros(along.shape[:2]), along[:, :, 2], -along[:, :, 1]], axis=2)
    return np.asarray(np.einsum("gfk,fkx->gfx", potential, hat_gradients(mesh)))
