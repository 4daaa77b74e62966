"""The schemes by name."""

from typing import Literal, get_args

from geomhw.errors import FieldError
from geomhw.fluid.conservative import ConservativeScheme
from geomhw.fluid.rk4 import RK4Scheme
from geomhw.fluid.stable_fluids import Advection, StableFluidsScheme
from geomhw.fluid.state import Scheme
from geomhw.mesh.triangle_mesh import TriangleMesh

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
        return StableFluidsScheme(mesh, advection)
    if name == "conservative":
        return ConservativeScheme(mesh, filter, viscosity)
    if name == "fast":
        return RK4Scheme(mesh, filter, viscosity)
    raise FieldError(f"there is no scheme '{name}'; choose from {', '.join(get_args(SchemeName))}")
