"""Polyhedral distances on small meshes by enumeration: every straight line over every sequence of faces."""

import numpy as np
from scipy.sparse.csgraph import shortest_path

from geomhw.mesh.triangle_mesh import TriangleMesh


def enumerated_distances(mesh: TriangleMesh) -> np.ndarray:
    """Return the distances between all vertices, (n, n).

    A shortest path consists of straight lines between vertices. From each vertex, follow the cones of straight lines
    over all sequences of faces until they are longer than the longest edge path.
    """
    at_edge: dict[frozenset[int], list[int]] = {}
    for f, face in enumerate(mesh.faces.tolist()):
        for k in range(3):
            at_edge.setdefault(frozenset(face) - {face[k]}, []).append(f)
    n = mesh.n_vertices
    lengths = np.full((n, n), np.inf)
    for a, b in mesh.edges:
        lengths[a, b] = lengths[b, a] = np.linalg.norm(mesh.vertices[a] - mesh.vertices[b])
    paths = shortest_path(np.where(np.isinf(lengths), 0, lengths))
    longest = paths[np.isfinite(paths)].max()
    for face in mesh.faces.tolist():
        for k in range(3):
            source, a, b = face[k], face[k - 2], face[k - 1]
            angle = _angle(mesh.vertices[a] - mesh.vertices[source], mesh.vertices[b] - mesh.vertices[source])
            ends = np.array([lengths[source, a], lengths[source, b] * np.exp(1j * angle)])
            cones = [(frozenset((a, b)), (a, b), ends, ends, mesh.faces.tolist().index(face))]
            while cones:
                edge, (a, b), (A, B), (low, high), last = cones.pop()
                for f in at_edge[edge]:
                    if f == last:
                        continue
                    (c,) = set(mesh.faces[f].tolist()) - edge
                    base = mesh.vertices[b] - mesh.vertices[a]
                    turn = _angle(base, mesh.vertices[c] - mesh.vertices[a])
                    C = A + (B - A) / abs(B - A) * lengths[a, c] * np.exp(-1j * turn)
                    if _left_of(low, C) and _left_of(C, high):
                        lengths[source, c] = lengths[c, source] = min(lengths[source, c], abs(C))
                    for (p, P), (q, Q) in (((a, A), (c, C)), ((c, C), (b, B))):
                        right, left = P if _left_of(low, P) else low, Q if _left_of(Q, high) else high
                        if _left_of(right, left, 1e-12) and _distance_to(P, Q) < longest:
                            cones.append((frozenset((p, q)), (p, q), (P, Q), (right, left), f))
    return np.asarray(shortest_path(np.where(np.isinf(lengths), 0, lengths)))


def _angle(u: np.ndarray, v: np.ndarray) -> float:
    """Return the angle between two vectors."""
    return float(np.arctan2(np.linalg.norm(np.cross(u, v)), u @ v))


def _left_of(a: complex, b: complex, least: float = -1e-12) -> bool:
    """Whether b lies counterclockwise from a, up to rounding."""
    return bool((a.conjugate() * b).imag >= least * abs(a) * abs(b))


def _distance_to(a: complex, b: complex) -> float:
    """Return the distance of the segment from a to b from the origin."""
    t = -(a.conjugate() * (b - a)).real / abs(b - a) ** 2
    return abs(a + min(max(t, 0.0), 1.0) * (b - a))
