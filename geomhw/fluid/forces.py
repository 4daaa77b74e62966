"""Accelerations that drive a flow."""

import numpy as np

from geomhw.arrays import Floats
from geomhw.flow.tangent_fields import tangential
from geomhw.fluid.state import Force
from geomhw.mesh.triangle_mesh import TriangleMesh


def top_jet(mesh: TriangleMesh, dt: float) -> Force:
    """The handout's force, eq. 10: (0.2 h/dt)(cos 0.2πt, sin 0.2πt, 0), its tangential part, near the top.

    It acts on the faces whose center lies within a twentieth of the z-extent of the highest vertex, or, where there are
    none, on the highest.
    """
    z = mesh.vertices[np.unique(mesh.faces), 2]
    height = mesh.face_centers[:, 2]
    near_top = height >= min(z.max() - 0.05 * np.ptp(z), height.max())
    strength = 0.2 * mesh.mean_edge_length / dt

    def force(time: float) -> Floats:
        angle = 0.2 * np.pi * time
        push = strength * np.array([np.cos(angle), np.sin(angle), 0.0])
        return tangential(mesh, near_top[:, None] * push)

    return force
