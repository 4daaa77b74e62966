"""Direction fields with prescribed singularities: trivial connections.

Crane, Desbrun, Schröder: Trivial Connections on Discrete Surfaces. Computer Graphics Forum 29(5), 2010.
"""

from collections.abc import Mapping

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from geomhw.arrays import Complexes, Floats, Ints
from geomhw.directions.power_fields import face_curvatures, power_transport
from geomhw.directions.singularities import face_indices
from geomhw.errors import ArgumentError
from geomhw.flow.harmonic import crossing_forms, edge_faces_of, spanning_forest
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.crouzeix_raviart import boundary_loop_edges
from geomhw.solvers.direct import DirectSolver

#: Smallest weight of an edge, over the mean cotan weight: weights stay positive on obtuse faces.
LEAST_WEIGHT = 1e-3


def trivial_connection(
    mesh: TriangleMesh, n: int, vertices: Mapping[int, float] | None = None, faces: Mapping[int, float] | None = None
) -> Complexes:
    """Compute the field of n directions that turns least and has exactly the given singularities.

    The turn φ of the field along each edge minimizes Σ w φ², with cotan weights w. It is the coexact solution for the
    indices, plus the harmonic part that makes the turns around handles multiples of 2π/n. Boundary loops take the rest
    of the Euler characteristic, where they turn least.

    Parameters
    ----------
    mesh : an oriented manifold with a single fan of faces at each vertex.
    vertices, faces : index of each singular vertex or face, a multiple of 1/n. A singular vertex has no direction: u
        is 0 there. Their faces must be different.

    Returns
    -------
    (n_vertices,) complex array, u = zⁿ.

    Raises
    ------
    ArgumentError
        If an index is no multiple of 1/n, the indices of a closed component do not sum to its Euler characteristic, or
        a vertex or face cannot be singular.

    References
    ----------
    Crane, Desbrun, Schröder: Trivial Connections on Discrete Surfaces, 2010.

    Examples
    --------
    >>> from geomhw.mesh import icosphere
    >>> ball = icosphere(2)
    >>> u = trivial_connection(ball, 1, {0: 2.0})
    """
    mesh.require_oriented("a direction field")
    cells, wanted = _cells(mesh, n, vertices or {}, faces or {})
    loops = boundary_loop_edges(mesh)
    edge_cells = edge_faces_of(mesh)
    outside = edge_cells < 0
    edge_cells = np.where(outside, -1, cells[edge_cells])
    for k, edges in enumerate(loops):
        edge_cells[edges] = np.where(outside[edges], mesh.n_faces + k, edge_cells[edges])
    w = np.maximum(mesh.edge_cotan_weights, LEAST_WEIGHT * np.abs(mesh.edge_cotan_weights).mean())
    # Even weights around singular cells, where the field turns most, spread the turn over all edges.
    singular = np.append(wanted != 0, np.zeros(len(loops) + 1, dtype=bool))
    w[singular[edge_cells].any(axis=1)] = np.abs(mesh.edge_cotan_weights).mean()
    w[edge_cells[:, 0] == edge_cells[:, 1]] = np.inf
    curvature = np.bincount(cells, face_curvatures(mesh), mesh.n_faces)
    b = np.concatenate([2 * np.pi * wanted - n * curvature, np.zeros(len(loops))])
    if loops:
        b[mesh.n_faces :] = _loop_turns(mesh, edge_cells, b, w, n)
    _require_sum(mesh, edge_cells, b, n)
    phi = _least_turns(edge_cells, b, w)
    u = _integrated(mesh, edge_cells, phi, w, n)
    _require_indices(mesh, u, n, cells, wanted)
    u[list(vertices or {})] = 0.0
    return u


def _cells(
    mesh: TriangleMesh, n: int, vertices: Mapping[int, float], faces: Mapping[int, float]
) -> tuple[Ints, Floats]:
    """The cell of each face, where the faces around a singular vertex are one, and n times the index of each cell."""
    cells, wanted = np.arange(mesh.n_faces), np.zeros(mesh.n_faces)
    taken = np.zeros(mesh.n_faces, dtype=bool)
    at_boundary = np.isin(list(vertices), mesh.boundary_vertices)
    for (vertex, index), refused in zip(vertices.items(), at_boundary, strict=True):
        star = np.flatnonzero((mesh.faces == vertex).any(axis=1))
        if refused or not len(star):
            raise ArgumentError(f"vertex {vertex} cannot be singular: it is on the boundary, or has no faces")
        if taken[star].any():
            raise ArgumentError(f"vertex {vertex} shares a face with another singular vertex; take one farther away")
        taken[star] = True
        cells[star] = star[0]
        wanted[star[0]] = n * index
    for face, index in faces.items():
        if taken[face]:
            raise ArgumentError(f"face {face} is next to a singular vertex; take one farther away")
        wanted[face] = n * index
    if (bad := np.flatnonzero(np.abs(wanted - np.rint(wanted)) > 1e-6)).size:
        raise ArgumentError(f"the index {wanted[bad[0]] / n:g} is no multiple of 1/{n}, as of {n} directions")
    return cells, np.rint(wanted)


def _loop_turns(mesh: TriangleMesh, edge_cells: Ints, b: Floats, w: Floats, n: int) -> Floats:
    """Turns of the field out of each boundary loop, minus the sum over its edges, for the nearest possible numbers.

    The numbers are rounded from those of the field that is free at the boundary, with their sum on each component.
    """
    free = np.where(edge_cells < mesh.n_faces, edge_cells, mesh.n_faces)
    phi = _least_turns(free, np.append(b[: mesh.n_faces], -b[: mesh.n_faces].sum()), w)
    sums = np.array([phi[edges] @ _ahead(mesh, edges) for edges in boundary_loop_edges(mesh)])
    angles = np.bincount(mesh.faces.ravel(), mesh.angles.ravel(), mesh.n_vertices)
    curves = np.array([n * (np.pi - angles[loop]).sum() for loop in mesh.boundary_loops])
    numbers = (curves - sums) / (2 * np.pi)
    rounded = np.rint(numbers)
    component = mesh.components[[loop[0] for loop in mesh.boundary_loops]]
    for label in np.unique(component):
        here = np.flatnonzero(component == label)
        missing = int(np.rint((numbers[here] - rounded[here]).sum()))
        order = here[np.argsort(np.sign(missing) * (rounded[here] - numbers[here]), kind="stable")]
        rounded[order[: abs(missing)]] += np.sign(missing)
    return np.asarray(2 * np.pi * rounded - curves)


def _ahead(mesh: TriangleMesh, edges: Ints) -> Floats:
    """Sign of boundary edges: 1 where their face runs from the lower to the higher vertex."""
    return np.where(edge_faces_of(mesh)[edges, 0] >= 0, 1.0, -1.0)


def _require_sum(mesh: TriangleMesh, edge_cells: Ints, b: Floats, n: int) -> None:
    """Raise ArgumentError unless indices and curvature agree on each component."""
    label = np.zeros(len(b), dtype=int)
    label[edge_cells.ravel()] = np.repeat(mesh.components[mesh.edges[:, 0]], 2)
    excess = np.bincount(label, b) / (2 * np.pi * n)
    if (bad := np.flatnonzero(np.abs(excess) > 1e-6)).size:
        vertices = mesh.components == bad[0]
        faces, edges = vertices[mesh.faces[:, 0]].sum(), vertices[mesh.edges[:, 0]].sum()
        chi = int(vertices.sum()) - int(edges) + int(faces)
        raise ArgumentError(
            f"the indices sum to {chi + excess[bad[0]]:g}, but on this surface they must sum to its Euler "
            f"characteristic, {chi}"
        )


def _least_turns(edge_cells: Ints, b: Floats, w: Floats) -> Floats:
    """Turns along edges, (e,), with the sums b around cells and the least Σ w φ²."""
    e, size = len(w), len(b)
    columns = np.arange(e)
    D = sp.csr_array(
        (np.repeat([1.0, -1.0], e), (edge_cells.T.ravel(), np.tile(columns, 2))),
        shape=(size, e),
    )
    inverse = sp.diags_array(1 / w)
    label = connected_components((abs(D) @ abs(D).T).tocsr(), directed=False)[1]
    free = np.ones(size, dtype=bool)
    free[np.unique(label, return_index=True)[1]] = False
    return np.asarray(inverse @ (D.T @ DirectSolver((D @ inverse @ D.T).tocsr(), free)(b)))


def _integrated(mesh: TriangleMesh, edge_cells: Ints, phi: Floats, w: Floats, n: int) -> Complexes:
    """The field, (n_vertices,), with these turns and the least harmonic turns that close it around handles."""
    usable = edge_cells[:, 0] != edge_cells[:, 1]
    tree_parents, tree = spanning_forest(mesh.edges, usable, mesh.n_vertices)
    rest = usable.copy()
    rest[tree[tree >= 0]] = False
    parents, cotree = spanning_forest(edge_cells, rest, int(edge_cells.max()) + 1)
    rest[cotree[cotree >= 0]] = False
    generators = np.flatnonzero(rest)
    delta = phi - np.angle(power_transport(mesh, n))
    theta = _along_tree(mesh.edges, tree_parents, tree, delta)
    if len(generators):
        i, j = mesh.edges[generators].T
        gap = delta[generators] - theta[j] + theta[i]
        gap = np.angle(np.exp(1j * gap))
        delta += gap @ _coclosed(mesh, crossing_forms(edge_cells, parents, cotree, generators), w, usable)
        theta = _along_tree(mesh.edges, tree_parents, tree, delta)
    return np.exp(1j * theta)


def _coclosed(mesh: TriangleMesh, forms: Floats, w: Floats, usable: Ints) -> Floats:
    """The forms, (g, e), without their closest exact part."""
    weights = np.where(usable, w, 0.0)
    e, (i, j) = mesh.n_edges, mesh.edges.T
    d = sp.csr_array((np.repeat([-1.0, 1.0], e), (np.tile(np.arange(e), 2), np.concatenate([i, j]))))
    W = sp.diags_array(weights)
    S = (d.T @ W @ d).tocsr()
    label = connected_components(S, directed=False)[1]
    free = np.ones(S.shape[0], dtype=bool)
    free[np.unique(label, return_index=True)[1]] = False
    return np.asarray(forms - (d @ DirectSolver(S, free)(d.T @ (W @ forms.T))).T)


def _along_tree(edges: Ints, parents: Ints, joining: Ints, delta: Floats) -> Floats:
    """Sums, (n,), of the changes along edges, from the lower to the higher vertex, from the root to each vertex."""
    child = np.arange(len(parents))
    sign = np.where(edges[joining, 0] == parents, 1.0, -1.0)
    total = np.where(parents >= 0, sign * delta[joining], 0.0)
    up = np.where(parents >= 0, parents, child)
    while (up != up[up]).any():
        total, up = total + np.where(up != child, total[up], 0.0), up[up]
    return np.asarray(total)


def _require_indices(mesh: TriangleMesh, u: Complexes, n: int, cells: Ints, wanted: Floats) -> None:
    """Raise ArgumentError if the mesh is too coarse for an index: a field turns by less than π/n along an edge."""
    found = np.bincount(cells, face_indices(mesh, u, n), mesh.n_faces)
    if (bad := np.flatnonzero(np.rint(found) != wanted)).size:
        corners = ", ".join(map(str, mesh.faces[bad[0]]))
        raise ArgumentError(
            f"the mesh is too coarse for these singularities near face {bad[0]} (vertices {corners}): the field would "
            "turn by more than half the angle between its directions along an edge; give parts of the index to several "
            "vertices, or refine the mesh there"
        )
