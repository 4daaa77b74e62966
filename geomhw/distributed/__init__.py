"""Distances and vectors on meshes beyond the memory of one machine: MPI ranks with a part of the mesh each."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
