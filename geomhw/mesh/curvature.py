"""Gaussian curvature at the vertices of a mesh."""

import numpy as np

from geomhw.arrays import Floats
from geomhw.mesh.geometry import corner_sum
from geomhw.mesh.topology import pinched_vertices
from geomhw.mesh.triangle_mesh import TriangleMesh


def angle_defects(mesh: TriangleMesh) -> Floats:
    """2π less the angles round each vertex, (n,), radians: its Gaussian curvature, integrated.

    0 where the faces round a vertex are no single closed fan, for there is none: on a boundary, where more than two
    faces meet at an edge, where several fans meet, and on a vertex without faces.
    """
    defects = 2 * np.pi - corner_sum(mesh.angles, mesh.faces, mesh.n_vertices)
    table = mesh.edge_table
    defects[mesh.edges[table.face_counts != 2]] = 0.0
    defects[pinched_vertices(mesh.faces, table, mesh.n_vertices)] = 0.0
    defects[mesh.unreferenced_vertices] = 0.0
    return np.asarray(defects)
