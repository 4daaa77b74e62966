"""Pictures and film frames of results, as arrays of RGB pixels, drawn off screen."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
