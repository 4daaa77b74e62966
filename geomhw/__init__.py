"""Geometry on triangle meshes: geodesic distance, vector transport, advection and flow.

Everything named in ``__all__`` can be imported from here; what it needs is loaded when it is first used.
"""

from importlib import import_module
from typing import Any

__version__ = "0.1.0"

_HOMES = {
    "TriangleMesh": "geomhw.mesh.triangle_mesh",
    "HeatDistance": "geomhw.methods.heat_distance",
    "heat_distance": "geomhw.methods.heat_distance",
    "Sources": "geomhw.methods.sources",
    "VectorHeat": "geomhw.methods.vector_heat",
    "FlowMap": "geomhw.methods.advection",
    "Tracer": "geomhw.methods.tracing",
    "scheme_of": "geomhw.methods.fluid.schemes",
    "RobustTriangulation": "geomhw.mesh.robust",
    "HelmholtzDecomposition": "geomhw.methods.helmholtz",
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
