"""Marks of sources in a picture: discs for few, edges and crosses for many."""

from dataclasses import replace

import numpy as np

from geomhw.arrays import Floats
from geomhw.mesh.surface_points import SurfacePoints
from geomhw.mesh.tangent_frames import face_frames
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.render.layers import Color, Curves, Marker
from geomhw.results import Result

#: Colors of sources or starts, and of the farthest point or ends.
SOURCE_COLOR, FARTHEST_COLOR = "#c2185b", "#0b57d0"
#: Largest numbers of sources with a label each, and with a disc each.
MOST_LABELS, MOST_DISCS = 4, 24
#: Arm of a cross, as a fraction of the diagonal of the bounding box.
ARM = 0.006


def source_marks(result: Result, color: Color, labels: bool = False) -> tuple[list[Marker], list[Curves]]:
    """Return discs for the sources of a result, or curves if they are many."""
    mesh, sources = result.mesh, result.sources
    if sources is None:
        return [], []
    if len(sources.segments):
        lines = sources.positions(mesh)[sources.segments[:, :2]]
        alone = np.setdiff1d(np.arange(len(sources)), sources.segments[:, :2])
        markers, curves = source_marks(replace(result, sources=sources[alone]), color, labels)
        return markers, [Curves(lines, color), *curves]
    if len(sources) > MOST_DISCS:
        return [], [Curves(_curves(mesh, sources), color)]
    nearest = sources.corners[np.arange(len(sources)), sources.weights.argmax(axis=1)]
    markers = []
    for face, vertex, position in zip(sources.faces, nearest, sources.positions(mesh), strict=True):
        name = f"source {vertex}" if face < 0 else f"source in face {face}"
        label = name if labels and len(sources) <= MOST_LABELS else ""
        markers.append(Marker(int(vertex), label, color, None if face < 0 else position))
    return markers, []


def _curves(mesh: TriangleMesh, sources: SurfacePoints) -> Floats:
    """Return segments, (s, 2, 3): edges between sources, and crosses at sources without such an edge."""
    vertices, within = sources.vertices, sources.within_faces
    inner = np.isin(mesh.edges, mesh.boundary_vertices).all(axis=1) & (mesh.edge_table.face_counts > 1)
    # Inner edges between boundary vertices are left out: they cut corners of the boundary.
    linked = mesh.edges[np.isin(mesh.edges, vertices).all(axis=1) & ~inner]
    alone = np.setdiff1d(vertices, linked)
    flat = face_frames(mesh.opposite_edges[within.faces], mesh.face_normals[within.faces])
    centers = np.concatenate([mesh.vertices[alone], within.positions(mesh)])[:, None]
    arms = ARM * np.linalg.norm(np.ptp(mesh.vertices, axis=0)) * np.concatenate([mesh.tangent_frames[alone], flat])
    crosses = np.stack([centers - arms, centers + arms], axis=2).reshape(-1, 2, 3)
    return np.concatenate([mesh.vertices[linked], crosses])
