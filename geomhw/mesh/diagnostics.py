"""What is wrong with a mesh, or worth knowing, for those who compute on it: each finding its places and a sentence."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from geomhw.arrays import Ints
from geomhw.mesh import geometry, topology
from geomhw.mesh.orientation import without_duplicate_faces
from geomhw.mesh.orientation_signs import one_sided_faces
from geomhw.mesh.triangle_mesh import TriangleMesh

#: How a finding is weighed: what is no clean surface; what may spoil results; what is neither good nor bad.
Kind = Literal["defect", "note", "fact"]


@dataclass(frozen=True)
class Finding:
    """One kind of place on a mesh.

    what: such places, in a few words. places: ascending, (k,) vertices or faces, or (k, 2): edges by their vertices, or
    copies with what they are copies of. consequence: what the commands make of them, a sentence.
    """

    name: str
    kind: Kind
    what: str
    places: Ints
    consequence: str


def findings(mesh: TriangleMesh) -> list[Finding]:
    """All that was found, defects first; kinds of which there is none are left out."""
    return [found for found in (*_defects(mesh), *_notes(mesh), *_facts(mesh)) if len(found.places)]


def _defects(mesh: TriangleMesh) -> list[Finding]:
    single = without_duplicate_faces(mesh)
    one_sided = one_sided_faces(single.edge_table)
    found: list[tuple[str, str, Ints, str]] = [
        (
            "zero_area_faces",
            "faces without area",
            mesh.degenerate_faces,
            "Without normal and gradient: geodesic and vecdiffuse compute with --robust, other commands refuse.",
        ),
        (
            "duplicate_faces",
            "faces with the three vertices of an earlier one, of that one",
            mesh.duplicate_faces,
            "Geodesic and vecdiffuse leave the copies out, advect and operators count them again; fluid and helmholtz "
            "refuse more than two faces at an edge.",
        ),
        (
            "isolated_vertices",
            "vertices of no face",
            mesh.unreferenced_vertices,
            "They keep their places in outputs, with distance inf, and are no sources.",
        ),
        (
            "non_manifold_edges",
            "edges of more than two faces",
            mesh.edges[mesh.edge_table.face_counts > 2],
            "Geodesic and advect pass to all of the faces, vecdiffuse by the mean of their normals; fluid, helmholtz, "
            "tracers and the intrinsic connection refuse.",
        ),
        (
            "non_manifold_vertices",
            "vertices that alone hold several fans of faces together, as in an hourglass",
            topology.pinched_vertices(mesh.faces, mesh.edge_table, mesh.n_vertices),
            "Distances and colors pass through, flow does not; the intrinsic connection refuses.",
        ),
        (
            "inconsistent_edges",
            "edges whose two faces disagree on what is up",
            _disagreeing_edges(single, one_sided),
            "Vecdiffuse, fluid and helmholtz turn the lesser part of the faces; geodesic and advect need no agreement.",
        ),
        (
            "one_sided_pieces",
            "one-sided pieces, such as a Moebius band, by their lowest face",
            _lowest(_patches(single), one_sided),
            "Geodesic, vecdiffuse and advect compute on them; fluid and helmholtz refuse.",
        ),
    ]
    return [Finding(name, "defect", what, places, consequence) for name, what, places, consequence in found]


def _notes(mesh: TriangleMesh) -> list[Finding]:
    return [
        Finding(
            "coincident_vertices",
            "note",
            "vertices in the place of an earlier one, of that one",
            _coincident(mesh),
            "Between such the surface is cut open.",
        ),
        Finding(
            "negative_edges",
            "note",
            "edges of negative cotan weight, across from angles too wide",
            _negative_edges(mesh),
            "Heat may fall below zero there, and distances come out wrong beside slivers; --robust mends it.",
        ),
    ]


def _facts(mesh: TriangleMesh) -> list[Finding]:
    loops = np.sort(np.array([loop.min() for loop in mesh.boundary_loops], dtype=np.int64))
    components = _lowest(mesh.components, np.unique(mesh.faces))
    return [
        Finding(
            "boundary_loops", "fact", "boundary loops, by their lowest vertex", loops, "Nothing flows through them."
        ),
        Finding(
            "components",
            "fact",
            "components, by their lowest vertex",
            components if len(components) > 1 else components[:0],
            "Each is on its own: without a source, distance is inf there.",
        ),
    ]


def _lowest(labels: Ints, which: Ints) -> Ints:
    """The lowest member of each label among those, ascending."""
    return np.sort(which[np.unique(labels[which], return_index=True)[1]])


def _patches(mesh: TriangleMesh) -> Ints:
    """Labels of patches: faces joined over edges with exactly two."""
    kept, turned = topology.side_labels(mesh.edge_table)
    return np.minimum(kept, turned)


def _disagreeing_edges(mesh: TriangleMesh, one_sided: Ints) -> Ints:
    """Edges of two-sided patches whose two faces run along them the same way, (k, 2)."""
    table = mesh.edge_table
    disagree = (table.face_counts == 2) & (table.orientation_sums != 0)
    disagree[table.of_faces[one_sided].ravel()] = False
    return mesh.edges[disagree]


def _coincident(mesh: TriangleMesh) -> Ints:
    """Vertices at the very place of an earlier one, and the first such, (k, 2)."""
    places = mesh.vertices + 0.0  # zeros of both signs are one place
    order = np.lexsort(places.T)  # stable: among equals the lowest comes first
    new = np.concatenate([[True], np.any(np.diff(places[order], axis=0) != 0, axis=1)])
    first = np.empty_like(order)
    first[order] = order[np.flatnonzero(new)[np.cumsum(new) - 1]]
    copies = np.flatnonzero(first != np.arange(mesh.n_vertices))
    return np.stack([copies, first[copies]], axis=1)


def _negative_edges(mesh: TriangleMesh) -> Ints:
    """Edges whose cotangents sum to less than zero beyond rounding, (k, 2); faces without area do not count."""
    dots = geometry.corner_dots(mesh.opposite_edges)
    doubled = 2 * mesh.face_areas[:, None]
    sound = np.ones_like(doubled, dtype=bool)
    sound[mesh.degenerate_faces] = False
    cotangents = np.divide(dots, doubled, out=np.zeros_like(dots), where=sound)
    table = mesh.edge_table
    total = geometry.corner_sum(cotangents, table.of_faces, mesh.n_edges)
    size = geometry.corner_sum(1 + np.abs(cotangents), table.of_faces, mesh.n_edges)
    return mesh.edges[total < -1e-12 * size]
