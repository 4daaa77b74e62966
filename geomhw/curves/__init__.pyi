from .isolines import Isolines as Isolines
from .isolines import isolines as isolines
from .isolines import levels_between as levels_between
from .split import SplitMesh as SplitMesh
from .split import split_mesh as split_mesh
from .traced import TracedCurve as TracedCurve
from .traced import trace_points as trace_points
from .traced import trace_polyline as trace_polyline
