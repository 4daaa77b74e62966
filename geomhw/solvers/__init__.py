"""Solvers for sparse systems and exponentials of sparse matrices. They know matrices only, no meshes."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
