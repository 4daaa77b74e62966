"""The schemes by name."""

from typing import get_args

from geomhw.errors import FieldError
from geomhw.fluid.conservative import ConservativeScheme
from geomhw.fluid.rk4 import RK4Scheme
from geomhw.fluid.stable_fluids import StableFluidsScheme
from geomhw.fluid.state import Scheme
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.options import Advection, SchemeName


def scheme_of(
    mesh: TriangleMesh,
    name: SchemeName,
    *,
    advection: Advection = "full",
    filter: bool = True,
    viscosity: float = 0.0,
) -> Scheme:
    """The scheme of that name; advection is the handout's, filter and viscosity the others'. FieldError for no name."""
    if name == "stable-fluids":
        if viscosity:
            raise FieldError("stable-fluids has no viscosity of its own; choose another scheme")
        return StableFluidsScheme(mesh, advection)
    if name == "conservative":
        return ConservativeScheme(mesh, filter, viscosity)
    if name == "rk4":
        return RK4Scheme(mesh, filter, viscosity)
    raise FieldError(f"there is no scheme '{name}'; choose from {', '.join(get_args(SchemeName))}")
