"""A user's program: distances from three sources, operators as matrices, ten fluid steps, a picture."""

import geomhw
from geomhw.fluid import Plan, run
from geomhw.io import write_png
from geomhw.mesh import icosphere
from geomhw.operators import lumped_mass, stiffness
from geomhw.render import geodesic_picture

mesh = icosphere(3)
result = geomhw.HeatDistance(mesh, "h2").from_vertices([0, 5, 9])
S, M = stiffness(mesh), lumped_mass(mesh)
scheme = geomhw.scheme_of(mesh, "conservative")
start = scheme.from_vorticity(2 * mesh.vertices[:, 2], color=mesh.vertices[:, 0])
*_, last = run(scheme, start, Plan(dt=0.01, steps=10))
print(float(result["distance"].max()), S.shape, M.shape, last.state.time)
write_png("distance.png", geodesic_picture(result))
