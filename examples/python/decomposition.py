"""Decompose a wind on a torus into a slope (curl-free), a swirl (coexact) and a flow around the hole (harmonic)."""

from pathlib import Path

import numpy as np

import geomhw
from geomhw.operators import gradient

mesh = geomhw.read_mesh(Path(__file__).parents[2] / "data" / "torus.off")
x, y, z = mesh.vertices.T

slope = (gradient(mesh) @ (x * y)).reshape(-1, 3)
swirl = np.cross(mesh.face_normals, (gradient(mesh) @ np.cos(3 * z)).reshape(-1, 3))
around = np.cross([0.0, 0.0, 1.0], mesh.face_centers) / (mesh.face_centers[:, :2] ** 2).sum(axis=1)[:, None]

parts = geomhw.HelmholtzDecomposition(mesh)(slope + 2 * swirl + around)
for name in ("curl_free", "coexact", "harmonic"):
    print(f"{name:>10}: {parts.report['energy_shares'][name]:6.1%} of the energy")
found = parts["curl_free"]
print(f"the slope is recovered to {np.linalg.norm(found - slope) / np.linalg.norm(slope):.0e}")
geomhw.write(parts, "parts.vtp")
