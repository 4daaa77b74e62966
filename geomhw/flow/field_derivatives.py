"""Derivatives of tangent fields: bracket, covariant derivative, divergence, curl, strain, Hodge Laplacian."""

import numpy as np
import scipy.sparse as sp

from geomhw.arrays import Floats, dot
from geomhw.flow.tangent_fields import tangential
from geomhw.mesh.cut import cut_into_sheets, means_of_copies
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.local_fit import LocalFit
from geomhw.results import Field, Result


class FieldDerivatives:
    """First derivatives of face fields on one mesh, with an error of O(h²) for samples of smooth fields.

    A `LocalFit` gives the derivative DV of the three components of V at vertices. Its tangential part is the covariant
    derivative; in the bracket the normal parts cancel. Results per face are means over the corners.

    All fields are (m, 3), one vector per face; normal parts are ignored. Derivatives do not pass pinched vertices and
    edges of more than two faces, where the mesh is cut: vectors and matrices at vertices are on ``surface``, numbers
    are means over the copies of a vertex.

    Parameters
    ----------
    mesh : need not be oriented; `curl` changes its sign with the orientation.

    Attributes
    ----------
    surface : TriangleMesh, the mesh cut into sheets; ``mesh`` itself if it is a manifold.
    fit : LocalFit, on ``surface``.

    Raises
    ------
    MeshError
        If a face has zero area.
    FieldError
        In each call, if a field has another shape or is not finite.

    References
    ----------
    Azencot, Ovsjanikov, Chazal, Ben-Chen: Discrete derivatives of vector fields on surfaces - an operator approach,
    2015.

    Examples
    --------
    The bracket of the rotations about x and y is that about z, with a minus.

    >>> from geomhw.flow import rigid_field
    >>> from geomhw.mesh import icosphere
    >>> mesh = icosphere(3)
    >>> X, Y, Z = (rigid_field(mesh, axis) for axis in np.eye(3))
    >>> bool(np.abs(FieldDerivatives(mesh).bracket(X, Y) + Z).max() < 0.005)
    True
    """

    def __init__(self, mesh: TriangleMesh) -> None:
        self.mesh = mesh
        self.surface, self._original = cut_into_sheets(mesh)
        self._means = means_of_copies(self.surface, self._original)
        self.fit = LocalFit(self.surface)

    def at_vertices(self, field: Floats) -> Floats:
        """Return a field at the vertices of ``surface``, (n', 3), tangent to the fitted surface."""
        return self._tangent(self.fit.value @ self._on_surface(field))

    def derivative(self, field: Floats) -> Floats:
        """Return DV at the vertices of ``surface``, (n', 3, 3): ``DV @ w`` is the change of V, in space, along w."""
        slopes = [D @ self._on_surface(field) for D in self.fit.slopes]
        return np.asarray(np.einsum("aix,iay->ixy", slopes, self.fit.axes))

    def covariant(self, field: Floats) -> Floats:
        """Return ∇V at the vertices of ``surface``, (n', 3, 3), tangential on both sides: ``∇V @ w`` is ∇_w V."""
        DV = self._tangent(self.derivative(field))
        return self._tangent(DV.transpose(0, 2, 1)).transpose(0, 2, 1)

    def covariant_derivative(self, field: Floats, along: Floats) -> Floats:
        """Return ∇_U V, (m, 3), of the field V along U."""
        return self.to_faces(np.einsum("ixy,iy->ix", self.covariant(field), self.at_vertices(along)))

    def bracket(self, first: Floats, second: Floats) -> Floats:
        """Return the Lie bracket [U, V], (m, 3), where [U, V] f = U(V f) - V(U f)."""
        return self.covariant_derivative(second, first) - self.covariant_derivative(first, second)

    def directional_derivative(self, field: Floats) -> sp.csr_array:
        """Assemble D_V from values at vertices to V · ∇f at vertices, (n, n), strong, with an error of O(h²).

        `geomhw.operators.directional_derivative` is skew-adjoint for divergence-free fields instead, with O(h).
        """
        components = np.einsum("ix,iax->ai", self.at_vertices(field), self.fit.axes)
        along_x, along_y = (sp.diags_array(v) @ D for v, D in zip(components, self.fit.vertex_slopes, strict=True))
        copies = self._means.astype(bool).astype(float).T
        return (self._means @ (along_x + along_y) @ copies).tocsr()

    def commutator(self, first: Floats, second: Floats) -> sp.csr_array:
        """Assemble D_U D_V - D_V D_U, (n, n), strong: the bracket [U, V] as an operator on functions at vertices."""
        U, V = self.directional_derivative(first), self.directional_derivative(second)
        return (U @ V - V @ U).tocsr()

    def divergence(self, field: Floats) -> Floats:
        """Return div V at the vertices, (n,), strong."""
        return np.asarray(self._means @ self._divergence(field))

    def curl(self, field: Floats) -> Floats:
        """Return curl V at the vertices, (n,), strong; positive counterclockwise seen from outside."""
        return np.asarray(self._means @ self._curl(field))

    def strain(self, field: Floats) -> Floats:
        """Return the deformation tensor, (m, 3, 3): the symmetric part of ∇V. Zero for isometric flows."""
        D = self.covariant(field)
        mean = ((D + D.transpose(0, 2, 1)) / 2)[self.surface.faces].mean(axis=1)
        n = self.mesh.face_normals
        P = np.eye(3) - n[:, :, None] * n[:, None, :]
        return np.asarray(P @ mean @ P)

    def hodge_laplacian(self, field: Floats) -> Floats:
        """Return the Hodge Laplacian -∇ div V - n x ∇ curl V, (m, 3), strong, with nonnegative eigenvalues.

        Second derivatives have an error of O(h) on irregular meshes.
        """
        slopes = self._gradient(self._divergence(field))
        turned = np.cross(self.fit.normals, self._gradient(self._curl(field)))
        return self.to_faces(-slopes - turned)

    def to_faces(self, vectors: Floats) -> Floats:
        """Return the tangential part of the mean over the corners of each face, (m, 3), of vectors on ``surface``."""
        return tangential(self.mesh, vectors[self.surface.faces].mean(axis=1))

    def _divergence(self, field: Floats) -> Floats:
        """Divergence at the vertices of the cut mesh."""
        return np.asarray(np.einsum("ixx->i", self.covariant(field)))

    def _curl(self, field: Floats) -> Floats:
        """Curl at the vertices of the cut mesh."""
        D, n = self.covariant(field), self.fit.normals
        turns = np.stack([D[:, k - 1, k - 2] - D[:, k - 2, k - 1] for k in range(3)], axis=1)
        return np.asarray(np.einsum("ix,ix->i", n, turns))

    def _gradient(self, function: Floats) -> Floats:
        """Gradient at vertices, (n, 3), of a function at vertices, (n,)."""
        slopes = [D @ function for D in self.fit.vertex_slopes]
        return self._tangent(np.einsum("ai,iax->ix", slopes, self.fit.axes))

    def _on_surface(self, field: Floats) -> Floats:
        """Tangent vectors of the smooth surface, (m, 3)."""
        return self.fit.onto_surface(tangential(self.mesh, field))

    def _tangent(self, vectors: Floats) -> Floats:
        """Tangential part at vertices of vectors, or of the columns of matrices, (n, 3, ...)."""
        n = self.fit.normals
        normal_part = np.einsum("ix,ix...->i...", n, vectors)
        return np.asarray(vectors - np.einsum("ix,i...->ix...", n, normal_part))


def derivatives_of(mesh: TriangleMesh, field: Floats, along: Floats) -> Result:
    """Compute all derivatives of one field.

    Parameters
    ----------
    field, along : V and U, (m, 3).

    Returns
    -------
    Result. Per face: ``field``, ``covariant_derivative`` ∇_U V, ``strain``, (m, 9), row by row, ``hodge_laplacian``.
    Per vertex: ``divergence``, ``curl``. The report has the root mean square of each over the surface.

    Raises
    ------
    MeshError
        If a face has zero area, or the mesh is not an oriented manifold.
    FieldError
        If a field has another shape or is not finite.
    """
    mesh.require_oriented("the curl")
    derivatives = FieldDerivatives(mesh)
    fields = [
        Field("field", "face", tangential(mesh, field)),
        Field("covariant_derivative", "face", derivatives.covariant_derivative(field, along)),
        Field("strain", "face", derivatives.strain(field).reshape(-1, 9)),
        Field("hodge_laplacian", "face", derivatives.hodge_laplacian(field)),
        Field("divergence", "vertex", derivatives.divergence(field)),
        Field("curl", "vertex", derivatives.curl(field)),
    ]
    return Result(mesh, fields, {"root_mean_square": {item.name: _root_mean_square(mesh, item) for item in fields}})


def _root_mean_square(mesh: TriangleMesh, field: Field) -> float:
    """Root of the mean of |values|² over the surface."""
    areas = mesh.face_areas if field.location == "face" else mesh.vertex_areas
    rows = np.asarray(field.values).reshape(len(areas), -1)
    return float(np.sqrt(dot(areas, np.einsum("rx,rx->r", rows, rows)) / areas.sum()))
