"""Compute the Lie bracket of two fields as a commutator of matrices [OATVF].

Rotations about x and y have the rotation about z as their bracket: on the sphere, [D_x, D_y] = -D_z.
"""

import numpy as np

from geomhw.flow import rigid_field
from geomhw.mesh import icosphere
from geomhw.operators import DirectionalDerivative, lumped_mass

for level in (3, 4, 5):
    mesh = icosphere(level)
    derivative = DirectionalDerivative(mesh)
    X, Y, Z = (derivative(rigid_field(mesh, axis)) for axis in np.eye(3))  # sparse, n x n
    bracket = X @ Y - Y @ X

    f = mesh.vertices[:, 0] * mesh.vertices[:, 1] + mesh.vertices[:, 2]
    M = lumped_mass(mesh)
    error = bracket @ f + Z @ f
    print(f"{mesh.n_vertices:6,} vertices: {np.sqrt((error @ M @ error) / (Z @ f @ M @ (Z @ f))):.2%} off")
