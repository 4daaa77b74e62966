"""Transport a vector around an eighth of the sphere: it returns turned by the enclosed area, a quarter turn."""

import numpy as np

from geomhw.mesh import icosphere
from geomhw.transport import VectorHeat

mesh = icosphere(4)
transport = VectorHeat(mesh, connection="intrinsic")
corners = [int((mesh.vertices @ axis).argmax()) for axis in np.eye(3)]

start = vector = np.array([0.0, 1.0, 0.0])  # at (1, 0, 0), towards (0, 1, 0)
for here, there in zip(corners, corners[1:] + corners[:1], strict=True):
    vector = transport.from_vertices([here], [vector])["transported"][there]
    print(f"at {np.round(mesh.vertices[there], 3) + 0.0}: {np.round(vector, 3) + 0.0}")

turn = np.degrees(np.arctan2(vector @ [0.0, 0.0, 1.0], vector @ start))
print(f"turned by {turn:.2f}°; area 4π/8 in degrees: {np.degrees(4 * np.pi / 8):.2f}°")
