"""One file a mesh format and direction; readers take the name and the bytes of a file and are imported when used."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
