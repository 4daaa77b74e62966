"""Spread five points over a surface: each is the vertex farthest from those before."""

from pathlib import Path

import geomhw

mesh = geomhw.read_mesh(Path(__file__).parents[2] / "data" / "creature.obj")
heat = geomhw.HeatDistance(mesh, refine=True)  # factors here, answers quickly below

points = [int(mesh.vertices[:, 1].argmax())]
while len(points) < 5:
    found = heat.from_vertices(points)
    far = found.report["farthest"]
    print(f"vertex {far['vertex']} is {far['distance']:.3f} from {points}")
    points.append(far["vertex"])

geomhw.write(heat.from_vertices(points), "points.vtp")
print("distance from all five is in points.vtp")
