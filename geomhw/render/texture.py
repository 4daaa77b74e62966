"""Texture of a surface along vectors: line integral convolution on the cells of its faces."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Floats, Ints
from geomhw.errors import GeomhwError, RenderError
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.render.colors import Shades
from geomhw.render.flow_lines import face_field
from geomhw.render.layers import Arrows, Surface, Theme

#: Size of a cell, in pixels of a panel of 600, and cells at most.
CELL, MOST_CELLS = 1.6, 3_000_000
#: Brightness of the mean, and its change over a standard deviation of the texture.
MEAN, CONTRAST = 0.86, 0.2


@dataclass(frozen=True)
class Cells:
    """Faces divided into lattices of triangles, each with a brightness.

    counts: (m,), cells along each side. brightness: (k,), of the cells of all faces.
    """

    counts: Ints
    brightness: Floats

    def refined(self, faces: Ints, points: Floats, normals: Floats) -> tuple[Floats, Floats, Ints]:
        """Return points and normals of the lattices of faces, and the triangles of the cells in their order."""
        places, directions, triangles, order, first = [], [], [], [], 0
        for n in np.unique(self.counts).tolist():
            which = np.flatnonzero(self.counts == n)
            weights, cells = _lattice(n)
            corners = faces[which]
            places.append(np.einsum("pc,fcx->fpx", weights, points[corners]).reshape(-1, 3))
            directions.append(np.einsum("pc,fcx->fpx", weights, normals[corners]).reshape(-1, 3))
            shift = first + len(weights) * np.arange(len(which))
            triangles.append((shift[:, None, None] + cells).reshape(-1, 3))
            order.append((self._starts[which][:, None] + np.arange(n * n)).ravel())
            first += len(weights) * len(which)
        sorted_triangles = np.empty((len(self.brightness), 3), dtype=np.int32)
        sorted_triangles[np.concatenate(order)] = np.concatenate(triangles)
        return np.concatenate(places), np.concatenate(directions), sorted_triangles

    def colors(
        self, surface: Surface, shades: Shades | None, faces: Ints, origin: Ints, theme: Theme
    ) -> NDArray[np.uint8]:
        """Return the color of each cell, (k, 3): that of the surface, with the brightness of the texture."""
        base: NDArray[Any]
        if shades is None:
            base = np.tile(_rgb(surface.color), (len(self.brightness), 1))
        else:
            per_corner = shades.values if shades.per_face else shades.values[origin[faces]]
            values = np.repeat(per_corner, self.counts**2, axis=0) if shades.per_face else self._centers(per_corner)
            known = shades.known if shades.per_face else shades.known[origin[faces]].all(axis=1)
            base = values if shades.rgb else shades.table[np.round(values * (len(shades.table) - 1)).astype(int), :3]
            base = np.where(np.repeat(known, self.counts**2)[:, None], base, _rgb(theme.unknown))
        return np.clip(base * self.brightness[:, None], 0, 255).astype(np.uint8)

    @property
    def _starts(self) -> Ints:
        """The first cell of each face, (m,)."""
        return np.asarray(np.cumsum(self.counts**2) - self.counts**2)

    def _centers(self, values: Floats) -> Floats:
        """Return values at the centers of cells, (k, ...), of values at corners, (m, 3, ...)."""
        found = np.empty((len(self.brightness), *values.shape[2:]))
        for n in np.unique(self.counts).tolist():
            which = np.flatnonzero(self.counts == n)
            weights, cells = _lattice(n)
            at = (self._starts[which][:, None] + np.arange(n * n)).ravel()
            inner = np.einsum("pc,fc...->fp...", weights[cells].mean(axis=1), values[which])
            found[at] = inner.reshape(-1, *values.shape[2:])
        return found


def cells(mesh: TriangleMesh, arrows: Arrows, size: float) -> Cells:
    """Return the cells of a mesh with the texture along vectors; RenderError if this mesh has none."""
    from geomhw.flow.convolution import cell_counts, convolved_noise

    counts = cell_counts(mesh, size)
    while (total := int((counts**2).sum())) > max(MOST_CELLS, 2 * mesh.n_faces):
        size *= 1.01 * np.sqrt(total / MOST_CELLS)
        counts = cell_counts(mesh, size)
    try:
        values = convolved_noise(mesh, face_field(mesh, arrows), counts, size)
    except GeomhwError as error:
        raise RenderError(f"a texture along vectors cannot be drawn: {error}") from error
    return Cells(counts, MEAN + CONTRAST * values)


def _lattice(n: int) -> tuple[Floats, Ints]:
    """Return barycentric coordinates of the points of a lattice, and its cells, as in `convolved_noise`."""
    row = np.repeat(np.arange(n + 1), np.arange(1, n + 2))
    column = np.arange(len(row)) - row * (row + 1) // 2
    weights = np.stack([n - row, row - column, column], axis=1) / n
    cell = np.arange(n * n)
    i = np.floor(np.sqrt(cell + 0.5)).astype(np.int64)
    j, k = np.divmod(cell - i * i, 2)
    here, below = i * (i + 1) // 2 + j, (i + 1) * (i + 2) // 2 + j
    return weights, np.stack([here, np.where(k == 0, below, below + 1), np.where(k == 0, below + 1, here + 1)], axis=1)


def _rgb(color: str) -> NDArray[np.uint8]:
    """Return the bytes of a color."""
    return np.frombuffer(bytes.fromhex(color[1:]), dtype=np.uint8)
