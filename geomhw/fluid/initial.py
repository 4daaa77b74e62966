"""Initial velocities, by their vorticity or by the handles of the surface, and the force of the handout."""

from collections.abc import Mapping

import numpy as np

from geomhw.arrays import Floats
from geomhw.errors import ArgumentError
from geomhw.flow.tangent_fields import tangential
from geomhw.fluid.state import Force
from geomhw.fluid.vorticity import VorticityModel
from geomhw.mesh.triangle_mesh import TriangleMesh

#: A mesh counts as a sphere if its radii differ by less than this share of their mean.
ROUNDNESS = 0.01
#: Radius of a vortex, in mean edge lengths.
VORTEX_RADIUS = 2.0


def rossby_haurwitz(model: VorticityModel, degree: int) -> Floats:
    """Return the velocity of a Rossby-Haurwitz wave on a rigid rotation about z, one radian per unit of time.

    w = 2z + 2 Re(x+iy)ˡ for even degrees l. For odd degrees, w = 2z + 2z Re(x+iy)ˡ⁻¹ with the second term scaled to a
    maximum of 2. The exact wave turns at 1 - 2/(l(l+1)) radians per unit of time.

    Parameters
    ----------
    degree : l, at least 2.

    Returns
    -------
    (m, 3) array.

    Raises
    ------
    ArgumentError
        If the degree is less than 2 or above the number of vertices, or the mesh is not a sphere.

    References
    ----------
    Haurwitz: The motion of atmospheric disturbances on the spherical earth, 1940.
    """
    mesh = model.mesh
    if not 2 <= degree <= max(mesh.n_vertices, 2):
        raise ArgumentError(f"a Rossby-Haurwitz wave on this mesh has a degree of 2 to {mesh.n_vertices}, not {degree}")
    if not (mesh.is_closed and mesh.n_components == 1 and mesh.genus == 0):
        raise ArgumentError("a Rossby-Haurwitz wave needs a sphere; this mesh is not closed, connected and of genus 0")
    center = model.areas @ mesh.vertices / model.areas.sum()
    radii = np.linalg.norm(mesh.vertices - center, axis=1)[model.areas > 0]
    if np.ptp(radii) > ROUNDNESS * radii.mean():
        raise ArgumentError(
            f"a Rossby-Haurwitz wave needs a sphere; the radii of this mesh are {radii.min():.4g} to {radii.max():.4g}"
        )
    x, y, z = (mesh.vertices - center).T / radii.mean()
    order = degree - degree % 2
    wave = ((x + 1j * y) ** order).real
    if degree % 2:
        latitude = 1 / np.sqrt(order + 1)  # where z (1 - z²)^(order/2) is largest
        wave = wave * z / (latitude * (1 - latitude**2) ** (order / 2))
    return model.induced_velocity(model.from_vorticity(2 * z + 2 * wave)[0])


def vortices(model: VorticityModel, circulations: Mapping[int, float]) -> Floats:
    """Return the velocity of round vortices with a radius of two mean edge lengths.

    On a component whose circulations do not cancel, the rest is subtracted evenly.

    Parameters
    ----------
    circulations : circulation by vertex, length²/time.

    Returns
    -------
    (m, 3) array.

    Raises
    ------
    ArgumentError
        If a vertex does not exist or belongs to no face, or a circulation is not finite.
    """
    mesh = model.mesh
    points = np.zeros(mesh.n_vertices)
    for vertex, circulation in circulations.items():
        if not 0 <= vertex < mesh.n_vertices or model.areas[vertex] == 0:
            raise ArgumentError(f"vertex {vertex} of a vortex is not on the surface")
        if not np.isfinite(circulation):
            raise ArgumentError(f"the circulation of the vortex at vertex {vertex} is not finite")
        points[vertex] = circulation
    q = model.diffusion((VORTEX_RADIUS * mesh.mean_edge_length) ** 2)(points) * model.areas
    return model.induced_velocity(model.without_mean(q))


def harmonic(model: VorticityModel, number: int) -> Floats:
    """Return a harmonic field, (m, 3), with a largest speed of ten mean edge lengths per unit of time.

    Parameters
    ----------
    number : from 0 to 2g - 1.

    Raises
    ------
    ArgumentError
        If there is no such field.
    """
    count = len(model.harmonic)
    if not 0 <= number < count:
        known = f"0 to {count - 1}" if count else "none: it has no handles"
        raise ArgumentError(f"there is no harmonic field {number} on this mesh; there are {known}")
    V = model.harmonic[number]
    return np.asarray(10 * model.mesh.mean_edge_length / np.linalg.norm(V, axis=1).max() * V)


def top_jet(mesh: TriangleMesh, dt: float) -> Force:
    """Return the handout's force near the top of the mesh, (0.2 h/dt)(cos 0.2πt, sin 0.2πt, 0), its tangential part.

    It acts on the faces whose center lies within a twentieth of the z-extent below the highest vertex, and at least on
    the highest face [handout, eq. 10].

    Parameters
    ----------
    dt : time step of the run.
    """
    z = mesh.vertices[np.unique(mesh.faces), 2]
    height = mesh.face_centers[:, 2]
    near_top = height >= min(z.max() - 0.05 * np.ptp(z), height.max())
    strength = 0.2 * mesh.mean_edge_length / dt

    def force(time: float) -> Floats:
        angle = 0.2 * np.pi * time
        acceleration = strength * np.array([np.cos(angle), np.sin(angle), 0.0])
        return tangential(mesh, near_top[:, None] * acceleration)

    return force
