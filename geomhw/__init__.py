"""Geometry on triangle meshes: geodesic distance, vector transport, advection and flow.

The names of ``dir(geomhw)`` and of each of its packages are loaded when first used.
"""

import lazy_loader

__version__ = "0.1.0"

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
