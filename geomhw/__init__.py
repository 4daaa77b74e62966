"""Geometry on triangle meshes: geodesic distance, vector transport, advection and flow.

Everything named in ``__all__`` can be imported from here; what it needs is loaded when it is first used.
"""

from importlib import import_module
from typing import Any

__version__ = "0.1.0"

_HOMES = {
    "TriangleMesh": "geomhw.mesh.triangle_mesh",
    "HeatDistance": "geomhw.geodesic.heat_method",
    "heat_distance": "geomhw.geodesic.heat_method",
    "SurfacePoints": "geomhw.mesh.surface_points",
    "VectorHeat": "geomhw.transport.vector_heat",
    "FlowMap": "geomhw.flow.flow_map",
    "Tracer": "geomhw.flow.tracer",
    "scheme_of": "geomhw.fluid.schemes",
    "RobustTriangulation": "geomhw.intrinsic.robust",
    "HelmholtzDecomposition": "geomhw.flow.helmholtz",
    "Field": "geomhw.results",
    "Result": "geomhw.results",
    "read": "geomhw.io",
    "read_mesh": "geomhw.io",
    "write": "geomhw.io",
}
__all__ = list(_HOMES)


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'geomhw' has no attribute '{name}'")
    return getattr(import_module(_HOMES[name]), name)
