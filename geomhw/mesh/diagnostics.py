"""Mesh diagnostics: a summary of sizes and topology, and the places of defects."""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from geomhw.arrays import Ints
from geomhw.mesh import geometry, topology
from geomhw.mesh.orientation import without_duplicate_faces
from geomhw.mesh.orientation_signs import one_sided_faces, orientation_labels
from geomhw.mesh.repair import weld_tolerance
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.mesh.welding import distinct_points, first_nearby

#: Class of a finding: not a clean surface, possible loss of accuracy, or neutral information.
Kind = Literal["defect", "note", "fact"]
_DESCRIPTIONS: dict[str, tuple[Kind, str]] = {
    "zero_area_faces": ("defect", "faces of zero area"),
    "duplicate_faces": ("defect", "faces with the vertices of an earlier face, and that face"),
    "isolated_vertices": ("defect", "vertices of no face"),
    "non_manifold_edges": ("defect", "edges of more than two faces"),
    "non_manifold_vertices": ("defect", "vertices where several fans of faces meet, as in an hourglass"),
    "inconsistent_edges": ("defect", "edges whose two faces disagree in orientation"),
    "one_sided_pieces": ("defect", "one-sided parts, such as a Moebius band, by their lowest face"),
    "coincident_vertices": ("note", "vertices at the position of an earlier vertex, and that vertex"),
    "nearly_coincident_vertices": ("note", "vertices nearly at the position of an earlier vertex, and that vertex"),
    "negative_edges": ("note", "edges of negative cotan weight, opposite wide angles"),
    "boundary_loops": ("fact", "boundary loops, by their lowest vertex"),
    "components": ("fact", "components, by their lowest vertex"),
}


@dataclass(frozen=True)
class Finding:
    """A kind of defect or property of a mesh, and where it occurs.

    Attributes
    ----------
    name : str
        Identifier, such as ``non_manifold_edges``.
    kind : {"defect", "note", "fact"}
    what : str
        Description of the places, in a few words.
    places : (k,) or (k, 2) integer array, ascending
        Vertices or faces; or pairs: edges by their vertices, or duplicates with their originals.
    """

    name: str
    kind: Kind
    what: str
    places: Ints


def findings(mesh: TriangleMesh) -> list[Finding]:
    """Search a mesh for defects, possible sources of error, and facts about its topology.

    Returns
    -------
    list of Finding
        Defects first, then notes, then facts; kinds that do not occur are left out.

    Examples
    --------
    >>> from geomhw.mesh import grid
    >>> [(found.name, found.kind, found.places.tolist()) for found in findings(grid(2, 2))]
    [('boundary_loops', 'fact', [0])]
    """
    single = without_duplicate_faces(mesh)
    one_sided = one_sided_faces(single.edge_table)
    patches = np.minimum(*orientation_labels(single.edge_table))
    components = _lowest(mesh.components, np.unique(mesh.faces))
    places = {
        "zero_area_faces": mesh.degenerate_faces,
        "duplicate_faces": mesh.duplicate_faces,
        "isolated_vertices": mesh.unreferenced_vertices,
        "non_manifold_edges": mesh.edges[mesh.edge_table.face_counts > 2],
        "non_manifold_vertices": topology.pinched_vertices(mesh.faces, mesh.edge_table),
        "inconsistent_edges": _inconsistent_edges(single, one_sided),
        "one_sided_pieces": _lowest(patches, one_sided),
        "coincident_vertices": _coincident(mesh),
        "nearly_coincident_vertices": _nearly_coincident(mesh),
        "negative_edges": _negative_edges(mesh),
        "boundary_loops": np.sort(np.array([loop.min() for loop in mesh.boundary_loops], dtype=np.int64)),
        "components": components if len(components) > 1 else components[:0],
    }
    return [Finding(name, *_DESCRIPTIONS[name], where) for name, where in places.items() if len(where)]


def mesh_summary(mesh: TriangleMesh) -> dict[str, Any]:
    """Summarize sizes, topology, defects and extent of a mesh as plain JSON values.

    Returns
    -------
    dict
        Counts; ``genus`` (None if undefined), ``oriented``, ``edge_manifold``; ``mean_edge_length``, ``area`` and
        ``bounds`` ([lowest, highest] corner of the bounding box) in the units of the mesh.

    Examples
    --------
    >>> from geomhw.mesh import torus
    >>> summary = mesh_summary(torus(24, 12))
    >>> summary["vertices"], summary["genus"]
    (288, 1)
    """
    return {
        "vertices": mesh.n_vertices,
        "faces": mesh.n_faces,
        "edges": mesh.n_edges,
        "components": mesh.n_components,
        "boundary_loops": len(mesh.boundary_loops),
        "euler_characteristic": mesh.euler_characteristic,
        "genus": mesh.genus,
        "oriented": mesh.is_oriented,
        "edge_manifold": mesh.is_edge_manifold,
        "unreferenced_vertices": len(mesh.unreferenced_vertices),
        "zero_area_faces": len(mesh.degenerate_faces),
        "mean_edge_length": mesh.mean_edge_length,
        "area": float(mesh.face_areas.sum()),
        "bounds": [mesh.vertices.min(axis=0).tolist(), mesh.vertices.max(axis=0).tolist()],
    }


def _lowest(labels: Ints, which: Ints) -> Ints:
    """Return the lowest member of each label among ``which``, ascending."""
    return np.sort(which[np.unique(labels[which], return_index=True)[1]])


def _inconsistent_edges(mesh: TriangleMesh, one_sided: Ints) -> Ints:
    """Return the edges, (k, 2), whose two faces run along them in the same sense, outside one-sided patches."""
    table = mesh.edge_table
    disagree = (table.face_counts == 2) & (table.orientation_sums != 0)
    disagree[table.of_faces[one_sided].ravel()] = False
    return mesh.edges[disagree]


def _coincident(mesh: TriangleMesh) -> Ints:
    """Return vertices at exactly the position of an earlier vertex, and the first such vertex, (k, 2)."""
    first, inverse = distinct_points(mesh.vertices)
    copies = np.flatnonzero(first[inverse] != np.arange(mesh.n_vertices))
    return np.stack([copies, first[inverse[copies]]], axis=1)


def _nearly_coincident(mesh: TriangleMesh) -> Ints:
    """Return vertices close to an earlier vertex but not at its position or of one face with it, and that, (k, 2)."""
    used = np.unique(mesh.faces)
    used = used[distinct_points(mesh.vertices[used])[0]]
    first = used[first_nearby(mesh.vertices[used], weld_tolerance(mesh))]
    pairs = np.stack([used, first], axis=1)[first != used]
    joined = mesh.edges[:, 0].astype(np.int64) * mesh.n_vertices + mesh.edges[:, 1]
    return pairs[~np.isin(pairs.min(axis=1) * mesh.n_vertices + pairs.max(axis=1), joined)]


def _negative_edges(mesh: TriangleMesh) -> Ints:
    """Return the edges, (k, 2), whose cotangents sum to less than zero beyond rounding; zero-area faces are ignored."""
    dots = geometry.corner_dots(mesh.opposite_edges)
    doubled = 2 * mesh.face_areas[:, None]
    sound = np.ones_like(doubled, dtype=bool)
    sound[mesh.degenerate_faces] = False
    cotangents = np.divide(dots, doubled, out=np.zeros_like(dots), where=sound)
    table = mesh.edge_table
    total = geometry.corner_sum(cotangents, table.of_faces, mesh.n_edges)
    size = geometry.corner_sum(1 + np.abs(cotangents), table.of_faces, mesh.n_edges)
    return mesh.edges[total < -1e-12 * size]
