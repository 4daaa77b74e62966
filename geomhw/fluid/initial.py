"""Flows to start from, given by their vorticity or by the handles of the surface; each as a velocity per face."""

from collections.abc import Mapping

import numpy as np

from geomhw.arrays import Floats
from geomhw.errors import FieldError
from geomhw.fluid.vorticity import VorticityModel

#: A mesh is a sphere if its radii are within this share of their mean.
ROUNDNESS = 0.01
#: Radius of a vortex, in mean edge lengths.
VORTEX_RADIUS = 2.0


def rossby_haurwitz(model: VorticityModel, degree: int) -> Floats:
    """Velocity of a wave of that degree on a solid rotation, one radian a unit of time about z, (m, 3).

    w = 2z + 2 Re(x+iy)ˡ, for odd degrees l 2z + 2z Re(x+iy)ˡ⁻¹ with the second term scaled to a maximum of 2. The exact
    wave turns at 1 - 2/(l(l+1)) radians a unit of time [Haurwitz 1940]. FieldError unless the mesh is a sphere.
    """
    if degree < 2:
        raise FieldError(f"a Rossby-Haurwitz wave has a degree of 2 or more, not {degree}")
    mesh = model.mesh
    if not (mesh.is_closed and mesh.n_components == 1 and mesh.genus == 0):
        raise FieldError("a Rossby-Haurwitz wave lives on a sphere; this mesh is none")
    center = model.areas @ mesh.vertices / model.areas.sum()
    radii = np.linalg.norm(mesh.vertices - center, axis=1)[model.areas > 0]
    if np.ptp(radii) > ROUNDNESS * radii.mean():
        raise FieldError(
            f"a Rossby-Haurwitz wave lives on a sphere; radii here go from {radii.min():.4g} to {radii.max():.4g}"
        )
    x, y, z = (mesh.vertices - center).T / radii.mean()
    order = degree - degree % 2
    wave = ((x + 1j * y) ** order).real
    if degree % 2:
        latitude = 1 / np.sqrt(order + 1)  # where z (1 - z²)^(order/2) is largest
        wave = wave * z / (latitude * (1 - latitude**2) ** (order / 2))
    return _velocity(model, model.from_vorticity(2 * z + 2 * wave))


def vortices(model: VorticityModel, circulations: Mapping[int, float]) -> Floats:
    """Velocity of round vortices at vertices, (m, 3), each of that circulation and two mean edge lengths in radius.

    On a component whose vortices do not cancel, the rest is spread evenly. FieldError for a vertex off the surface.
    """
    mesh = model.mesh
    points = np.zeros(mesh.n_vertices)
    for vertex, circulation in circulations.items():
        if not 0 <= vertex < mesh.n_vertices or model.areas[vertex] == 0:
            raise FieldError(f"vertex {vertex} of a vortex is not on the surface")
        if not np.isfinite(circulation):
            raise FieldError(f"the circulation of the vortex at vertex {vertex} is not finite")
        points[vertex] = circulation
    spread = model.diffusion((VORTEX_RADIUS * mesh.mean_edge_length) ** 2)(points) * model.areas
    return _velocity(model, model.centered(spread))


def harmonic(model: VorticityModel, number: int) -> Floats:
    """The harmonic field of that number, (m, 3), its fastest part ten mean edge lengths a unit of time."""
    count = len(model.harmonic)
    if not 0 <= number < count:
        known = f"0 to {count - 1}" if count else "none: it has no handles"
        raise FieldError(f"there is no harmonic field {number} on this mesh; there are {known}")
    V = model.harmonic[number]
    return np.asarray(10 * model.mesh.mean_edge_length / np.linalg.norm(V, axis=1).max() * V)


def _velocity(model: VorticityModel, q: Floats) -> Floats:
    """n x ∇ψ of an integrated vorticity, with no circulation round boundaries beyond what it makes."""
    psi = model.stream_function(q, np.zeros(model.n_unknowns))
    return model.velocity(psi, np.zeros(len(model.harmonic)))
