"""Centroidal Voronoi cells: sites move to the means of their cells.

Lloyd: Least Squares Quantization in PCM. IEEE Trans. Inf. Theory 28(2), 1982.
"""

import numpy as np

from geomhw.geodesic.straightest import StraightestGeodesics
from geomhw.geodesic.vertex_fans import vertex_fan
from geomhw.geodesic.voronoi import voronoi_cells
from geomhw.mesh.inserted_points import insert_points
from geomhw.mesh.named_points import vertex_points
from geomhw.mesh.surface_points import SurfacePoints, concatenate
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.transport.log_map import LogarithmicMap
from geomhw.transport.surface_means import original_point


def relaxed_sites(mesh: TriangleMesh, sites: SurfacePoints, rounds: int) -> SurfacePoints:
    """Return sites after rounds of Lloyd relaxation.

    In each round a site moves along the straightest geodesic whose vector is the mean of the logarithmic map over the
    vertices of its cell, weighted by their areas. Sites stay at vertices that are not manifold, and if their cell has
    no vertex. The result lies within faces.

    Parameters
    ----------
    mesh : TriangleMesh
    sites : SurfacePoints
    rounds : number of rounds.

    Examples
    --------
    >>> from geomhw.mesh import grid, vertex_points
    >>> relaxed_sites(grid(2, 2), vertex_points(grid(2, 2), [0]), 1).positions(grid(2, 2)).round(6).tolist()
    [[0.5, 0.5, 0.0]]
    """
    areas = mesh.vertex_areas
    for _ in range(rounds):
        cells, inserted = voronoi_cells(mesh, sites), insert_points(mesh, sites)
        polar, lines = LogarithmicMap(inserted.mesh), StraightestGeodesics(inserted.mesh)
        moved = sites.split()
        for i, v in enumerate(inserted.vertices.tolist()):
            (own,) = np.nonzero(cells.label == i)
            source, fan = vertex_points(inserted.mesh, [v]), vertex_fan(lines.surface, v)
            if not len(own) or not fan.complete or fan.total == 0:
                continue
            radius = float(cells.distance[own].max()) * (1 + 1e-9)
            log = np.asarray(polar.from_source(source, radius)["log"])[own]
            known = np.isfinite(log).all(axis=1)
            if not areas[own[known]].sum() > 0:
                continue
            x, y = np.average(log[known], axis=0, weights=areas[own[known]])
            degrees = float(np.degrees(np.arctan2(y, x)))
            if fan.direction(lines.surface, degrees):
                end = lines.trace_angle(source, degrees, float(np.hypot(x, y))).end(-1)
                moved[i] = original_point(mesh, inserted, end)
        sites = concatenate(moved)
    return sites
