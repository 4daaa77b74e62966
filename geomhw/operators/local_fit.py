"""Quadratic least-squares fits at vertices: values and first derivatives of fields that are given on faces."""

from functools import cached_property
from typing import Literal

import numpy as np
import scipy.sparse as sp

from geomhw.arrays import Floats, Ints, scatter_add
from geomhw.mesh.geometry import unit
from geomhw.mesh.triangle_mesh import TriangleMesh

#: A fit takes the faces that touch the closed one-ring of its vertex, and further rings up to this many faces ...
ENOUGH = 12
#: ... but this many rings at most.
MOST_RINGS = 4
#: Squared singular values below this share of the largest are zero.
NEGLIGIBLE = 1e-10
#: Offsets of the face centers from the surface that are below this share of the radius of a fit are rounding.
FLAT = 1e-9
#: Weight that keeps the coefficient of the offsets small where they look like a quadratic.
RIDGE = 1e-4
#: Least cosine between the normals of a face and of the surface there; below it, their sides count in proportion.
STEEPEST = 0.1


class LocalFit:
    """Quadratics at each vertex, fitted to values at the centers of some 24 faces, as sparse operators.

    The coordinates x and y of a fit are along two axes near the tangent plane. Face centers lie off the smooth surface
    by O(h²), which differs from face to face. The offset is a seventh unknown of the fit, so that values of a smooth
    function in space and of a smooth function on the surface both have derivatives with an error of O(h²), on irregular
    meshes too.

    Parameters
    ----------
    mesh : oriented or not; the sign of ``normals`` is that of its vertex normals.
    degree : of the polynomials for values at vertices. Cubics have derivatives with an error of O(h³).

    Attributes
    ----------
    axes : (n, 2, 3) array, orthonormal; the directions of x and y.
    normals : (n, 3) array, unit normals of the fitted surface, with an error of O(h²).
    value : (n, m) sparse array, from values on faces to the value at each vertex, dimensionless.
    slopes : the two (n, m) sparse arrays of the derivatives in x and y, 1/length. Rows sum to zero.
    vertex_slopes : the two (n, n) sparse arrays of the derivatives in x and y of values at vertices.

    Raises
    ------
    MeshError
        If a face has zero area.

    References
    ----------
    Levin: The approximation power of moving least-squares, 1998.

    Examples
    --------
    >>> from geomhw.mesh import grid
    >>> mesh = grid(6, 6)
    >>> fit = LocalFit(mesh)
    >>> x = mesh.face_centers[:, 0]
    >>> gradient = np.einsum("ai,aix->ix", [D @ x**2 for D in fit.slopes], fit.axes.transpose(1, 0, 2))
    >>> bool(np.allclose(gradient[:, 0], 2 * mesh.vertices[:, 0]))
    True
    """

    def __init__(self, mesh: TriangleMesh, degree: Literal[2, 3] = 2) -> None:
        mesh.require_area()
        self.axes = mesh.tangent_frames
        corners = _incidence(mesh)
        near = _faces_near(corners)
        # Differences to a vertex are exact; face centers far from the origin are not.
        self._vertices = mesh.vertices - mesh.vertices[mesh.faces[0, 0]]
        _, *self.vertex_slopes = self._fit(mesh, _pairs(near @ corners), self._vertices, degree=degree)
        upward = [np.einsum("ix,ix->i", slope, mesh.vertex_normals) for slope in self.tangents(mesh.vertices)]
        self.normals = unit(mesh.vertex_normals - np.einsum("ai,iax->ix", upward, self.axes))
        self._mesh, self._near = mesh, near

    @property
    def value(self) -> sp.csr_array:
        """From values on faces to the value at each vertex."""
        return self._from_faces[0]

    @property
    def slopes(self) -> list[sp.csr_array]:
        """From values on faces to the derivatives at each vertex."""
        return self._from_faces[1:]

    @cached_property
    def _from_faces(self) -> list[sp.csr_array]:
        mesh = self._mesh
        centers = self._vertices[mesh.faces].mean(axis=1)
        outward = centers[:, None] - self._vertices[mesh.faces]
        offsets = np.einsum("fkx,fkx->f", outward, self._corner_normals(mesh)) / 6
        return self._fit(mesh, _pairs(self._near), centers, offsets)

    def _corner_normals(self, mesh: TriangleMesh) -> Floats:
        """Surface normals at the corners of faces, (m, 3, 3), on the side of the normal of the face.

        Those nearly orthogonal to it are shorter.
        """
        normals = self.normals[mesh.faces]
        side = _side(np.einsum("fkx,fx->fk", normals, mesh.face_normals))
        return side[:, :, None] * normals

    def tangents(self, positions: Floats) -> list[Floats]:
        """Return the derivatives in x and y of positions of the vertices, (n, 3); where they lie does not matter."""
        centered = positions - positions.mean(axis=0)  # else rounding grows with the distance from the origin
        return [np.asarray(D @ centered) for D in self.vertex_slopes]

    def onto_surface(self, field: Floats) -> Floats:
        """Return the tangent vectors of the smooth surface whose parts along the faces are a field, (m, 3).

        A face is tilted against the surface by O(h). That part along the faces has no second-order derivatives.
        """
        normals = self._mesh.face_normals
        cosine = np.maximum(np.einsum("fx,fx->f", normals, self._tilted), STEEPEST)
        height = np.einsum("fx,fx->f", field, self._tilted) / cosine
        return np.asarray(field - height[:, None] * normals)

    @cached_property
    def _tilted(self) -> Floats:
        """Mean normals of the surface at the corners of faces, (m, 3)."""
        return unit(self._corner_normals(self._mesh).sum(axis=1))

    def _fit(
        self,
        mesh: TriangleMesh,
        pairs: tuple[Ints, Ints],
        points: Floats,
        offsets: Floats | None = None,
        degree: Literal[2, 3] = 2,
    ) -> list[sp.csr_array]:
        """Operators from values at points, (k, 3), placed as ``_vertices``, to the value and the slopes at vertices.

        pairs: vertices and the points that their fits take. offsets: of points that are face centers, from the surface
        along the normals of the faces, (k,).
        """
        at, point = pairs
        n = mesh.n_vertices
        count = np.maximum(np.bincount(at, minlength=n), 1)
        apart = points[point] - self._vertices[at]
        x, y = np.einsum("px,pax->ap", apart, self.axes[at])
        radius = np.sqrt(scatter_add(x * x + y * y, at, n) / count)
        radius[radius == 0] = 1.0
        x, y = x / radius[at], y / radius[at]
        # Weights with which sums of squared coefficients, which decide where points are few, do not depend on the axes.
        columns = [np.ones_like(x), x, y, x * x, np.sqrt(2) * x * y, y * y]
        if degree == 3:
            columns += [x**3, np.sqrt(3) * x * x * y, np.sqrt(3) * x * y * y, y**3]
        if offsets is not None:
            side = _side(np.einsum("px,px->p", mesh.face_normals[point], mesh.vertex_normals[at]))
            z = side * offsets[point] / radius[at]
            z = z - (scatter_add(z, at, n) / count)[at]
            size = np.sqrt(scatter_add(z * z, at, n) / count)
            columns.append(z / np.where(size > FLAT, size, np.inf)[at])
        normal_equations = np.empty((n, len(columns), len(columns)))
        for i, one in enumerate(columns):
            for j, other in enumerate(columns[: i + 1]):
                normal_equations[:, i, j] = normal_equations[:, j, i] = scatter_add(one * other, at, n)
        # Points that do not determine a quadratic, such as two rows, have a linear fit.
        eigenvalues = np.linalg.eigvalsh(normal_equations[:, :6, :6])
        linear = eigenvalues[:, 0] <= NEGLIGIBLE * eigenvalues[:, -1]
        normal_equations[linear, 3:] = normal_equations[linear, :, 3:] = 0.0
        if offsets is not None:
            normal_equations[:, 6, 6] += RIDGE * count
        inverse = np.linalg.pinv(normal_equations, rcond=NEGLIGIBLE, hermitian=True)
        scales = np.stack([np.ones(n), 1 / radius, 1 / radius], axis=1)
        rows = (scales[:, :, None] * inverse[:, :3])[at]
        values = np.einsum("pij,jp->ip", rows, np.stack(columns))
        starts = np.searchsorted(at, np.arange(n + 1))
        return [sp.csr_array((row, point, starts), shape=(n, len(points))) for row in values]


def _side(cosine: Floats) -> Floats:
    """Return the sign of the cosine between two normals, without a jump where they are orthogonal."""
    return np.clip(cosine / STEEPEST, -1.0, 1.0)


def _incidence(mesh: TriangleMesh) -> sp.csr_array:
    """Matrix with a one for each corner of each face, (m, n)."""
    ones, starts = np.ones(mesh.faces.size), np.arange(0, mesh.faces.size + 1, 3)
    return sp.csr_array((ones, mesh.faces.ravel(), starts), shape=(mesh.n_faces, mesh.n_vertices))


def _faces_near(corners: sp.csr_array) -> sp.csr_array:
    """Matrix with an entry for each vertex and each face of its fit, (n, m)."""
    faces = corners.T.tocsr()
    neighbors = faces @ corners
    near = neighbors @ faces
    for _ in range(MOST_RINGS - 1):
        few = np.diff(near.indptr) < ENOUGH
        if not few.any():
            break
        # Adds the next ring to the rows with few faces; all entries stay positive.
        near = near + sp.diags_array(few.astype(float)) @ (neighbors @ near)
    return near


def _pairs(pattern: sp.csr_array) -> tuple[Ints, Ints]:
    """Row and column of each entry, sorted."""
    pattern.eliminate_zeros()
    pattern.sort_indices()
    return np.repeat(np.arange(pattern.shape[0]), np.diff(pattern.indptr)), pattern.indices
