"""The schemes by name."""

from typing import Literal, get_args

from geomhw.errors import FieldError
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.methods.fluid.conservative import ConservativeScheme
from geomhw.methods.fluid.runge_kutta import FastScheme
from geomhw.methods.fluid.splitting import Advection, SplittingScheme
from geomhw.methods.fluid.state import Scheme

SchemeName = Literal["conservative", "fast", "handout"]


def scheme_of(
    mesh: TriangleMesh,
    name: SchemeName,
    *,
    advection: Advection = "full",
    filter: bool = True,
    viscosity: float = 0.0,
) -> Scheme:
    """The scheme of that name; advection is the handout's, filter and viscosity the others'. FieldError for no name."""
    if name == "handout":
        if viscosity:
            raise FieldError("the handout's scheme has no viscosity of its own; choose another scheme")
        return SplittingScheme(mesh, advection)
    if name == "conservative":
        return ConservativeScheme(mesh, filter, viscosity)
    if name == "fast":
        return FastScheme(mesh, filter, viscosity)
    raise FieldError(f"there is no scheme '{name}'; choose from {', '.join(get_args(SchemeName))}")
