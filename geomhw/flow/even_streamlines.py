"""Evenly spaced streamlines of a face field."""

from math import isfinite
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import dijkstra

from geomhw.arrays import Floats, Ints
from geomhw.errors import ArgumentError
from geomhw.flow.flat_faces import flat_faces
from geomhw.flow.nearby_lines import LineStore
from geomhw.flow.search_windows import search_room
from geomhw.flow.streamline_growth import FULL, Growth
from geomhw.flow.streamline_polylines import Streamlines
from geomhw.flow.streamline_seeds import Lines, neighbor_distances, seed_at, spread_lines
from geomhw.flow.streamlines import StreamlineTracer
from geomhw.mesh.triangle_mesh import TriangleMesh

#: Streamlines side by side on a square of the area of the mesh, at most.
MOST = 3000
#: Speeds below this share of the largest are zero.
SLOW = 1e-12
#: Numbers by which first seeds are ordered are equal within this share.
EQUAL = 1e-6


def default_spacing(mesh: TriangleMesh, count: int) -> float:
    """Return the spacing of a number of streamlines side by side on a square of the area of the mesh."""
    return float(np.sqrt(mesh.face_areas.sum()) / count)


def even_streamlines(mesh: TriangleMesh, velocity: Floats, spacing: float) -> Streamlines:
    """Trace evenly spaced streamlines of a face field over the whole surface.

    A streamline starts at the spacing from existing ones, on a straight line perpendicular to one or from the end of
    one, as long as there is such a place. It ends where it closes, at the boundary, at a critical point, or where it
    comes nearer to another one or to itself than 0.6 of the spacing. All distances are exact distances on the surface.

    Parameters
    ----------
    mesh : edge-manifold, oriented or not, with or without boundary.
    velocity : (m, 3) array; its normal part is ignored.
    spacing : distance of neighboring streamlines.

    Returns
    -------
    Streamlines; none if the field is zero.

    Raises
    ------
    ArgumentError
        If the spacing is not finite, or gives more than `MOST` streamlines side by side.
    FieldError
        If the velocity is not a finite face field.
    MeshError
        If an edge has more than two faces, or a face has zero area.

    References
    ----------
    Jobard, Lefer: Creating Evenly-Spaced Streamlines of Arbitrary Density. Visualization in Scientific Computing, 1997.

    Examples
    --------
    >>> from geomhw.mesh import icosphere
    >>> from geomhw.flow import rotation_field
    >>> mesh = icosphere(3)
    >>> lines = even_streamlines(mesh, rotation_field(mesh, [0, 0, 1]), 0.3)
    >>> len(lines) > 8
    True
    """
    if not (spacing > 0 and isfinite(spacing)):
        raise ArgumentError(f"the spacing of streamlines is positive and finite, not {spacing}")
    if spacing < (least := default_spacing(mesh, MOST)):
        raise ArgumentError(f"a spacing of {spacing:g} is too small for this mesh; the smallest is {least:.6g}")
    return _Placement(mesh, velocity, spacing).run()


class _Placement:
    """Streamlines that are being placed, in arrays that grow."""

    def __init__(self, mesh: TriangleMesh, velocity: Floats, spacing: float) -> None:
        tracer = StreamlineTracer(mesh)
        forward = tracer.flow(velocity)
        self.mesh, self.spacing = mesh, spacing
        self.speed = np.linalg.norm(forward.V, axis=1)
        self.slow = SLOW * float(self.speed.max(initial=0.0))
        self.growth = Growth(
            forward,
            forward._replace(V=-forward.V, rates=-forward.rates),
            flat_faces(mesh),
            search_room(mesh),
            self.slow,
        )
        self.store, self.lines, self.count = _empty_store(mesh, 1 << 12), Lines(*np.empty((5, 64), dtype=np.int64)), 0

    def run(self) -> Streamlines:
        """Place streamlines until no place is left."""
        tried = self.speed <= self.slow
        order = _first_seeds(self.mesh, self.growth.forward.V, self.speed)
        parent = segment = 0
        while True:
            open_faces = order[~(tried | self._covered())[order]]
            before = self.count
            for face in open_faces.tolist():
                tried[face] = True
                self._seed(face)
                if self.count > before:
                    break
            else:
                return self._result()
            room = False
            while not room:
                self.count, parent, segment, room = spread_lines(
                    self.growth, self.store, self.lines, self.count, parent, segment, self.spacing
                )
                if not room:
                    self._grow_arrays()

    def _seed(self, face: int) -> None:
        """Add the streamline through the center of a face, if it is far from others and long."""
        while True:
            b = np.full(3, 1 / 3)
            found = seed_at(self.growth, self.store, self.lines, self.count, face, b, self.spacing)
            if found != FULL:
                self.count = found
                return
            self._grow_arrays()

    def _grow_arrays(self) -> None:
        """Double the room."""
        doubled = {name: _doubled(a) for name, a in self.store._asdict().items() if name != "first"}
        self.store = self.store._replace(**doubled)
        self.lines = Lines(*map(_doubled, self.lines))

    def _covered(self) -> Floats:
        """Whether the corners of each face are nearer than the spacing to a streamline, along edges, (m,)."""
        mesh, n = self.mesh, self.mesh.n_vertices
        if not self.count:
            return np.zeros(mesh.n_faces, dtype=bool)
        used = slice(0, int(self.lines.ends[self.count - 1]))
        corner = mesh.vertices[mesh.faces[self.store.faces[used]]]
        place = np.einsum("sk,skx->sx", self.store.begins[used], corner)
        start = np.full(n, np.inf)
        np.minimum.at(start, mesh.faces[self.store.faces[used]], np.linalg.norm(corner - place[:, None], axis=2))
        near = np.flatnonzero(np.isfinite(start))
        lengths = np.concatenate([mesh.edge_lengths, start[near] + np.finfo(float).tiny])
        rows = np.concatenate([mesh.edges[:, 0], np.full(len(near), n)])
        columns = np.concatenate([mesh.edges[:, 1], near])
        graph = sp.csr_array((lengths, (rows, columns)), shape=(n + 1, n + 1))
        distance = dijkstra(graph, directed=False, indices=n, limit=self.spacing)[:n]
        return np.asarray((distance[mesh.faces] < self.spacing).all(axis=1))

    def _result(self) -> Streamlines:
        """Join the segments to streamlines, upstream halves reversed."""
        count, store, lines = self.count, self.store, self.lines
        used = int(lines.ends[count - 1]) if count else 0
        number, s = store.lines[:used], np.arange(used)
        order = np.lexsort((np.where(s < lines.middles[number], s, -s), number))
        sizes = np.bincount(number, minlength=count)
        offsets = np.concatenate([[0], np.cumsum(sizes + 1)])
        last, end = offsets[1:] - 1, order[np.cumsum(sizes) - 1]
        inner = np.setdiff1d(np.arange(used + count), last)

        def joined(at_begin: Any, at_end: Any) -> Any:
            values = np.empty((used + count, *at_begin.shape[1:]), dtype=at_begin.dtype)
            values[inner], values[last] = at_begin[order], at_end[end]
            return values

        arc, elapsed = joined(store.low, store.high), np.zeros(used + count)
        elapsed[inner + 1] = store.times[order]
        elapsed = np.cumsum(elapsed)
        start = np.repeat(offsets[:-1], sizes + 1)
        faces, weights = joined(store.faces, store.faces), joined(store.begins, store.ends)
        kept = (weights == 0).any(axis=1)  # points within faces are ends, or places where a streamline was continued
        kept[offsets[:-1]] = kept[last] = True
        return Streamlines(
            self.mesh,
            self.spacing,
            faces[kept],
            weights[kept],
            np.concatenate([[0], np.cumsum(kept)[last]]),
            (arc - arc[start])[kept],
            (elapsed - elapsed[start])[kept],
            self.speed[faces][kept],
            joined(store.slides, store.slides)[kept],
            np.stack([lines.upstream[:count], lines.downstream[:count]], axis=1),
            neighbor_distances(self.growth, store, lines, used, self.spacing),
        )


def _empty_store(mesh: TriangleMesh, room: int) -> LineStore:
    """Return room for segments."""
    faces, lines, after = np.empty((3, room), dtype=np.int64)
    begins, ends = np.empty((2, room, 3))
    low, high, times = np.empty((3, room))
    slides, first = np.empty(room, dtype=np.int32), np.full(mesh.n_faces, -1)
    return LineStore(faces, lines, begins, ends, low, high, times, slides, after, first)


def _doubled(array: Any) -> Any:
    """Return an array with as much room again."""
    return np.concatenate([array, np.empty_like(array)])


def _first_seeds(mesh: TriangleMesh, V: Floats, speed: Floats) -> Ints:
    """Order faces by speed, then by distance from the centroid, then along the mean velocity and circulation.

    The order does not depend on scale, position, direction and numbering of the mesh, up to its symmetries.
    """
    x = mesh.face_centers - np.average(mesh.face_centers, axis=0, weights=mesh.face_areas)
    size = np.linalg.norm(x, axis=1)
    mean, circulation = mesh.face_areas @ V, mesh.face_areas @ np.cross(x, V)
    # Each key with a bound of its values; sums far below the bound are rounding.
    keys = [
        (-speed, float(speed.max(initial=0.0))),
        (-size, float(size.max())),
        (-(x @ mean), float(size.max() * (mesh.face_areas @ speed))),
        (-(x @ circulation), float(size.max() * (mesh.face_areas @ (speed * size)))),
    ]
    rounded = [np.round(key / (EQUAL * bound)) if bound > 0 else key for key, bound in keys]
    return np.lexsort(rounded[::-1])
