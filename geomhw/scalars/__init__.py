"""Functions on the vertices of a mesh: smoothing, extrema, regions round points."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
