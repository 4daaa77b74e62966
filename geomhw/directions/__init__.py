"""Direction fields: n unit directions at each vertex, smooth, constrained, with given singularities."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
