"""Gaussian curvature at vertices: angle defects."""

import numpy as np

from geomhw.arrays import Floats
from geomhw.mesh.geometry import corner_sum
from geomhw.mesh.topology import pinched_vertices
from geomhw.mesh.triangle_mesh import TriangleMesh


def angle_defects(mesh: TriangleMesh) -> Floats:
    """Compute the angle defect 2π - Σθ of each vertex, its integrated Gaussian curvature.

    Returns
    -------
    (n,) array, radians
        0 at vertices without a single closed fan of faces: on the boundary, at edges of more than two faces, at pinched
        vertices and at unreferenced vertices.

    Examples
    --------
    >>> from geomhw.mesh import icosphere
    >>> defects = angle_defects(icosphere(2))
    >>> bool(np.isclose(defects.sum(), 4 * np.pi))  # Gauss-Bonnet: 2π χ
    True
    """
    defects = 2 * np.pi - corner_sum(mesh.angles, mesh.faces, mesh.n_vertices)
    table = mesh.edge_table
    defects[mesh.edges[table.face_counts != 2]] = 0.0
    defects[pinched_vertices(mesh.faces, table)] = 0.0
    defects[mesh.unreferenced_vertices] = 0.0
    return np.asarray(defects)
