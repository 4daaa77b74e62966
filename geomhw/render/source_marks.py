"""Sources in a picture: a few as discs, many as curves along the mesh, with crosses where one stands alone."""

from typing import Any

import numpy as np

from geomhw.arrays import Floats
from geomhw.mesh.tangent_frames import face_frames
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.render.layers import Color, Curves, Marker
from geomhw.results import Result

#: More sources than this are marked without a label each; more than that by curves.
MOST_LABELS, MOST_DISCS = 4, 24
#: Arm of a cross, a share of the mesh's diagonal.
ARM = 0.006


def source_marks(result: Result, color: Color, labels: bool = False) -> tuple[list[Marker], list[Curves]]:
    """Discs for the sources that the report names, or, where they are many, curves."""
    mesh, sources = result.mesh, result.report["sources"]
    if len(sources) > MOST_DISCS:
        return [], [Curves(_curves(mesh, sources), color)]
    labels = labels and len(sources) <= MOST_LABELS
    return [_disc(mesh, source, color, labels) for source in sources], []


def source_point(mesh: TriangleMesh, source: Any) -> Floats:
    """Where a source of a report is, (3,): a vertex by its index, or a point within a face."""
    if isinstance(source, dict):
        return np.asarray(np.array(source["barycentric"]) @ mesh.vertices[mesh.faces[source["face"]]])
    return np.asarray(mesh.vertices[source])


def _disc(mesh: TriangleMesh, source: Any, color: Color, labeled: bool) -> Marker:
    if not isinstance(source, dict):
        return Marker(source, f"source {source}" if labeled else "", color)
    face = source["face"]
    nearest = int(mesh.faces[face][np.argmax(source["barycentric"])])
    return Marker(nearest, f"source in face {face}" if labeled else "", color, source_point(mesh, source))


def _curves(mesh: TriangleMesh, sources: list[Any]) -> Floats:
    """Segments, (s, 2, 3): edges between sources, and crosses on those that have none."""
    vertices = np.array([source for source in sources if not isinstance(source, dict)], dtype=np.int64)
    inner = np.isin(mesh.edges, mesh.boundary_vertices).all(axis=1) & (mesh.edge_table.face_counts > 1)
    # Along a boundary, not across the corner that two of its edges make.
    linked = mesh.edges[np.isin(mesh.edges, vertices).all(axis=1) & ~inner]
    alone = np.setdiff1d(vertices, linked)
    faces = np.array([source["face"] for source in sources if isinstance(source, dict)], dtype=np.int64)
    within = np.array([source_point(mesh, source) for source in sources if isinstance(source, dict)]).reshape(-1, 3)
    flat = face_frames(mesh.opposite_edges[faces], mesh.face_normals[faces])
    centers = np.concatenate([mesh.vertices[alone], within])[:, None]
    arms = ARM * np.linalg.norm(np.ptp(mesh.vertices, axis=0)) * np.concatenate([mesh.tangent_frames[alone], flat])
    crosses = np.stack([centers - arms, centers + arms], axis=2).reshape(-1, 2, 3)
    return np.concatenate([mesh.vertices[linked], crosses])
