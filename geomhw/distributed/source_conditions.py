"""Conditions at sources on the part of a mesh that a rank has: known distances, initial heat, positions."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from geomhw.arrays import Floats, Ints
from geomhw.distributed.assembly import LocalOperators
from geomhw.distributed.components import component_labels
from geomhw.distributed.local_mesh import LocalMesh
from geomhw.distributed.poisson import solve_laplace
from geomhw.distributed.source_stars import positions, source_stars
from geomhw.geodesic.source_conditions import known_distances
from geomhw.mesh.surface_points import SurfacePoints


@dataclass(frozen=True)
class LocalSources:
    """Sources, as far as they concern a rank with k vertices and g ghosts.

    Attributes
    ----------
    vertices : rows of ``LocalMesh.vertices`` that are source vertices, own and ghosts.
    near, known : rows, own and ghosts, with a known distance, and that distance.
    corners, shares : rows, own, with a share of the impulse of points in faces, and that share.
    positions : (s, 3) coordinates of all sources, the same on all ranks.
    """

    vertices: Ints
    near: Ints
    known: Floats
    corners: Ints
    shares: Floats
    positions: Floats


def local_sources(mesh: LocalMesh, operators: LocalOperators, points: SurfacePoints) -> LocalSources:
    """Return the conditions at points with the numbers of the file, the same on all ranks."""
    at = mesh.local(mesh.find(np.unique(points.vertices)))
    if not len(points.within_faces):
        places = positions(mesh, np.unique(points.vertices))
        return LocalSources(at, at, np.zeros(len(at)), at[:0], np.empty(0), places)
    stars = source_stars(mesh, np.unique(points.corners))
    local, (rows, here) = stars.points(points), stars.own_rows(mesh)
    labels = np.zeros(len(stars.vertices), dtype=np.int64)
    labels[here] = component_labels(mesh, operators.edges)[rows]
    own = np.full(mesh.n_own, np.inf)
    own[rows] = known_distances(stars.mesh, local, np.asarray(mesh.ranks.sum(labels)))[here]
    distance = mesh.with_ghosts(own)
    near = np.flatnonzero(np.isfinite(distance))
    shares = local.within_faces.impulse(len(stars.vertices))[here]
    return LocalSources(at, near, distance[near], rows, shares, local.positions(stars.mesh))


def source_heat(
    mesh: LocalMesh, operators: LocalOperators, assemble_heat: Callable[[], sp.csr_array], sources: LocalSources
) -> Floats:
    """Return u0, (k,), integrated, as `geodesic.source_conditions.source_heat` does."""
    own = sources.vertices[sources.vertices < mesh.n_own]
    u0 = np.zeros(mesh.n_own)
    u0[own] = 1.0
    count = int(mesh.ranks.sum(len(own)))
    labels = component_labels(mesh, operators.edges)[own] if count > 1 else own
    if len(np.unique(np.concatenate(mesh.ranks.comm.allgather(labels)))) == count:
        u0[sources.corners] += sources.shares
        return u0
    # u = 1 at the source vertices, and (M + tS) u = 0 elsewhere
    A = assemble_heat()
    u = solve_laplace(mesh, A, np.zeros(mesh.n_own), (u0 > 0) | (operators.areas == 0), u0)[0]
    shares = (A @ mesh.with_ghosts(u))[own]
    u0[own] = shares * (count / mesh.ranks.sum(float(shares.sum())))
    u0[sources.corners] += sources.shares
    return u0
