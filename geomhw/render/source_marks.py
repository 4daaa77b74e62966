"""Marks of sources in a picture: discs for few, edges and crosses for many."""

from typing import Any

import numpy as np

from geomhw.arrays import Floats
from geomhw.mesh.tangent_frames import face_frames
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.render.layers import Color, Curves, Marker
from geomhw.results import Result

#: Largest numbers of sources with a label each, and with a disc each.
MOST_LABELS, MOST_DISCS = 4, 24
#: Arm of a cross, as a fraction of the diagonal of the bounding box.
ARM = 0.006


def source_marks(result: Result, color: Color, labels: bool = False) -> tuple[list[Marker], list[Curves]]:
    """Return discs for the sources in the report, or curves if they are many."""
    mesh, sources = result.mesh, result.report["sources"]
    if len(sources) > MOST_DISCS:
        return [], [Curves(_curves(mesh, sources), color)]
    labels = labels and len(sources) <= MOST_LABELS
    return [_disc(mesh, source, color, labels) for source in sources], []


def source_point(mesh: TriangleMesh, source: Any) -> Floats:
    """Return the position, (3,), of a source in a report: a vertex index or a point in a face."""
    if isinstance(source, dict):
        return np.asarray(np.array(source["barycentric"]) @ mesh.vertices[mesh.faces[source["face"]]])
    return np.asarray(mesh.vertices[source])


def _disc(mesh: TriangleMesh, source: Any, color: Color, labeled: bool) -> Marker:
    """Return the marker of a source."""
    if not isinstance(source, dict):
        return Marker(source, f"source {source}" if labeled else "", color)
    face = source["face"]
    nearest = int(mesh.faces[face][np.argmax(source["barycentric"])])
    return Marker(nearest, f"source in face {face}" if labeled else "", color, source_point(mesh, source))


def _curves(mesh: TriangleMesh, sources: list[Any]) -> Floats:
    """Return segments, (s, 2, 3): edges between sources, and crosses at sources without such an edge."""
    vertices = np.array([source for source in sources if not isinstance(source, dict)], dtype=np.int64)
    inner = np.isin(mesh.edges, mesh.boundary_vertices).all(axis=1) & (mesh.edge_table.face_counts > 1)
    # Inner edges between boundary vertices are left out: they cut corners of the boundary.
    linked = mesh.edges[np.isin(mesh.edges, vertices).all(axis=1) & ~inner]
    alone = np.setdiff1d(vertices, linked)
    faces = np.array([source["face"] for source in sources if isinstance(source, dict)], dtype=np.int64)
    within = np.array([source_point(mesh, source) for source in sources if isinstance(source, dict)]).reshape(-1, 3)
    flat = face_frames(mesh.opposite_edges[faces], mesh.face_normals[faces])
    centers = np.concatenate([mesh.vertices[alone], within])[:, None]
    arms = ARM * np.linalg.norm(np.ptp(mesh.vertices, axis=0)) * np.concatenate([mesh.tangent_frames[alone], flat])
    crosses = np.stack([centers - arms, centers + arms], axis=2).reshape(-1, 2, 3)
    return np.concatenate([mesh.vertices[linked], crosses])
