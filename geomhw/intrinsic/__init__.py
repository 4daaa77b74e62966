"""Intrinsic triangulations: a surface known by its edge lengths, flipped to Delaunay."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
