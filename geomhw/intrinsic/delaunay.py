"""Intrinsic Delaunay triangulation: the same surface and vertices, with edges whose cotan weights are not negative.

Fisher, Springborn, Bobenko, Schröder: An Algorithm for the Construction of Intrinsic Delaunay Triangulations with
Applications to Digital Geometry Processing. Computing 81, 2007.
"""

from dataclasses import replace

import numpy as np

from geomhw.arrays import Floats, Ints, frozen
from geomhw.errors import ConvergenceError
from geomhw.intrinsic.intrinsic_mesh import IntrinsicMesh
from geomhw.mesh import geometry
from geomhw.mesh.topology import Edges

#: An edge is flipped where cot α + cot β is below minus this share of what each can be: rounding alone flips none.
TOLERANCE = 1e-13
#: Far more rounds than any mesh should need: a flat grid of 100 x 100 cells sheared by 100 takes two hundred.
MAX_ROUNDS = 100_000


class DelaunayFlips:
    """Flips edges of a closed oriented surface, by length alone, until all are Delaunay.

    Edges keep their numbers; the one that is flipped joins other vertices from then on. Halfedge 3f+k is the side of
    face f opposite its corner k. It knows its ``corner``, its ``edge``, and on which of the ``sides`` of that edge it
    is; no two edges are ever told apart by the vertices at their ends.

    flips, rounds: how often an edge was flipped, and in how many sets of independent ones. ConvergenceError if that
    does not come to an end.
    """

    def __init__(self, surface: IntrinsicMesh) -> None:
        assert surface.is_closed
        assert surface.is_edge_manifold
        assert surface.is_oriented
        self._start = surface
        self._corner, self._edge = surface.faces.ravel().copy(), surface.gluing.of_faces.ravel().copy()
        self._length, self._ends = surface.lengths.copy(), surface.edges.copy()
        self._sides = np.argsort(self._edge, kind="stable").reshape(-1, 2)
        self._side = np.zeros(len(self._edge), dtype=np.int8)
        self._side[self._sides[:, 1]] = 1
        # Ranks by lot: where each edge is in conflict with its neighbors, a good share still goes in one round.
        self._rank = np.random.default_rng(0).permutation(surface.n_edges)
        self._least = np.full(surface.n_faces, surface.n_edges)
        self.flips, self.rounds = 0, 0
        self._run()

    @property
    def surface(self) -> IntrinsicMesh:
        """The surface as triangulated now."""
        before = self._start.gluing
        of_faces = frozen(self._edge.reshape(-1, 3))
        gluing = Edges(frozen(self._ends), of_faces, before.face_counts, before.orientation_sums)
        faces = frozen(self._corner.reshape(-1, 3))
        return replace(self._start, faces=faces, gluing=gluing, lengths=frozen(self._length))

    def _run(self) -> None:
        suspect = np.zeros(len(self._length), dtype=bool)
        waiting = self._not_delaunay(np.arange(len(self._length)))
        while len(waiting):
            if self.rounds == MAX_ROUNDS:
                raise ConvergenceError(
                    f"edge flips do not come to an end: {len(waiting)} edges still change after {MAX_ROUNDS} rounds, "
                    f"one beside vertex {self._ends[waiting[0], 0]}; clean the mesh there"
                )
            chosen = self._independent(waiting)
            suspect[waiting] = True
            suspect[self._flip(chosen)] = True
            waiting = self._not_delaunay(np.flatnonzero(suspect))
            suspect[:] = False
            self.flips, self.rounds = self.flips + len(chosen), self.rounds + 1

    def _not_delaunay(self, edges: Ints) -> Ints:
        """Those of the edges whose opposite angles sum to more than π. An edge within one face never is one."""
        total, size = np.zeros(len(edges)), np.zeros(len(edges))
        for halfedge in self._sides[edges].T:
            a, b, c = (self._length[self._edge[_onward(halfedge, k)]] for k in range(3))
            four_areas = 4 * geometry.heron_areas(np.stack([a, b, c], axis=1))
            total += ((b - a) * (b + a) + c * c) / four_areas  # cot α, by the law of cosines
            size += np.maximum(a, np.maximum(b, c)) ** 2 / four_areas
        return edges[total < -TOLERANCE * size]

    def _independent(self, edges: Ints) -> Ints:
        """Of the edges, those of lowest rank in both their faces: no face has two of them."""
        faces, rank = self._sides[edges] // 3, self._rank[edges, None]
        np.minimum.at(self._least, faces, rank)
        chosen = (self._least[faces] == rank).all(axis=1)
        self._least[faces] = len(self._rank)
        return edges[chosen]

    def _flip(self, edges: Ints) -> Ints:
        """Give each edge the other diagonal of its two faces, which it shares with no other; the edges round these.

        Across the edge ab, the faces cab and dba become cad and dbc.
        """
        c, d = self._sides[edges].T
        ca, bc, db, ad = _onward(c, 2), _onward(c, 1), _onward(d, 2), _onward(d, 1)
        self._length[edges] = self._diagonal(edges, ca, bc, ad, db)
        at_a, at_b, at_c, at_d = self._corner[bc], self._corner[ca], self._corner[c], self._corner[d]
        self._ends[edges] = np.sort(np.stack([at_c, at_d], axis=1), axis=1)
        f, g = c - c % 3, d - d % 3
        for place, vertex in ((f, at_c), (f + 1, at_a), (f + 2, at_d), (g, at_d), (g + 1, at_b), (g + 2, at_c)):
            self._corner[place] = vertex
        old, new = np.stack([ad, ca, bc, db]), np.stack([f, f + 2, g, g + 2])
        around, sides = self._edge[old], self._side[old]
        self._place(around, sides, new)
        self._place(edges, 0, f + 1)
        self._place(edges, 1, g + 1)
        return around.ravel()

    def _place(self, edges: Ints, side: Ints | int, halfedges: Ints) -> None:
        """Put that side of the edges at those halfedges."""
        self._edge[halfedges], self._side[halfedges], self._sides[edges, side] = edges, side, halfedges

    def _diagonal(self, ab: Ints, ca: Ints, bc: Ints, ad: Ints, db: Ints) -> Floats:
        """Length from c to d with both faces laid out in a plane, the edge ab on the x axis."""
        base = self._length[ab]
        left, right, lower_left, lower_right = (self._length[self._edge[side]] for side in (ca, bc, ad, db))
        x, y = geometry.apex(base, left, right)
        lower_x, lower_y = geometry.apex(base, lower_left, lower_right)
        return np.asarray(np.hypot(x - lower_x, y + lower_y))


def _onward(halfedges: Ints, corners: int) -> Ints:
    """The halfedges that many corners on in the same faces."""
    return halfedges - halfedges % 3 + (halfedges + corners) % 3
