"""Let two equal vortices on a sphere turn around each other; the flow conserves energy to the last digits."""

import numpy as np

from geomhw.fluid import Diagnostics, scheme_of
from geomhw.mesh import icosphere

mesh = icosphere(4)
scheme = scheme_of(mesh, "conservative")
centers = np.array([[0.3, 0.0, 0.95], [-0.3, 0.0, 0.95]])
w = sum(np.exp(-40 * ((mesh.vertices - center) ** 2).sum(axis=1)) for center in centers)

state = scheme.from_vorticity(w, color=mesh.vertices[:, 2])
diagnostics, dt = Diagnostics(scheme), 0.25
before = diagnostics(state, dt)["energy"]
for step in range(1, 121):
    state = scheme.step(state, dt)
    if step % 30 == 0:
        x, y, _ = mesh.vertices[scheme.vorticity(state).argmax()]
        print(f"time {state.time:5.2f}: a vortex at {np.degrees(np.arctan2(y, x)) % 180:5.1f}° or opposite")
print(f"energy changed by {abs(diagnostics(state, dt)['energy'] / before - 1):.0e}")
