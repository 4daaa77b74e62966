"""Eigenfunctions of Laplacians, and what is made of them: signatures and spectral distances."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
