from .isolines import Isolines as Isolines
from .isolines import isolines as isolines
from .isolines import levels_between as levels_between
