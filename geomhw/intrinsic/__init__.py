"""Intrinsic triangulations: surfaces given by edge lengths, tufted covers, Delaunay flips."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
