"""Singularities of direction fields: the index of each face, and the turns along the boundary."""

from typing import Any

import numpy as np

from geomhw.arrays import Complexes, Floats, Ints
from geomhw.directions.power_fields import edge_turns, face_curvatures
from geomhw.mesh.surface_points import SurfacePoints
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.results import Cloud, Field, point_cloud


def face_indices(mesh: TriangleMesh, u: Complexes, n: int) -> Ints:
    """Return n times the index of each face, (m,) integers.

    The turns of u along the three edges and n times the curvature of the face sum to a multiple of 2π. The turns cancel
    between faces, so that on a closed mesh the indices sum to the Euler characteristic.
    """
    along = along_halfedges(mesh, edge_turns(mesh, u, n))
    turns = along.sum(axis=1) + n * face_curvatures(mesh)
    return np.rint(turns / (2 * np.pi)).astype(int)


def boundary_turns(mesh: TriangleMesh, u: Complexes, n: int) -> list[float]:
    """Return how often the boundary turns more than the field along each loop, in ``boundary_loops`` order.

    Multiples of 1/n. It is 0 for a field along the boundary. With the indices of faces, these sum to the Euler
    characteristic [Poincaré, Hopf].
    """
    outer = mesh.edge_table.face_counts[mesh.edge_table.of_faces] == 1
    start = np.roll(mesh.faces, -1, axis=1)[outer]
    field = np.zeros(mesh.n_vertices)
    field[start] = along_halfedges(mesh, edge_turns(mesh, u, n))[outer] / n
    angles = np.bincount(mesh.faces.ravel(), mesh.angles.ravel(), mesh.n_vertices)
    turns = (np.pi - angles - field) / (2 * np.pi)
    return [round(float(turns[loop].sum()) * n) / n for loop in mesh.boundary_loops]


def singularity_report(mesh: TriangleMesh, u: Complexes, n: int) -> dict[str, Any]:
    """Return singular vertices, where u is zero, and faces, the turns of boundary loops, and the sum of all indices."""
    singular = np.setdiff1d(np.flatnonzero(u == 0), mesh.unreferenced_vertices)
    filled = np.where(u == 0, 1.0, u)
    indices, found = face_indices(mesh, filled, n), []
    for vertex in singular.tolist():
        star = (mesh.faces == vertex).any(axis=1)
        index = int(indices[star].sum()) / n
        found.append({"vertex": vertex, "position": mesh.vertices[vertex].tolist(), "index": index})
        indices[star] = 0
    for face in np.flatnonzero(indices).tolist():
        index = int(indices[face]) / n
        found.append({"face": face, "position": mesh.face_centers[face].tolist(), "index": index})
    turns = boundary_turns(mesh, filled, n)
    return {
        "singularities": found,
        "boundary_turns": turns,
        "index_sum": round(n * (sum(item["index"] for item in found) + sum(turns))) / n,
        "euler_characteristic": mesh.euler_characteristic,
    }


def singular_points(mesh: TriangleMesh, report: dict[str, Any]) -> Cloud:
    """Return the singularities of a report as points, with ``index``, ``vertex`` (-1 in a face), ``face`` ..."""
    found = report["singularities"]
    vertex = np.array([item.get("vertex", -1) for item in found], dtype=int)
    face = np.array([item.get("face", -1) for item in found], dtype=int)
    corners = np.where((vertex >= 0)[:, None], vertex[:, None], mesh.faces[face])
    weights = np.where((vertex >= 0)[:, None], [1.0, 0.0, 0.0], np.full(3, 1 / 3))
    index = np.array([item["index"] for item in found], dtype=float)
    return point_cloud(mesh, SurfacePoints(face, corners, weights), [Field("index", "vertex", index)])


def along_halfedges(mesh: TriangleMesh, values: Floats) -> Floats:
    """Values of edges, (e,), that change sign with the direction, along the halfedges opposite each corner, (m, 3)."""
    upward = np.roll(mesh.faces, -1, axis=1) < np.roll(mesh.faces, -2, axis=1)
    return np.where(upward, 1.0, -1.0) * values[mesh.edge_table.of_faces]
