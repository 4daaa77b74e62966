"""Surfaces divided and cut along curves: pieces, the arrays on them, and their topology."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.mesh.cut import cut_along_edges
from geomhw.mesh.inserted_curves import InsertedCurves, insert_curves
from geomhw.mesh.topology import linked_components
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.results import Field, Result


@dataclass(frozen=True, eq=False, repr=False)
class SplitMesh:
    """A mesh cut along edges of a divided mesh.

    Attributes
    ----------
    mesh : TriangleMesh
        The vertices of the original mesh, those inserted, then copies at the cut. The first faces have the numbers of
        the faces that they are parts of.
    original : TriangleMesh
    joined : TriangleMesh
        The divided mesh before the cut.
    original_vertices : (n',) integer array
        The vertex of ``joined`` that each vertex is a copy of.
    parents : (m',) integer array
        The face of the original mesh that each face is a part of.
    corners : (m', 3, 3) array
        Barycentric coordinates of the corners of each face in its parent.
    cut_edges : (e,) integer array
        The edges of ``joined`` along which it is cut.
    pieces : (m',) integer array
        The piece of each face: faces connected across edges, numbered by their first faces.
    """

    mesh: TriangleMesh
    original: TriangleMesh
    joined: TriangleMesh
    original_vertices: Ints
    parents: Ints
    corners: Floats
    cut_edges: Ints
    pieces: Ints

    def __repr__(self) -> str:
        return f"SplitMesh: {self.n_pieces} pieces, {self.mesh.n_faces} faces"

    @property
    def n_pieces(self) -> int:
        """Number of pieces."""
        return int(self.pieces.max()) + 1

    def carried(self, fields: Sequence[Field], levels: dict[str, float] | None = None) -> list[Field]:
        """Return arrays of the original mesh on the pieces.

        Vertex arrays are interpolated on new vertices; those of integers take the value of the nearest corner. Face
        arrays are copied.

        levels : by name of an array, its value at new vertices of the cut.
        """
        where, parent, weights = self._new_vertices
        found = []
        for field in fields:
            values = np.asarray(field.values)
            if field.location == "face":
                values = values[self.parents]
            elif field.location == "vertex":
                corners = values[self.original.faces[parent]]
                if values.dtype.kind == "f":
                    share = weights.reshape(*weights.shape, *(1,) * (values.ndim - 1))
                    # Corners without a share may be infinite.
                    parts = np.multiply(share, corners, out=np.zeros_like(corners), where=share > 0)
                    new = parts.sum(axis=1)
                else:
                    new = corners[np.arange(len(parent)), weights.argmax(axis=1)]
                if levels and field.name in levels:
                    new[np.isin(where, self.joined.edges[self.cut_edges])] = levels[field.name]
                values = np.concatenate([values, new])[self.original_vertices]
            found.append(replace(field, values=values))
        return found

    @cached_property
    def _new_vertices(self) -> tuple[Ints, Ints, Floats]:
        """Inserted vertices, ascending, with a face of the original mesh and barycentric coordinates there."""
        names, first = np.unique(self.joined.faces, return_index=True)
        new = names >= self.original.n_vertices
        face, corner = np.divmod(first[new], 3)
        return names[new], self.parents[face], self.corners[face, corner]

    def result(self, fields: Sequence[Field] = (), levels: dict[str, float] | None = None) -> Result:
        """Return the pieces as one mesh with the arrays carried over, ``piece`` and ``parent`` of each face."""
        names = [field for field in fields if field.name not in ("piece", "parent")]
        own = [
            Field("piece", "face", self.pieces.astype(np.int32)),
            Field("parent", "face", self.parents.astype(np.int32)),
        ]
        return Result(self.mesh, [*self.carried(names, levels), *own], self.report())

    def piece(self, k: int, result: Result) -> Result:
        """Return one piece as a mesh of its own, with its rows of a result of `result`."""
        at = np.flatnonzero(self.pieces == k)
        used, faces = np.unique(self.mesh.faces[at], return_inverse=True)
        rows = {"vertex": used, "face": at}
        fields = [
            replace(f, values=np.asarray(f.values)[rows[f.location]]) for f in result.fields if f.location in rows
        ]
        return Result(TriangleMesh(self.mesh.vertices[used], faces.reshape(-1, 3)), fields)

    def report(self) -> dict[str, Any]:
        """Return area and topology of each piece, and of the cut, as plain JSON values.

        The Euler characteristics of the pieces sum to that of the mesh, plus the copies of vertices, less the copies of
        edges.
        """
        vertices, edges = self.mesh.vertices, self.mesh.edge_table
        of_edge = np.empty(len(edges.vertices), dtype=np.int64)
        of_edge[edges.of_faces] = self.pieces[:, None]
        counts = np.bincount(self.pieces)
        pairs = np.unique(np.stack([np.repeat(self.pieces, 3), self.mesh.faces.ravel()], axis=1), axis=0)
        chi = np.bincount(pairs[:, 0]) - np.bincount(of_edge, minlength=len(counts)) + counts
        areas = np.bincount(self.pieces, self.mesh.face_areas)
        a, b = self.joined.edges[self.cut_edges].T
        lengths = np.linalg.norm(vertices[b] - vertices[a], axis=1)
        pieces = [
            {"piece": k, "faces": int(counts[k]), "area": float(areas[k]), "euler_characteristic": int(chi[k])}
            for k in range(len(counts))
        ]
        return {
            "pieces": pieces,
            "cut": {
                "edges": len(self.cut_edges),
                "length": float(lengths.sum()),
                "copied_vertices": self.mesh.n_vertices - self.joined.n_vertices,
                "copied_edges": self.mesh.n_edges - self.joined.n_edges,
            },
            "euler_characteristic": {"mesh": self.original.euler_characteristic, "pieces": int(chi.sum())},
        }


def split_mesh(mesh: TriangleMesh, curves: Sequence[tuple[Ints, Floats]], edges: Ints | None = None) -> SplitMesh:
    """Cut a mesh along polylines and edges.

    Parameters
    ----------
    mesh : TriangleMesh
    curves : sequence of (faces, weights), (k,) and (k, 3)
        Polylines as in `insert_curves`, such as those of `Isolines.curves`.
    edges : (e,) integer array, optional
        Indices into ``mesh.edges``.

    Raises
    ------
    FieldError
        If a point lies inside a face of zero area.

    Examples
    --------
    >>> from geomhw.curves import isolines
    >>> from geomhw.mesh import icosphere
    >>> ball = icosphere(3)
    >>> halves = split_mesh(ball, isolines(ball, ball.vertices[:, 2], [0.01]).curves)
    >>> [piece["euler_characteristic"] for piece in halves.report()["pieces"]]
    [1, 1]
    """
    found: InsertedCurves = insert_curves(mesh, curves)
    joined = found.mesh
    along = found.edges
    if edges is not None and len(edges):
        # Points on an edge divide it into a chain.
        along = np.union1d(along, _parts_of_edges(mesh, found, edges))
    cut, original = cut_along_edges(joined, along)
    table = cut.edge_table
    link, face = table.of_faces.ravel() + cut.n_faces, np.repeat(np.arange(cut.n_faces), 3)
    pieces = linked_components(face, link, cut.n_faces + cut.n_edges)[: cut.n_faces]
    cut, source = _apart(cut, pieces)
    inserted = found.inserted
    return SplitMesh(cut, mesh, joined, original[source], inserted.parents, inserted.corners, along, pieces)


def _apart(mesh: TriangleMesh, pieces: Ints) -> tuple[TriangleMesh, Ints]:
    """Give each piece a copy of the vertices that it shares with others; return the vertex of each copy, too."""
    n, size = mesh.n_vertices, int(pieces.max()) + 1
    keys, corner = np.unique(mesh.faces.astype(np.int64) * size + pieces[:, None], return_inverse=True)
    vertex = keys // size
    further = np.diff(vertex, prepend=-1) == 0
    names = np.where(further, n + np.cumsum(further) - 1, vertex)
    source = np.concatenate([np.arange(n), vertex[further]])
    return TriangleMesh(mesh.vertices[source], names[corner].reshape(-1, 3)), source


def _parts_of_edges(mesh: TriangleMesh, found: InsertedCurves, edges: Ints) -> Ints:
    """Return the edges of a divided mesh that are parts of edges of the original mesh."""
    inserted, joined = found.inserted, found.mesh
    chosen = np.zeros(mesh.n_edges, dtype=bool)
    chosen[edges] = True
    sides = []
    for k in range(3):  # parts with two corners on side k of their parent, and that side chosen
        on = (inserted.corners[:, :, k] == 0) & chosen[mesh.edge_table.of_faces[inserted.parents, k]][:, None]
        face, corner = np.nonzero((on.sum(axis=1) == 2)[:, None] & ~on)
        sides.append(np.stack([joined.faces[face, (corner + 1) % 3], joined.faces[face, (corner + 2) % 3]], axis=1))
    return np.unique(joined.edge_table.between(np.concatenate(sides)))
